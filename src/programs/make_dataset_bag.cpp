#include <algorithm>
#include <exception>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/text.h"
#include "benchmark/dataset_check.h"
#include "corrsel/datasets/reader.h"
#include "datasets/dataset_report.h"
#include "programs/command_line.h"
#include "ros/bags/dataset_bag_writer.h"

namespace {

constexpr int kOk = 0, kProblems = 1, kUsageError = 2;

struct Arguments {
  std::string dataset, path, output;
  corrsel::DatasetBagOptions bag;
  int seed = 0;
  bool check = false;
};

corrsel::CommandLineTable argumentTable() {
  const corrsel::DatasetBagOptions defaults;
  return {"make_dataset_bag",
          "Writes a dataset as a bag that the benchmark and the nodelets read, or checks it with --check.",
          {},
          {
              {"dataset", "NAME", "",
               corrsel::core::joinList(corrsel::core::datasetNames()) +
                   "; or any other name: the layout is then recognised from the files"},
              {"path", "FOLDER", "", "folder of the dataset"},
              {"output", "FILE.bag", "", "the bag to write; an existing file is replaced"},
              {"check", "", "",
               "decode everything and report what the folder holds, what it lacks, which pairs are broken, "
               "and whose sizes or ground truth contradict the images; write no bag"},
              {"compressed", "", "", "write the images as PNG (smaller, slower) instead of raw"},
              {"period", "S", corrsel::core::formatNumber(defaults.period), "time between two pairs, s"},
              {"seed", "N", "0", "seed of datasets that generate pairs"},
          },
          "exit code: 0 = all pairs written (--check: no pair is broken, odd or doubtful), 1 = "
          "problems,\n"
          "which are listed, 2 = wrong arguments\n"};
}

/// Throws corrsel::UsageError.
Arguments argumentsOf(const corrsel::ArgumentValues& values) {
  Arguments arguments;
  arguments.check = values.isOn("check");
  for (const auto& [name, text] :
       {std::pair{"dataset", &arguments.dataset}, std::pair{"path", &arguments.path},
        std::pair{"output", &arguments.output}}) {
    *text = values.text(name);
    const bool needed = text != &arguments.output || !arguments.check;
    if (needed && text->empty()) throw corrsel::UsageError(std::string("--") + name + " is missing");
  }
  arguments.bag.compressed = values.isOn("compressed");
  arguments.bag.period = values.number("period");
  arguments.seed = values.integer("seed", 0, std::numeric_limits<int>::max());
  return arguments;
}

void printNotes(const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks) std::cout << "note: " << remark << "\n";
}

/// Decodes all pairs and prints what is broken, odd or doubtful. @return whether nothing is
bool check(const corrsel::core::DatasetReader& reader) {
  corrsel::core::PairInspector inspector(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  const corrsel::core::DatasetReport report =
      corrsel::core::describe(reader, corrsel::core::evenlySpaced(reader.size(), reader.size()),
                              {[&inspector](const corrsel::core::ImagePair& pair) { inspector.add(pair); }});
  std::cout << report.text();
  printNotes(reader.remarks());
  const std::vector<std::string> findings = inspector.findings();
  for (const std::string& finding : findings) std::cout << finding << "\n";
  return report.problems.empty() && findings.empty();
}

int run(const Arguments& arguments) {
  const std::unique_ptr<corrsel::core::DatasetReader> reader =
      corrsel::core::openDataset(arguments.dataset, arguments.path, arguments.seed);
  if (arguments.check) return check(*reader) ? kOk : kProblems;
  std::cout << corrsel::core::describe(*reader, {}).text() << std::flush;
  std::vector<corrsel::UnreadablePair> problems;
  std::vector<std::string> remarks;
  const auto progress = [](std::size_t done, std::size_t total, const corrsel::core::PairId& id) {
    std::cout << done << "/" << total << " " << id.text() << std::endl;
  };
  const std::size_t written =
      corrsel::writeDatasetBag(*reader, arguments.output, arguments.bag, progress, &problems, &remarks);
  printNotes(remarks);
  for (const corrsel::UnreadablePair& problem : problems) {
    std::cerr << "problem: " << problem.text() << "\n";
  }
  std::cout << written << " of " << reader->size() << " pairs written"
            << (written > 0 ? " to " + arguments.output : ", no bag made") << std::endl;
  return problems.empty() && written > 0 ? kOk : kProblems;
}

}  // namespace

int main(int argc, char** argv) {
  const corrsel::CommandLineTable table = argumentTable();
  try {
    const corrsel::ArgumentValues values = corrsel::parseCommandLine(table, {argv + 1, argv + argc});
    if (values.help) {
      std::cout << corrsel::helpText(table);
      return kOk;
    }
    return run(argumentsOf(values));
  } catch (const std::invalid_argument& error) {
    std::cerr << "make_dataset_bag: " << error.what() << "\n\n" << corrsel::helpText(table);
    return kUsageError;
  } catch (const std::exception& error) {
    std::cerr << "make_dataset_bag: " << error.what() << "\n";
    return kProblems;
  }
}
