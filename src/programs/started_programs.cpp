#include "programs/started_programs.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <iostream>
#include <system_error>

namespace corrsel {
namespace {

namespace fs = std::filesystem;

fs::path programFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// Puts `first` before what a variable of the environment holds.
void prepend(const char* name, const std::string& first) {
  const std::string before = variable(name);
  setenv(name, (before.empty() ? first : first + ":" + before).c_str(), 1);
}

}  // namespace

fs::path findBesideProgram(const std::string& script) {
  const fs::path here = programFolder();
  for (const fs::path& folder : {here, here / "../share/corrsel"}) {
    if (fs::exists(folder / script)) return (folder / script).lexically_normal();
  }
  return {};
}

std::string pythonPath() {
  const fs::path here = programFolder();
  // In the build folder, and where the package is installed.
  for (const fs::path& folder : {here / "../python", here / CORRSEL_PYTHON_FROM_PROGRAM}) {
    if (fs::exists(folder / "corrsel")) return folder.lexically_normal().string();
  }
  return "";
}

int runProgram(const fs::path& program, const std::vector<std::string>& arguments) {
  std::cout.flush();
  const pid_t child = fork();
  if (child < 0) return 127;
  if (child == 0) {
    // The system's Python: another one may come first in PATH and lack the packages. The report calls
    // programs that lie beside this one.
    prepend("PATH", "/usr/bin:/bin:" + programFolder().string());
    const std::string python = pythonPath();
    if (!python.empty()) prepend("PYTHONPATH", python);
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), program.string());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execvp(program.c_str(), argv.data());
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}

int runPython(const std::string& module, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"-m", module};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return runProgram("python3", words);
}

}  // namespace corrsel
