#include "programs/benchmark/front.h"

#include <cstdlib>

#include "programs/started_programs.h"

namespace corrsel {

namespace fs = std::filesystem;

fs::path BenchmarkFront::runsFolder() const {
  const char* const data = std::getenv("XDG_DATA_HOME");
  const char* const home = std::getenv("HOME");
  const fs::path root =
      data && *data ? fs::path(data) : fs::path(home && *home ? home : ".") / ".local/share";
  return root / "corrsel";
}

std::string BenchmarkFront::argument(const std::string& name, const std::string& value) const {
  return "--" + name + (value == "true" ? "" : " " + value);
}

std::string BenchmarkFront::fetchCommand() const {
  const fs::path script = fetchScript();
  return script.empty() ? "scripts/fetch_samples.sh of corrsel's sources" : script.string();
}

std::string BenchmarkFront::reportCommand() const {
  // Python finds the package by itself where it is installed by Debian's package.
  const std::string python = pythonPath();
  return (python.empty() ? "" : "PYTHONPATH=" + python + " ") + "python3 -m corrsel.report";
}

fs::path BenchmarkFront::fetchScript() const { return findBesideProgram("fetch_samples.sh"); }

OpenedBag BenchmarkFront::openBag(const std::string& path, const core::BenchmarkConfig&) const {
  throw UsageError("bag '" + path +
                   "' is given, but corrsel_benchmark reads folders only; the package that is built with ROS "
                   "reads bags: rosrun corrsel benchmark");
}

std::unique_ptr<Reporter> BenchmarkFront::startReporter(const Arguments& arguments) {
  return std::make_unique<Reporter>(arguments.verbose);
}

}  // namespace corrsel
