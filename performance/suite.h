#pragma once

#include <functional>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "measurement.h"
#include "report.h"

namespace corrsel::performance {

/// Measurements of a comparison's methods, in their order.
using Measurements = std::vector<Measurement>;

/// What a comparison compares, and thus the table that it appears in.
enum class ComparisonKind {
  kSelectors,  ///< the first method with the others, on matches or descriptors
  kGrowth,     ///< the methods are one selector at several sizes
  kFeatures,   ///< the first method with the others, on a photograph
  kStages,     ///< the methods are the stages of a pair of photographs
  kCosts       ///< each method does more of the work on a photograph than the one before
};

/// Methods that are timed together.
struct Comparison {
  std::string name;  ///< unique; the filter is applied to it
  std::vector<Method> methods;
  std::vector<std::function<Verdict(const Measurements&)>> targets;
  ComparisonKind kind = ComparisonKind::kSelectors;
  cv::Size image_size = {};  ///< of photographs, px
  /// Whether the yardstick is timed with the methods. Targets find its measurement behind theirs, the tables
  /// do not show it.
  bool with_yardstick = false;
};

/// @param all  the full grid of sizes and inlier ratios, otherwise the comparisons that have targets
std::vector<Comparison> comparisons(bool all);

/// Measures and reports.
void run(const Comparison& comparison, Report& report);

}  // namespace corrsel::performance
