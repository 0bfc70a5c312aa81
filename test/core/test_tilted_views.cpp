#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "features/parts/scale_level.h"
#include "features/parts/tilted_views.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class TiltedViewTest : public ::testing::Test {
 protected:
  ~TiltedViewTest() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

cv::Mat noise(const cv::Size& size) {
  Random random(2);
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) image.at<std::uint8_t>(y, x) = std::uint8_t(random.index(256));
  }
  return image;
}

cv::Mat pixelsOf(const cv::Mat& image, double tilt, double turn) {
  return TiltedViews(image).view(tilt, turn, Workspace::ofThread()).pixels.clone();
}

TEST_F(TiltedViewTest, ShowsTheImageRotatedBlurredAndCompressed) {
  // Waves that every blur of the test only makes weaker: exp(-(sigma f)^2 / 2) along the compressed axis.
  cv::Mat image(240, 320, CV_8U);
  const cv::Point2d wave(0.11, 0.07);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(128 + 100 * std::sin(wave.x * x + wave.y * y));
    }
  }
  for (const double tilt : {std::sqrt(2.0), 2.0, 4 * std::sqrt(2.0)}) {
    for (const double degrees : {0.0, 17.0, 45.0, 90.0, 133.0, 179.0}) {
      const double turn = degrees * CV_PI / 180;
      const TiltedView view = TiltedViews(image).view(tilt, turn, Workspace::ofThread());
      ASSERT_EQ(view.pixels.type(), CV_16S);
      const double along = -wave.x * std::sin(turn) + wave.y * std::cos(turn),
                   sigma = 0.8 * std::sqrt(tilt * tilt - 1);
      const double amplitude = 100 * std::exp(-0.5 * along * along * sigma * sigma);
      const int margin = int(3 * sigma) + 2;
      int compared = 0;
      for (int y = 0; y < view.pixels.rows; ++y) {
        for (int x = 0; x < view.pixels.cols; ++x) {
          const cv::Matx23d& m = view.to_image;
          const cv::Point2d at(m(0, 0) * x + m(0, 1) * y + m(0, 2), m(1, 0) * x + m(1, 1) * y + m(1, 2));
          if (std::min({at.x, at.y, image.cols - 1 - at.x, image.rows - 1 - at.y}) < margin) continue;
          const double expected = 128 + amplitude * std::sin(wave.x * at.x + wave.y * at.y);
          ASSERT_NEAR(view.pixels.at<std::int16_t>(y, x) / double(kGreyUnit), expected, 1.5)
              << tilt << " " << degrees << " " << at;
          ++compared;
        }
      }
      EXPECT_GT(compared, int(image.total() / tilt / 3));
    }
  }
}

TEST_F(TiltedViewTest, IsTheSameAtEveryKernelLevel) {
  for (const cv::Size size : {cv::Size(150, 110), cv::Size(33, 90)}) {
    const cv::Mat image = noise(size);
    for (const double degrees : {0.0, 30.0, 90.0, 161.0}) {
      setKernelLevel(KernelLevel::kPlain);
      const cv::Mat expected = pixelsOf(image, 2.8, degrees * CV_PI / 180);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        const cv::Mat pixels = pixelsOf(image, 2.8, degrees * CV_PI / 180);
        ASSERT_EQ(pixels.size(), expected.size());
        ASSERT_EQ(cv::countNonZero(pixels != expected), 0) << toString(level);
      }
    }
  }
}

TEST_F(TiltedViewTest, ImagesOfAnySizeWork) {
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(1, 60), cv::Size(60, 1), cv::Size(2, 3), cv::Size(2000, 5)}) {
    for (const double degrees : {0.0, 1e-4, 45.0, 90.0, 100.0}) {
      const cv::Mat pixels = pixelsOf(cv::Mat(size, CV_8U, cv::Scalar(200)), 2, degrees * CV_PI / 180);
      ASSERT_FALSE(pixels.empty());
      ASSERT_EQ(cv::countNonZero(pixels != 200 * kGreyUnit), 0) << size << " " << degrees;
      double low, high;
      cv::minMaxLoc(pixelsOf(noise(size), 2, degrees * CV_PI / 180), &low, &high);
      ASSERT_GE(low, 0);
      ASSERT_LE(high, 255 * kGreyUnit);
    }
  }
}

TEST_F(TiltedViewTest, KernelsInterpolateAsAPlainLoopDoes) {
  Random random(9);
  constexpr int kSide = 40;
  std::vector<std::uint32_t> quads;
  for (int k = 0; k < kSide * kSide; ++k) {
    const std::uint32_t high = random.index(1u << 31);
    quads.push_back(high * 2 + random.index(2));
  }
  for (const int n : {1, 5, 16, 17, 35}) {
    for (int round = 0; round < 20; ++round) {
      // Both ends of the line are inside.
      const auto draw = [&random] { return std::int32_t(random.index(kSide << 16)); };
      const std::int32_t x = draw(), y = draw(), to_x = draw(), to_y = draw();
      const std::int32_t dx = (to_x - x) / n, dy = (to_y - y) / n;
      std::vector<std::int16_t> expected;
      for (int k = 0; k < n; ++k) {
        const int px = x + k * dx, py = y + k * dy;
        const std::uint32_t quad = quads[std::size_t((py >> 16) * kSide + (px >> 16))];
        const int right = px >> 10 & 63, lower = py >> 9 & 127;
        const int upper_row = int(quad & 255) * (64 - right) + int(quad >> 8 & 255) * right;
        const int lower_row = int(quad >> 16 & 255) * (64 - right) + int(quad >> 24) * right;
        expected.push_back(std::int16_t((upper_row * (128 - lower) + lower_row * lower + 32) >> 6));
      }
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        std::vector<std::int16_t> out(std::size_t(n + ViewKernels::kSlack));
        kernels().views.sampleLine(quads.data(), kSide, x, y, dx, dy, n, out.data());
        out.resize(std::size_t(n));
        ASSERT_EQ(out, expected) << toString(level);
      }
    }
  }
}

}  // namespace
}  // namespace corrsel::core
