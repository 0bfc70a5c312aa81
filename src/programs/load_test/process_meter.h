#pragma once

#include <string>
#include <vector>

namespace corrsel::load_test {

/// A process that publishes results for the test.
struct Process {
  int pid;
  std::string node;
};

/// Processor time and memory of the processes behind topics, from /proc.
class ProcessMeter {
 public:
  /// Asks the master for the publishers of the topics, and these for their process numbers. Nodes on other
  /// machines and nodes that do not reply are left out and noted.
  explicit ProcessMeter(const std::vector<std::string>& topics);

  /// One sentence about the processes found and left out.
  std::string text() const;

  bool empty() const { return processes_.empty(); }

  /// Sums over the processes.
  struct Usage {
    double cpu_seconds = 0.0;
    double resident_mib = 0.0;
    std::vector<std::string> ended;  ///< nodes whose process is gone
  };
  Usage read() const;

 private:
  std::vector<Process> processes_;
  std::vector<std::string> notes_;
};

}  // namespace corrsel::load_test
