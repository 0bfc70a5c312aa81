#include "benchmark/environment.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/version.hpp>
#include <thread>

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

}  // namespace

std::string environmentJson(int threads) {
  nlohmann::ordered_json json;
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
  json["cpu_governor"] =
      std::getline(governor, text) ? nlohmann::ordered_json(text) : nlohmann::ordered_json(nullptr);
  return json.dump(2) + "\n";
}

}  // namespace corrsel::core
