#pragma once

#include <functional>
#include <string>
#include <vector>

#include "measurement.h"
#include "report.h"

namespace corrsel::performance {

/// Measurements of a comparison's methods, in their order.
using Measurements = std::vector<Measurement>;

/// One selector (the first method) and the methods that it is compared with, timed together.
struct Comparison {
  std::string name;  ///< unique; the filter is applied to it
  std::vector<Method> methods;
  std::vector<std::function<Verdict(const Measurements&)>> targets;
  bool growth = false;  ///< the two methods are one selector at two sizes
};

/// @param all  the full grid of sizes and inlier ratios, otherwise the comparisons that have targets
std::vector<Comparison> comparisons(bool all);

/// Measures and reports.
void run(const Comparison& comparison, Report& report);

}  // namespace corrsel::performance
