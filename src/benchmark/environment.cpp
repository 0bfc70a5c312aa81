#include "benchmark/environment.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/version.hpp>
#include <thread>

#include "base/ordered_json.h"
#include "base/text.h"
#include "benchmark/files.h"
#include "corrsel/benchmark/results.h"
#include "kernels/kernels.h"

#ifndef CORRSEL_VERSION
#define CORRSEL_VERSION "unknown"
#endif
#ifndef CORRSEL_COMMIT
#define CORRSEL_COMMIT "unknown"
#endif
#ifndef CORRSEL_BUILD_TYPE
#define CORRSEL_BUILD_TYPE "unknown"
#endif

namespace corrsel::core {
namespace {

/// Value of the first line of a "key : value" file that starts with the key; empty if there is none.
std::string firstValue(const char* file, const std::string& key) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.compare(0, key.size(), key) != 0) continue;
    const std::size_t begin = line.find_first_not_of(" \t", line.find(':') + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

/// What this program runs on, as a flat object.
OrderedJson environment(int threads) {
  OrderedJson json;
  json["corrsel_version"] = CORRSEL_VERSION;
  json["corrsel_commit"] = CORRSEL_COMMIT;
  json["build_type"] = CORRSEL_BUILD_TYPE;
  json["compiler"] = std::string(
#ifdef __clang__
                         "clang "
#else
                         "gcc "
#endif
                         ) +
                     __VERSION__;
  json["opencv"] = CV_VERSION;
  json["kernels"] = toString(kernelLevel());
  json["cpu"] = firstValue("/proc/cpuinfo", "model name");
  json["cores"] = std::thread::hardware_concurrency();
  json["memory"] = firstValue("/proc/meminfo", "MemTotal");
  json["threads"] = threads;
  utsname system{};
  if (uname(&system) == 0) {
    json["system"] = std::string(system.sysname) + " " + system.release + " " + system.machine;
    json["host"] = system.nodename;
  }
  std::ifstream release("/etc/os-release");
  json["distribution"] = nullptr;
  for (std::string line; std::getline(release, line);) {
    if (line.compare(0, 13, "PRETTY_NAME=\"") == 0) json["distribution"] = line.substr(13, line.size() - 14);
  }
  std::ifstream governor("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  std::string text;
  json["cpu_governor"] = std::getline(governor, text) ? OrderedJson(text) : OrderedJson(nullptr);
  return json;
}

std::string fileIn(const std::string& folder) {
  return (std::filesystem::path(folder) / "environment.json").string();
}

}  // namespace

std::string environmentJson(int threads) { return environment(threads).dump(2) + "\n"; }

void writeEnvironment(const std::string& folder, int threads) {
  OrderedJson json = environment(threads);
  const auto before = OrderedJson::parse(readTextFile(fileIn(folder)), nullptr, false);
  if (before.is_object() && before.contains("merged_from")) json["merged_from"] = before["merged_from"];
  writeFile(fileIn(folder), json.dump(2) + "\n");
}

void addMergedEnvironment(const std::string& folder, const std::string& from, std::size_t pairs) {
  OrderedJson json, other;
  try {
    json = OrderedJson::parse(readTextFile(fileIn(folder)));
    other = OrderedJson::parse(readTextFile(fileIn(from)));
  } catch (const OrderedJson::exception& problem) {
    throw RunFolderError("cannot merge " + from + ": environment.json is damaged (" + problem.what() + ")");
  }
  other["pairs"] = pairs;
  json["merged_from"].push_back(other);
  writeFile(fileIn(folder), json.dump(2) + "\n");
}

}  // namespace corrsel::core
