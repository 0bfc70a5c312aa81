#include <gtest/gtest.h>

#include <array>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "feature_checks.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class CornerKernelsTest : public ::testing::Test {
  LevelGuard guard_;
};

/// The image with some more bytes behind its last row.
struct Padded {
  explicit Padded(const cv::Mat& image) : stride(image.cols), bytes(std::size_t(image.total()) + 64, 77) {
    for (int y = 0; y < image.rows; ++y) std::copy_n(image.ptr(y), image.cols, row(y));
  }
  std::uint8_t* row(int y) { return bytes.data() + y * stride; }

  std::ptrdiff_t stride;
  std::vector<std::uint8_t> bytes;
};

cv::Mat noise(const cv::Size& size, double strength, std::uint64_t seed) {
  Random random(seed);
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      image.at<std::uint8_t>(y, x) = std::uint8_t(random.uniform(128 - strength, 128 + strength));
    }
  }
  return image;
}

std::vector<cv::Mat> pictures() {
  cv::Mat smooth = noise({230, 90}, 127, 3);
  cv::GaussianBlur(smooth, smooth, {}, 1.5);
  return {shapes(1, {201, 120}), noise({97, 64}, 127, 1), noise({130, 40}, 12, 2), smooth,
          cv::Mat(40, 70, CV_8U, cv::Scalar(255))};
}

constexpr int kCircle[16][2] = {{0, -3}, {1, -3}, {2, -2}, {3, -1}, {3, 0},  {3, 1},   {2, 2},   {1, 3},
                                {0, 3},  {-1, 3}, {-2, 2}, {-3, 1}, {-3, 0}, {-3, -1}, {-2, -2}, {-1, -3}};

/// The score by its definition.
int plainScore(const cv::Mat& image, int x, int y) {
  int best = 0;
  for (const int sign : {1, -1}) {
    for (int start = 0; start < 16; ++start) {
      int least = 255;
      for (int i = start; i < start + 9; ++i) {
        const auto [dx, dy] = kCircle[i % 16];
        const int difference =
            int(image.at<std::uint8_t>(y + dy, x + dx)) - int(image.at<std::uint8_t>(y, x));
        least = std::min(least, sign * difference);
      }
      best = std::max(best, least);
    }
  }
  return best;
}

TEST_F(CornerKernelsTest, ScoresAreThoseOfTheDefinitionAtEveryLevel) {
  for (const cv::Mat& image : pictures()) {
    Padded padded(image);
    const int n = image.cols - 6;
    for (const int threshold : {0, 1, 20, 90, 254, 255}) {
      for (int y = 3; y < image.rows - 3; ++y) {
        std::vector<std::uint8_t> expected;
        for (int x = 3; x < image.cols - 3; ++x) {
          const int score = plainScore(image, x, y);
          expected.push_back(std::uint8_t(score > threshold ? score : 0));
        }
        const bool any = std::any_of(expected.begin(), expected.end(), [](int score) { return score > 0; });
        for (const KernelLevel level : supportedKernelLevels()) {
          setKernelLevel(level);
          std::vector<std::uint8_t> scores(std::size_t(n) + kCornerPadding);
          const bool found =
              kernels().corners.scores(padded.row(y) + 3, padded.stride, n, threshold, scores.data());
          scores.resize(std::size_t(n));
          ASSERT_EQ(scores, expected) << toString(level) << " row " << y << " threshold " << threshold;
          ASSERT_TRUE(found || !any);
        }
      }
    }
  }
}

TEST_F(CornerKernelsTest, CornersAreThoseOfOpenCv) {
  std::size_t corners = 0;
  for (const cv::Mat& image : pictures()) {
    Padded padded(image);
    for (const int threshold : {1, 10, 20, 60, 200}) {
      std::vector<cv::KeyPoint> keypoints;
      cv::FAST(image, keypoints, threshold, false);
      std::set<std::pair<int, int>> expected, found;
      for (const cv::KeyPoint& keypoint : keypoints) expected.emplace(int(keypoint.pt.y), int(keypoint.pt.x));
      for (int y = 3; y < image.rows - 3; ++y) {
        std::vector<std::uint8_t> scores(std::size_t(image.cols) + kCornerPadding);
        kernels().corners.scores(padded.row(y) + 3, padded.stride, image.cols - 6, threshold, scores.data());
        for (int x = 3; x < image.cols - 3; ++x) {
          if (scores[std::size_t(x - 3)] > 0) found.emplace(y, x);
        }
      }
      EXPECT_EQ(found, expected) << threshold;
      corners += found.size();
    }
  }
  EXPECT_GT(corners, 10000u);
}

TEST_F(CornerKernelsTest, MaximaAreThoseOfAPlainLoopAtEveryLevel) {
  Random random(5);
  for (const int n : {1, 2, 15, 16, 17, 63, 64, 65, 128, 200}) {
    for (const int values : {2, 4, 256}) {
      // Few values give many equal neighbours; most scores are 0, as in an image.
      std::vector<std::vector<std::uint8_t>> rows(
          3, std::vector<std::uint8_t>(std::size_t(n) + 2 + kCornerPadding));
      for (auto& row : rows) {
        for (std::uint8_t& score : row) {
          const int value = int(random.index(std::uint32_t(values)));
          score = std::uint8_t(random.index(3) == 0 ? value : 0);
        }
      }
      std::vector<std::int32_t> expected;
      for (int x = 0; x < n; ++x) {
        const auto at = [&](int dy, int dx) { return rows[std::size_t(1 + dy)][std::size_t(1 + x + dx)]; };
        const int here = at(0, 0);
        const bool after = here > at(-1, -1) && here > at(-1, 0) && here > at(-1, 1) && here > at(0, -1);
        const bool before = here >= at(0, 1) && here >= at(1, -1) && here >= at(1, 0) && here >= at(1, 1);
        if (here > 0 && after && before) expected.push_back(x);
      }
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        std::vector<std::int32_t> columns(std::size_t(n), -1);
        const int found = kernels().corners.maxima(rows[0].data() + 1, rows[1].data() + 1, rows[2].data() + 1,
                                                   n, columns.data());
        columns.resize(std::size_t(found));
        ASSERT_EQ(columns, expected) << toString(level) << " " << n << " " << values;
      }
    }
  }
}

TEST_F(CornerKernelsTest, StructureSumsAreThoseOfSobelAtEveryLevel) {
  for (const cv::Mat& image : pictures()) {
    Padded padded(image);
    cv::Mat dx, dy;
    cv::Sobel(image, dx, CV_16S, 1, 0);
    cv::Sobel(image, dy, CV_16S, 0, 1);
    std::vector<PixelPlace> places;
    std::vector<std::array<int, 3>> expected;
    for (int y = 4; y < image.rows - 4; y += 3) {
      for (int x = 4; x < image.cols - 4; x += 2) {
        places.push_back({x, y});
        std::array<int, 3> sums{};
        for (int v = y - 3; v <= y + 3; ++v) {
          for (int u = x - 3; u <= x + 3; ++u) {
            const int a = dx.at<std::int16_t>(v, u), b = dy.at<std::int16_t>(v, u);
            sums[0] += a * a;
            sums[1] += b * b;
            sums[2] += a * b;
          }
        }
        expected.push_back(sums);
      }
    }
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      for (const std::size_t n : {std::size_t(1), std::size_t(2), std::size_t(3), places.size()}) {
        std::vector<StructureSums> sums(n);
        kernels().corners.structure(padded.bytes.data(), padded.stride, places.data(), n, sums.data());
        for (std::size_t i = 0; i < n; ++i) {
          const std::array<int, 3> found = {sums[i].xx, sums[i].yy, sums[i].xy};
          ASSERT_EQ(found, expected[i]) << toString(level) << " " << i << " of " << n;
        }
      }
    }
  }
}

}  // namespace
}  // namespace corrsel::core
