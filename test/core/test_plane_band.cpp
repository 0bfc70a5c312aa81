#include <gtest/gtest.h>

#include <cmath>

#include "auto/plane_band.h"
#include "geometry/residual.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kThreshold = 5;
const cv::Matx33d kPlane(1, 0, -60, 0, 1, 0, 0, 0, 1);
/// Cameras side by side: epipolar lines are rows.
const cv::Matx33d kRows(0, 0, 0, 0, 0, -1, 0, 1, 0);

/// Matches, their plane, and what the band needs of them.
struct Band {
  explicit Band(Correspondences m, bool is_ranked = false) : pixels(std::move(m)), ranked(is_ranked) {
    pixels.left_size = pixels.right_size = {kSceneWidth, kSceneHeight};
    normalized = normalizeMatches(pixels);
    best_first.resize(pixels.size());
    std::iota(best_first.begin(), best_first.end(), 0U);
    homography = normalized.homographyFromPixels(kPlane);
    errors.resize(pixels.size());
    pixelErrors(Residual::kSmallerTransfer, kPlane, pixels, errors.data());
    // F in normalised coordinates: x'^T F x with x = left^-1 x_n.
    fundamental = normalized.right.t().inv() * kRows * normalized.left.inv();
    band.gather(plane, 0.6, 5);
  }

  PlaneBand::Direction direction() { return band.direction(fundamental, 1); }

  Correspondences pixels;
  bool ranked;
  NormalizedMatches normalized;
  std::vector<std::uint32_t> best_first;
  cv::Matx33d homography, fundamental;
  std::vector<double> errors;
  PlaneOfMatches plane{pixels, normalized, best_first, ranked, homography, errors, kThreshold};
  PlaneBand band;
  Band(const Band&) = delete;
  Band& operator=(const Band&) = delete;
};

/// 100 matches on the plane, and others for which `displacement` returns the distance from it, px.
template <class Displacement>
Correspondences besidePlane(int others, const Displacement& displacement) {
  Random random(1);
  Correspondences m;
  for (int i = 0; i < 100 + others; ++i) {
    const cv::Point2d left = uniformPoint(random, kSceneWidth, kSceneHeight);
    const cv::Point2d off = i < 100 ? cv::Point2d() : displacement(left, random);
    m.add(left, left - cv::Point2d(60, 0) + off + 0.3 * normalPoint(random));
  }
  return m;
}

TEST(PlaneBand, HoldsMatchesThatThePlaneMissesByLittle) {
  const Correspondences m = besidePlane(
      300, [](const cv::Point2d&, Random& random) { return cv::Point2d(random.uniform(0, 60), 0); });
  const Band scene(m);
  ASSERT_GT(scene.band.members().size(), 60U);
  for (const std::uint32_t i : scene.band.members()) {
    EXPECT_GT(scene.errors[i], 3 * 3);
    EXPECT_LE(scene.errors[i], 25 * 25);
  }
}

TEST(PlaneBand, CountsAPlaceOnce) {
  Correspondences m;
  for (int i = 0; i < 20; ++i) m.add({100, 100}, {50, 100});
  EXPECT_EQ(Band(m).band.members().size(), 1U);
}

TEST(PlaneBand, LeavesMatchesOutThatAreWorseThanThoseOnThePlane) {
  const auto beside = [](const cv::Point2d&, Random&) { return cv::Point2d(12, 0); };
  Correspondences m = besidePlane(50, beside);
  // In the order of quality, those on the plane come first.
  EXPECT_EQ(Band(m, true).band.members().size(), 0U);
  EXPECT_GT(Band(m, false).band.members().size(), 30U);
}

TEST(PlaneBand, TellsEpipolarLinesFromRandomDirections) {
  Band along(besidePlane(
      60, [](const cv::Point2d&, Random& random) { return cv::Point2d(random.uniform(5, 20), 0); }));
  const PlaneBand::Direction found = along.direction();
  EXPECT_GT(found.log_ratio, 60);
  EXPECT_GT(found.share, 0.8);
  Band anywhere(besidePlane(60, [](const cv::Point2d&, Random& random) {
    const double angle = random.uniform(0, 2 * CV_PI);
    return random.uniform(5, 20) * cv::Point2d(std::cos(angle), std::sin(angle));
  }));
  EXPECT_LT(anywhere.direction().log_ratio, 5);
}

TEST(PlaneBand, FindsTheShareThatFollowsTheLines) {
  Band half(besidePlane(200, [](const cv::Point2d& left, Random& random) {
    const double angle = left.x < kSceneWidth / 2.0 ? 0 : random.uniform(0, 2 * CV_PI);
    return random.uniform(8, 20) * cv::Point2d(std::cos(angle), std::sin(angle));
  }));
  EXPECT_NEAR(half.direction().share, 0.5, 0.11);
}

TEST(PlaneBand, NeighboursOfASurfaceAreDisplacedAlike) {
  Band surface(besidePlane(
      120, [](const cv::Point2d& left, Random&) { return cv::Point2d(4 + 18 * left.x / kSceneWidth, 0); }));
  surface.direction();
  EXPECT_GT(surface.band.coherence(), 0.5);
}

TEST(PlaneBand, RepeatedStructureIsNotCoherent) {
  Band windows(besidePlane(120, [](const cv::Point2d&, Random& random) {
    return cv::Point2d(6.0 * (1 + static_cast<int>(random.index(3))), 0);
  }));
  windows.direction();
  EXPECT_LT(windows.band.coherence(), 0.25);
}

TEST(PlaneBand, RepeatedStructureIsPeriodic) {
  Band windows(besidePlane(120, [](const cv::Point2d&, Random& random) {
    return cv::Point2d(10.0 * (1 + static_cast<int>(random.index(2))), 0);
  }));
  windows.direction();
  EXPECT_GT(windows.band.periodicity(), 0.7);
  Band depth(besidePlane(
      120, [](const cv::Point2d&, Random& random) { return cv::Point2d(random.uniform(4, 24), 0); }));
  depth.direction();
  EXPECT_LT(depth.band.periodicity(), 0.45);
}

TEST(PlaneBand, AFewAreNotCoherent) {
  Band few(besidePlane(4, [](const cv::Point2d&, Random&) { return cv::Point2d(10, 0); }));
  few.direction();
  EXPECT_EQ(few.band.coherence(), 0);
}

}  // namespace
}  // namespace corrsel::core
