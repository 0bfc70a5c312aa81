#include "programs/degenerate_inputs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core/types.hpp>

#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"

namespace corrsel {
namespace {

using core::Correspondences;
using core::Random;

constexpr int kWidth = 640, kHeight = 480;
constexpr std::size_t kMatches = 200, kOutliers = 500, kCopies = 30;

cv::Point2f randomPoint(Random& random) {
  const double x = random.uniform(10, kWidth - 10);
  const double y = random.uniform(10, kHeight - 10);
  return {static_cast<float>(x), static_cast<float>(y)};
}

core::AffineFrame frameAt(float x, float y, double angle, double size) {
  const auto c = static_cast<float>(size * std::cos(angle)), s = static_cast<float>(size * std::sin(angle));
  return {c, -s, x, s, c, y};
}

/// Adds the optional columns. Frames and distances of inliers agree, those of outliers are random.
void complete(Correspondences& matches, bool right, Random& random) {
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const double angle = random.uniform(0, 6.28);
    const double size = random.uniform(3, 12);
    const double turn = right ? 0 : random.uniform(0, 6.28);
    const double scale = right ? 1 : random.uniform(0.3, 3);
    const double ratio = right ? random.uniform(0.3, 0.7) : random.uniform(0.7, 1);
    matches.distance.push_back(static_cast<float>(ratio));
    matches.second_distance.push_back(1);
    matches.left_frame.push_back(frameAt(matches.left_x[i], matches.left_y[i], angle, size));
    matches.right_frame.push_back(
        frameAt(matches.right_x[i], matches.right_y[i], angle + turn, size * scale));
    matches.left_index.push_back(static_cast<std::uint32_t>(i));
    matches.right_index.push_back(static_cast<std::uint32_t>(i));
  }
  matches.left_size = matches.right_size = {kWidth, kHeight};
}

/// Adds cameras with an angle of view of 65 degrees, for selectors that do nothing without.
void addNeededCameras(const core::Selector& selector, Correspondences& matches) {
  const std::vector<std::string> needed = core::neededInput(selector);
  if (std::find(needed.begin(), needed.end(), "left_camera") == needed.end()) return;
  core::Camera camera;
  camera.matrix = {kWidth * 0.78, 0, kWidth / 2.0, 0, kWidth * 0.78, kHeight / 2.0, 0, 0, 1};
  camera.size = {kWidth, kHeight};
  matches.left_camera = matches.right_camera = camera;
}

Correspondences outliers(std::size_t n, Random& random) {
  Correspondences matches;
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f left = randomPoint(random);
    matches.add(left, randomPoint(random));
  }
  return matches;
}

/// Inliers of a plane, turned and magnified a little.
Correspondences plane(std::size_t n, Random& random) {
  Correspondences matches;
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f p = randomPoint(random);
    matches.add(p, {1.05F * p.x - 0.05F * p.y + 9, 0.05F * p.x + 1.05F * p.y - 7});
  }
  return matches;
}

}  // namespace

std::vector<DegenerateInput> degenerateInputs() {
  Random random(1);
  Correspondences none, equal, left_equal, line, identical;
  for (std::size_t i = 0; i < kMatches; ++i) {
    const cv::Point2f p = randomPoint(random);
    equal.add({320, 240}, {330, 250});
    left_equal.add({320, 240}, p);
    line.add({p.x, 240}, {p.x + 20, 245});
    identical.add(p, p);
  }
  Correspondences outlier_matches = outliers(kOutliers, random);
  for (Correspondences* matches : {&none, &equal, &line, &identical}) complete(*matches, true, random);
  for (Correspondences* matches : {&left_equal, &outlier_matches}) complete(*matches, false, random);
  std::vector<std::uint32_t> rows(kMatches, 0);
  std::iota(rows.begin() + kCopies, rows.end(), 1U);
  return {{"no match", none},
          {"all matches equal", equal},
          {"all left points equal", left_equal},
          {"points on a line", line},
          {"identical images", identical},
          {"outliers", outlier_matches},
          {"outliers, one of them 30 times", outlier_matches.subset(rows)}};
}

std::string describeSelection(const core::Selector& selector, Correspondences matches) {
  addNeededCameras(selector, matches);
  const core::Selection selection = selector.select(matches);
  const std::string status = "`" + core::toString(selection.status) + "`";
  if (matches.empty() || selection.status == core::Status::kTooFew) return status;
  const double share = static_cast<double>(selection.n_selected) / static_cast<double>(matches.size());
  return status + (share == 0      ? ": none"
                   : share == 1    ? ": all"
                   : share >= 0.5  ? ": most"
                   : share >= 0.05 ? ": some"
                                   : ": few");
}

std::size_t minMatches(const core::Selector& selector) {
  constexpr std::size_t kMaxMatches = 100;
  Random random(1);
  Correspondences all = plane(kMaxMatches, random);
  complete(all, true, random);
  addNeededCameras(selector, all);
  std::vector<std::uint32_t> rows;
  while (rows.size() < kMaxMatches && selector.select(all.subset(rows)).status == core::Status::kTooFew) {
    rows.push_back(static_cast<std::uint32_t>(rows.size()));
  }
  return rows.size();
}

}  // namespace corrsel
