#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace corrsel {

/// A script of the package that lies beside this program, or in share/corrsel of its prefix; empty if none.
std::filesystem::path findBesideProgram(const std::string& script);

/// The folders of this prefix that hold the Python package, for PYTHONPATH; empty where it is not there.
std::string pythonPath();

/// Runs a program and waits for it. @return its exit code, 127 if it could not be started
int runProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments);

/// Runs `python3 -m MODULE ARGUMENTS` with the system's Python. @return as runProgram()
int runPython(const std::string& module, const std::vector<std::string>& arguments);

}  // namespace corrsel
