#include "corrsel_example_selector/normalized_median.h"

#include <corrsel/neighbours.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <vector>

namespace corrsel_example_selector {
namespace {

using namespace corrsel::core;

cv::Point2f displacement(const Correspondences& matches, std::size_t i) {
  return {matches.right_x[i] - matches.left_x[i], matches.right_y[i] - matches.left_y[i]};
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void NormalizedMedianOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"neighbours", 3, 63, "-", "Neighbours that a match is compared with"},
                  &NormalizedMedianOptions::neighbours);
  visitor.number({"threshold", 0, 1000, "-", "Largest deviation, as a multiple of the neighbours' own"},
                 &NormalizedMedianOptions::threshold);
  visitor.number({"noise", 0.001, 1000, "px", "Deviation that neighbours have at least"},
                 &NormalizedMedianOptions::noise);
}

Presets NormalizedMedian::presets() const { return {{"strict", {{"neighbours", "16"}, {"threshold", "1"}}}}; }

void NormalizedMedian::run(const Correspondences& matches, Workspace&, Selection& result) const {
  const std::size_t n = matches.size(), k = static_cast<std::size_t>(options_.neighbours);
  if (n <= k) {
    result.status = Status::kTooFew;
    result.message =
        std::to_string(n) + " matches; needed are more than the number of neighbours, " + std::to_string(k);
    return;
  }
  // A match is one of its own neighbours, unless k others lie at the same point.
  const int asked = options_.neighbours + 1;
  std::vector<std::uint32_t> nearest(n * (k + 1));
  const float *const x = matches.left_x.data(), *const y = matches.left_y.data();
  PlanarNeighbours(x, y, n, asked).nearestToAll(x, y, n, asked, nearest.data());

  result.score.resize(n);
  std::vector<cv::Point2f> others;
  std::vector<float> values(k);
  for (std::size_t i = 0; i < n; ++i) {
    others.clear();
    for (std::size_t j = i * (k + 1); others.size() < k; ++j) {
      if (nearest[j] != i) others.push_back(displacement(matches, nearest[j]));
    }
    cv::Point2f middle;
    std::transform(others.begin(), others.end(), values.begin(), [](const cv::Point2f& d) { return d.x; });
    middle.x = median(values);
    std::transform(others.begin(), others.end(), values.begin(), [](const cv::Point2f& d) { return d.y; });
    middle.y = median(values);
    const auto distance = [&middle](const cv::Point2f& d) {
      return std::hypot(d.x - middle.x, d.y - middle.y);
    };
    std::transform(others.begin(), others.end(), values.begin(), distance);
    const double deviation = distance(displacement(matches, i)) / (median(values) + options_.noise);
    result.score[i] = static_cast<float>(-deviation);
    result.mask[i] = deviation <= options_.threshold;
  }
}

}  // namespace corrsel_example_selector

PLUGINLIB_EXPORT_CLASS(corrsel_example_selector::NormalizedMedian, corrsel::Selector)
