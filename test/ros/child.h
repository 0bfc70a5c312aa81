#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace corrsel::testing {

/// A program as a child process with a group of its own; ended with Ctrl-C, and with force where that does
/// not help.
class Child {
 public:
  /// @param words        program and arguments
  /// @param environment  set for it: {"ROS_MASTER_URI", "http://localhost:11400"}
  /// @param log          file that takes what it prints; empty: goes where this process's goes
  explicit Child(std::vector<std::string> words,
                 const std::vector<std::pair<std::string, std::string>>& environment = {},
                 const std::string& log = "")
      : pid_(fork()) {
    if (pid_ != 0) return;
    setpgid(0, 0);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    if (!log.empty()) {
      const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      dup2(file, 1);
      dup2(file, 2);
    }
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ~Child() {
    if (pid_ <= 0 || done_) return;
    signalAll(SIGINT);
    if (!wait(std::chrono::seconds(20))) {
      signalAll(SIGKILL);
      wait(std::chrono::seconds(20));
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// To all processes that it has started, too.
  void signalAll(int signal) { kill(-pid_, signal); }

  bool running() { return !wait(std::chrono::seconds(0)); }

  /// @return whether it has ended in time
  bool wait(std::chrono::seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (!done_) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        done_ = true;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        break;
      }
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

  /// Exit code, 128 + signal where one ended it, -1 while it runs.
  int code() const { return code_; }

 private:
  pid_t pid_;
  bool done_ = false;
  int code_ = -1;
};

}  // namespace corrsel::testing
