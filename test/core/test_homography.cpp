#include <gtest/gtest.h>

#include "geometry/homography.h"
#include "geometry/residual.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Matches taken as they are, without shift and scale.
NormalizedMatches asIs(const std::vector<cv::Point2f>& left, const std::vector<cv::Point2f>& right) {
  NormalizedMatches m;
  for (const cv::Point2f& p : left) {
    m.left_x.push_back(p.x);
    m.left_y.push_back(p.y);
  }
  for (const cv::Point2f& p : right) {
    m.right_x.push_back(p.x);
    m.right_y.push_back(p.y);
  }
  m.left = m.right = cv::Matx33d::eye();
  m.rounding = 1e-6;
  return m;
}

double sumOfErrors(const cv::Matx33d& h, const NormalizedMatches& m) {
  double sum = 0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    sum += homographyError(h, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
  }
  return sum;
}

TEST(Normalization, CentresBothImagesAndScalesThemAlike) {
  Correspondences c;
  c.add({10, 20}, {0, 0});
  c.add({30, 20}, {0, 8});
  const NormalizedMatches m = normalizeMatches(c);
  // Squared distances to the centroids: 100 twice, 16 twice; rms = sqrt(58).
  EXPECT_DOUBLE_EQ(m.scale, std::sqrt(2.0 / 58));
  EXPECT_FLOAT_EQ(m.left_x[0], float(-10 * m.scale));
  EXPECT_FLOAT_EQ(m.left_x[1], float(10 * m.scale));
  EXPECT_EQ(m.left_y[0], 0.0f);
  EXPECT_FLOAT_EQ(m.right_y[0], float(-4 * m.scale));
  EXPECT_EQ(m.right_x[1], 0.0f);
  for (std::size_t i = 0; i < 2; ++i) {
    const cv::Point2d left = projected(m.left, c.left_x[i], c.left_y[i]);
    const cv::Point2d right = projected(m.right, c.right_x[i], c.right_y[i]);
    EXPECT_NEAR(left.x, m.left_x[i], 1e-6);
    EXPECT_NEAR(left.y, m.left_y[i], 1e-6);
    EXPECT_NEAR(right.x, m.right_x[i], 1e-6);
    EXPECT_NEAR(right.y, m.right_y[i], 1e-6);
  }
  // A few roundings of 30 px.
  EXPECT_GT(m.rounding, 30 * 1.2e-7 * m.scale);
  EXPECT_LT(m.rounding, 30 * 2e-6 * m.scale);

  Correspondences equal;
  for (int i = 0; i < 3; ++i) equal.add({5, 6}, {7, 8});
  EXPECT_EQ(normalizeMatches(equal).scale, 1.0);
  EXPECT_EQ(normalizeMatches({}).scale, 1.0);
}

TEST(Normalization, TakesHomographiesBackToPixels) {
  const Scene scene = homographyScene({50, 1.0, 0.0, 1});
  const NormalizedMatches m = normalizeMatches(scene.matches);
  const cv::Matx33d normalized = m.right * scene.model * m.left.inv();
  for (const double factor : {1.0, 17.0}) {
    const cv::Matx33d h = m.homographyToPixels(normalized * factor);
    EXPECT_DOUBLE_EQ(h(2, 2), 1);
    EXPECT_LT(cv::norm(h - scene.model), 1e-9);
  }
  // The sign decides what lies in front of the camera, so it must not change.
  const cv::Matx33d turned = m.homographyToPixels(normalized * -1.0);
  EXPECT_LT(turned(2, 2), 0);
  EXPECT_NEAR(cv::norm(turned), 1, 1e-9);
}

TEST(Normalization, TriangleAreaIsSignedAndZeroOnALine) {
  const std::vector<float> x = {0, 4, 0, 8}, y = {0, 0, 3, 1e-6f};
  EXPECT_EQ(triangleArea(x, y, 0, 1, 2, 0), 12);
  EXPECT_EQ(triangleArea(x, y, 0, 2, 1, 0), -12);
  EXPECT_EQ(triangleArea(x, y, 0, 1, 3, 1e-6), 0);
  EXPECT_NE(triangleArea(x, y, 0, 1, 3, 1e-8), 0);
}

TEST(Homography, ErrorIsTheSquaredForwardTransfer) {
  const cv::Matx33d h(2, 0, 1, 0, 3, -1, 0, 0.5, 1);
  // (4, 2) goes to (9, 5) / 2.
  EXPECT_DOUBLE_EQ(homographyError(h, 4, 2, 4.5, 2.5), 0);
  EXPECT_DOUBLE_EQ(homographyError(h, 4, 2, 7.5, -1.5), 9 + 16);
  EXPECT_DOUBLE_EQ(homographyError(h * 10.0, 4, 2, 7.5, -1.5), 25);
  // Third coordinate zero or negative: behind the camera.
  EXPECT_EQ(homographyError(h, 4, -2, 0, 0), INFINITY);
  EXPECT_EQ(homographyError(h, 4, -3, 0, 0), INFINITY);
  EXPECT_EQ(homographyError(h * -1.0, 4, 2, 4.5, 2.5), INFINITY);
  EXPECT_TRUE(std::isfinite(homographyError(h, 4, -1.999, 0, 0)));
}

TEST(Homography, ErrorsInBlocksAreTheSame) {
  NormalizedMatches m = normalizeMatches(homographyScene({40, 0.5, 1.0, 2}).matches);
  const cv::Matx33d h(0.9, 0.1, 0.05, -0.1, 1.1, 0, 0.6, 0.1, 1);  // some points are behind
  std::vector<float> errors(30);
  modelErrors(Residual::kTransfer, h, m, 5, 35, errors.data());
  int behind = 0;
  for (std::size_t i = 5; i < 35; ++i) {
    const double e = homographyError(h, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
    behind += std::isinf(e);
    if (std::isinf(e)) {
      EXPECT_EQ(errors[i - 5], INFINITY);
    } else {
      EXPECT_NEAR(errors[i - 5] / e, 1, 1e-3);
    }
  }
  EXPECT_TRUE(behind > 0 && behind < 30);
}

TEST(Homography, FourMatchesFixIt) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Scene scene = homographyScene({4, 1.0, 0.0, seed});
    const NormalizedMatches m = normalizeMatches(scene.matches);
    const std::uint32_t sample[] = {3, 1, 0, 2};
    if (!isValidHomographySample(m, sample)) continue;
    cv::Matx33d h;
    ASSERT_TRUE(homographyFromFour(m, sample, h));
    EXPECT_NEAR(cv::norm(h), 1, 1e-12);
    EXPECT_LT(sumOfErrors(h, m), 1e-9);  // finite: all four before the camera
    const cv::Matx33d pixels = m.homographyToPixels(h);
    const double extent = 1e4 / std::abs(triangleArea(m.left_x, m.left_y, 0, 1, 2, 0));
    EXPECT_LT(cv::norm(projected(pixels, 400, 300) - projected(scene.model, 400, 300)), 1e-4 * extent);
  }
}

TEST(Homography, ImpossibleSamplesAreRefused) {
  const std::vector<cv::Point2f> square = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const std::uint32_t sample[] = {0, 1, 2, 3};
  cv::Matx33d h;
  EXPECT_TRUE(isValidHomographySample(asIs(square, square), sample));
  // A mirror image keeps all orientations or turns all.
  EXPECT_TRUE(isValidHomographySample(asIs(square, {{1, -1}, {-1, -1}, {-1, 1}, {1, 1}}), sample));
  // Three on a line, whichever three and in whichever image.
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    std::vector<cv::Point2f> line = {{-1, -0.9f}, {0.1f, 0.2f}, {0.4f, 0.5f}, {0.9f, 1}};
    line[left_out] = {-0.5f, 0.8f};
    EXPECT_FALSE(isValidHomographySample(asIs(line, square), sample)) << left_out;
    EXPECT_FALSE(isValidHomographySample(asIs(square, line), sample)) << left_out;
  }
  // Two equal points.
  EXPECT_FALSE(isValidHomographySample(asIs({{0, 0}, {0, 0}, {1, 0}, {0, 1}}, square), sample));
  EXPECT_FALSE(homographyFromFour(asIs({{0, 0}, {0, 0}, {1, 0}, {0, 1}}, square), sample, h));
  // Two points change places: the quadrangle crosses itself, and some points come to lie behind the camera.
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {2, 3}}) {
    std::vector<cv::Point2f> crossed = square;
    std::swap(crossed[a], crossed[b]);
    EXPECT_FALSE(isValidHomographySample(asIs(square, crossed), sample));
    EXPECT_FALSE(homographyFromFour(asIs(square, crossed), sample, h));
  }
  // A point inside the triangle of the others goes outside.
  EXPECT_FALSE(isValidHomographySample(asIs({{-1, -1}, {1, -1}, {0, 1}, {0, -0.5f}}, square), sample));
}

TEST(Homography, SymmetricErrorsAddBothDirections) {
  const Scene scene = homographyScene({50, 0.5, 1.0, 2});
  std::vector<double> there(50), both(50);
  pixelErrors(Residual::kTransfer, scene.model, scene.matches, there.data());
  pixelErrors(Residual::kSymmetricTransfer, scene.model, scene.matches, both.data());
  const NormalizedMatches m = normalizeMatches(scene.matches);
  const cv::Matx33d normalized = m.right * scene.model * m.left.inv();
  std::vector<float> errors(50);
  modelErrors(Residual::kSymmetricTransfer, normalized, m, 0, 50, errors.data());
  for (std::size_t i = 0; i < 50; ++i) {
    const Correspondences& c = scene.matches;
    const cv::Point2d back = projected(scene.model.inv(), c.right_x[i], c.right_y[i]);
    const double distance = cv::norm(back - cv::Point2d(c.left_x[i], c.left_y[i]));
    EXPECT_NEAR(both[i], there[i] + distance * distance, 1e-6 * both[i]);
    EXPECT_NEAR(errors[i] / (m.scale * m.scale), both[i], 1e-3 * both[i] + 1e-3);
  }
  pixelErrors(Residual::kSymmetricTransfer, cv::Matx33d(1, 0, 0, 0, 1, 0, 0, 0, 0), scene.matches,
              both.data());
  EXPECT_EQ(both[0], INFINITY);
}

TEST(Homography, SmallerErrorIsThatOfOneDirection) {
  // A zoom of three: the error in the left image is a third of that in the right one, or the reverse.
  for (const double zoom : {3.0, 1.0 / 3}) {
    Scene scene = homographyScene({50, 0.5, 1.0, 2});
    const cv::Matx33d scaling(zoom, 0, 0, 0, zoom, 0, 0, 0, 1), model = scaling * scene.model;
    for (auto* column : {&scene.matches.right_x, &scene.matches.right_y}) {
      for (float& value : *column) value = static_cast<float>(value * zoom);
    }
    std::vector<double> there(50), both(50), smaller(50);
    pixelErrors(Residual::kTransfer, model, scene.matches, there.data());
    pixelErrors(Residual::kSymmetricTransfer, model, scene.matches, both.data());
    pixelErrors(Residual::kSmallerTransfer, model, scene.matches, smaller.data());
    const NormalizedMatches m = normalizeMatches(scene.matches);
    std::vector<float> errors(50);
    modelErrors(Residual::kSmallerTransfer, m.right * model * m.left.inv(), m, 0, 50, errors.data());
    int forward = 0;
    for (std::size_t i = 0; i < 50; ++i) {
      EXPECT_NEAR(smaller[i], std::min(there[i], both[i] - there[i]), 1e-9 * both[i]);
      EXPECT_NEAR(errors[i] / (m.scale * m.scale), smaller[i], 1e-3 * smaller[i] + 1e-3);
      forward += smaller[i] == there[i] ? 1 : 0;
    }
    EXPECT_EQ(forward, zoom > 1 ? 0 : 50);
    // A point behind a camera has no error, although the other direction may exist.
    pixelErrors(Residual::kSmallerTransfer, cv::Matx33d(1, 0, 0, 0, 1, 0, 0, 0, 0), scene.matches,
                smaller.data());
    EXPECT_EQ(smaller[0], INFINITY);
  }
}

/// A model through the first matches that four of them fix, refined on all those within the threshold.
cv::Matx33d refined(const NormalizedMatches& m, float squared_threshold, int steps = 8) {
  cv::Matx33d h;
  for (std::uint32_t first = 0;; ++first) {
    const std::uint32_t sample[] = {first, first + 1, first + 2, first + 3};
    if (isValidHomographySample(m, sample) && homographyFromFour(m, sample, h)) break;
  }
  for (int step = 0; step < steps; ++step)
    EXPECT_TRUE(refineHomography(m, Residual::kTransfer, squared_threshold, h));
  return h;
}

TEST(Homography, RefinementIsExactOnExactData) {
  for (const std::size_t n : {5, 100}) {
    const Scene scene = homographyScene({n, 1.0, 0.0, 7});
    const NormalizedMatches m = normalizeMatches(scene.matches);
    const cv::Matx33d h = refined(m, INFINITY);
    EXPECT_NEAR(cv::norm(h), 1, 1e-12);
    EXPECT_LT(cv::norm(m.homographyToPixels(h) - scene.model), 1e-2);
    EXPECT_LT(sumOfErrors(h, m) / double(n), 1e-12);
  }
}

TEST(Homography, RefinementHasTheLeastSumOfSquaredErrors) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const NormalizedMatches m = normalizeMatches(homographyScene({60, 1.0, 3.0, seed}).matches);
    const cv::Matx33d h = refined(m, INFINITY, 12);
    const double least = sumOfErrors(h, m);
    for (int k = 0; k < 9; ++k) {
      for (const double step : {-1e-4, 1e-4}) {
        cv::Matx33d other = h;
        other.val[k] += step * cv::norm(h);
        EXPECT_GT(sumOfErrors(other, m), least) << "element " << k;
      }
    }
  }
}

TEST(Homography, RefinementBeatsMinimalModels) {
  double fitted = 0, minimal = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Scene scene = homographyScene({50, 1.0, 1.0, seed});
    const NormalizedMatches m = normalizeMatches(scene.matches);
    const cv::Point2d truth = projected(scene.model, 400, 300);
    minimal +=
        std::min(100.0, cv::norm(projected(m.homographyToPixels(refined(m, INFINITY, 0)), 400, 300) - truth));
    fitted += cv::norm(projected(m.homographyToPixels(refined(m, INFINITY)), 400, 300) - truth);
  }
  EXPECT_LT(fitted, 0.3 * minimal);
  EXPECT_LT(fitted / 30, 0.5);
}

TEST(Homography, RefinementUsesTheInliersOnly) {
  const Scene scene = homographyScene({100, 0.5, 0.0, 3});
  const NormalizedMatches m = normalizeMatches(scene.matches);
  const auto threshold = static_cast<float>(std::pow(5 * m.scale, 2));
  EXPECT_LT(cv::norm(m.homographyToPixels(refined(m, threshold)) - scene.model), 1e-2);
  EXPECT_GT(cv::norm(m.homographyToPixels(refined(m, INFINITY)) - scene.model), 1);
}

TEST(Homography, RefinementRefusesWhatCannotBeFitted) {
  const NormalizedMatches m = normalizeMatches(homographyScene({20, 1.0, 0.0, 4}).matches);
  cv::Matx33d h = cv::Matx33d::eye();
  EXPECT_FALSE(refineHomography(m, Residual::kTransfer, 0.0F, h));  // no inlier
  Correspondences line;
  for (int i = 0; i < 20; ++i) line.add({float(3 * i), float(i)}, {float(i), float(7 * i)});
  EXPECT_FALSE(refineHomography(normalizeMatches(line), Residual::kTransfer, INFINITY, h));
  EXPECT_EQ(h, cv::Matx33d::eye());
}

}  // namespace
}  // namespace corrsel::core
