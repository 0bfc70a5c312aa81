// Each launch file runs this program while roslaunch reads it: roslaunch ignores arguments that the file does
// not declare, so that a misspelt one would have no effect. Where an argument is wrong, the program names it,
// and its exit code makes roslaunch stop before anything is started. It prints the arguments, which roslaunch
// stores as a parameter.

#include <unistd.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "base/text.h"
#include "programs/launch_arguments.h"

namespace {

namespace core = corrsel::core;

constexpr int kOk = 0, kUsageError = 2;

/// The words of a process's command line.
std::vector<std::string> commandOf(pid_t process) {
  return core::splitList(core::readTextFile("/proc/" + std::to_string(process) + "/cmdline"), '\0');
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: check_arguments LAUNCH_FILE (the launch files of corrsel run this program)\n";
    return kUsageError;
  }
  const std::filesystem::path launch_file = argv[1];
  try {
    std::error_code ignored;
    const pid_t parent = getppid();
    const auto folder = std::filesystem::read_symlink("/proc/" + std::to_string(parent) + "/cwd", ignored);
    std::cout << core::joinList(
        corrsel::launchArguments(commandOf(parent), folder.string(), "corrsel", launch_file.string()), " ");
    return kOk;
  } catch (const std::exception& error) {
    std::cerr << launch_file.filename().string() << ": " << error.what() << std::endl;
  }
  return kUsageError;
}
