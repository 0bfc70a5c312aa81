#include "reconfigurer.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <dynamic_reconfigure/config_tools.h>
#include <ros/ros.h>

#include <chrono>
#include <cmath>

#include "base/stopwatch.h"

namespace corrsel::load_test {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigTools;

/// Numbers that are changed, within ranges that cost about the same time.
struct Range {
  const char* name;
  double low, high;
};
constexpr Range kNumbers[] = {{"gms_alpha", 3, 8},
                              {"lpm_lambda_first", 4, 8},
                              {"ransac_threshold", 2, 10},
                              {"nnsr_max_threshold", 0.6, 0.9},
                              {"usac_threshold", 1, 5}};

bool inForce(const Config& asked, const Config& answer) {
  for (const auto& wanted : asked.strs) {
    std::string value;
    if (!ConfigTools::getParameter(answer, wanted.name, value) || value != wanted.value) return false;
  }
  for (const auto& wanted : asked.doubles) {
    double value = 0.0;
    if (!ConfigTools::getParameter(answer, wanted.name, value) || std::abs(value - wanted.value) > 1e-9) {
      return false;
    }
  }
  for (const auto& wanted : asked.ints) {
    int value = 0;
    if (!ConfigTools::getParameter(answer, wanted.name, value) || value != wanted.value) return false;
  }
  for (const auto& wanted : asked.bools) {
    bool value = false;
    if (!ConfigTools::getParameter(answer, wanted.name, value) || value != static_cast<bool>(wanted.value)) {
      return false;
    }
  }
  return true;
}

}  // namespace

Reconfigurer::Reconfigurer(const Arguments& arguments)
    : arguments_(arguments), random_(static_cast<std::uint64_t>(arguments.seed)) {
  if (arguments_.reconfigure > 0.0) thread_ = std::thread([this] { run(); });
}

Reconfigurer::~Reconfigurer() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

Reconfigurer::Calls Reconfigurer::calls() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return calls_;
}

void Reconfigurer::run() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kTick(50);  // how soon it notices the end
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(arguments_.reconfigure));
  auto next = Clock::now() + period;
  while (!stop_) {
    if (Clock::now() < next) {
      std::this_thread::sleep_until(std::min(next, Clock::now() + kTick));
      continue;
    }
    change();
    next = std::max(next + period, Clock::now());
  }
}

void Reconfigurer::change() {
  dynamic_reconfigure::Reconfigure call;
  std::string node = arguments_.selector_node;
  switch (random_.index(5)) {
    case 0:
    case 1:
      ConfigTools::appendParameter(
          call.request.config, "selector",
          arguments_.selectors[random_.index(static_cast<std::uint32_t>(arguments_.selectors.size()))]);
      break;
    case 2: {
      const Range& range = kNumbers[random_.index(static_cast<std::uint32_t>(std::size(kNumbers)))];
      ConfigTools::appendParameter(call.request.config, range.name, random_.uniform(range.low, range.high));
      break;
    }
    case 3:
      node = arguments_.matcher_node;
      ConfigTools::appendParameter(call.request.config, "orb_max_features",
                                   static_cast<int>(900 + random_.index(201)));
      break;
    default:
      node = arguments_.matcher_node;
      ConfigTools::appendParameter(call.request.config, "match_mutual", random_.index(2) == 1);
      break;
  }
  const core::Stopwatch watch;
  const bool answered = ros::service::call(node + "/set_parameters", call);
  const double seconds = watch.seconds();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!answered) {
    ++calls_.failed;
    return;
  }
  calls_.seconds.push_back(seconds);
  if (!inForce(call.request.config, call.response.config)) ++calls_.not_taken;
}

}  // namespace corrsel::load_test
