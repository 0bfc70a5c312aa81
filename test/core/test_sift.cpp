#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "corrsel/features/extractor.h"
#include "feature_checks.h"
#include "features/detectors/sift.h"
#include "features/parts/dog_keypoints.h"
#include "features/parts/feature_list.h"
#include "kernels/kernels.h"
#include "test_paths.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class Sift : public ::testing::Test {
 protected:
  ~Sift() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

/// Discs and boxes of all sizes, and noise.
cv::Mat picture(const cv::Size& size = {420, 360}, std::uint32_t seed = 3) {
  Random random(seed);
  cv::Mat image(size, CV_8U, cv::Scalar(128));
  const auto below = [&random](int bound) { return int(random.index(std::uint32_t(bound))); };
  for (int i = 0; i < 300; ++i) {
    // Compilers evaluate arguments in different orders: whatever is drawn has a statement of its own.
    const int x = below(size.width), y = below(size.height), radius = 2 + below(30);
    const cv::Point centre(x, y);
    if (i % 2) {
      cv::circle(image, centre, radius, below(256), cv::FILLED);
    } else {
      cv::rectangle(image, centre, centre + cv::Point(radius, 2 * radius), below(256), cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      std::uint8_t& pixel = image.at<std::uint8_t>(y, x);
      pixel = cv::saturate_cast<std::uint8_t>(pixel + below(7) - 3);
    }
  }
  return image;
}

Features detected(const cv::Mat& image, const SiftOptions& options = {}, int threads = 1,
                  const PlaceMask& mask = {}) {
  Features features;
  features.image_size = image.size();
  DetectionRequest request{image, threads, mask};
  request.describe = true;
  SiftDetector(options).detect(request, features);
  return features;
}

#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 4)
/// Noise of all scales, as in photographs.
cv::Mat texture(const cv::Size& size, std::uint32_t seed) {
  Random random(seed);
  cv::Mat sum(size, CV_32F, cv::Scalar(128));
  for (const double sigma : {0.7, 1.4, 2.8, 5.6, 11.2}) {
    cv::Mat noise(size, CV_32F);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) noise.at<float>(y, x) = float(random.index(1000)) / 1000 - 0.5F;
    }
    cv::GaussianBlur(noise, noise, {}, sigma);
    sum += 120 * sigma * noise;
  }
  cv::Mat image;
  sum.convertTo(image, CV_8U);
  return image;
}

/// The share of the keypoints of `a` that have one of `b` within half a pixel and 10 % of the scale.
double shareFound(const std::vector<cv::KeyPoint>& a, const std::vector<cv::KeyPoint>& b) {
  int found = 0;
  for (const cv::KeyPoint& p : a) {
    for (const cv::KeyPoint& q : b) {
      if (std::hypot(p.pt.x - q.pt.x, p.pt.y - q.pt.y) <= 0.5 && std::abs(p.size - q.size) <= 0.1 * p.size) {
        ++found;
        break;
      }
    }
  }
  return double(found) / double(std::max<std::size_t>(1, a.size()));
}

std::vector<cv::KeyPoint> openCvKeypoints(const cv::Mat& image) {
  std::vector<cv::KeyPoint> keypoints;
  cv::SIFT::create()->detect(image, keypoints);
  return keypoints;
}

TEST_F(Sift, AgreesWithOpenCvs) {
  for (const std::uint32_t seed : {3u, 4u}) {
    const cv::Mat image = texture({500, 400}, seed);
    const std::vector<cv::KeyPoint> ours = detected(image).keypoints, theirs = openCvKeypoints(image);
    ASSERT_GT(theirs.size(), 500u);
    EXPECT_GE(shareFound(theirs, ours), 0.95);
    EXPECT_GE(shareFound(ours, theirs), 0.95);
    EXPECT_NEAR(double(ours.size()) / double(theirs.size()), 1, 0.05);
  }
}

TEST_F(Sift, AgreesWithOpenCvsOnPhotographs) {
  const std::filesystem::path vgg = std::filesystem::path(corrsel::testing::realDataDir()) / "vgg";
  if (!std::filesystem::exists(vgg)) GTEST_SKIP() << "no dataset in " << vgg;
  double there = 0, back = 0;
  int images = 0;
  for (const std::string scene : {"bark", "bikes", "boat", "graf", "leuven", "trees", "ubc", "wall"}) {
    for (const std::string extension : {".ppm", ".pgm"}) {
      const std::filesystem::path file = vgg / scene / ("img1" + extension);
      if (!std::filesystem::exists(file)) continue;
      const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
      const std::vector<cv::KeyPoint> ours = detected(image).keypoints, theirs = openCvKeypoints(image);
      const double found = shareFound(theirs, ours);
      EXPECT_GE(found, 0.95) << scene;
      there += found;
      back += shareFound(ours, theirs);
      ++images;
    }
  }
  ASSERT_EQ(images, 8);
  RecordProperty("opencv_found", std::to_string(there / images));
  RecordProperty("found_by_opencv", std::to_string(back / images));
  EXPECT_GE(back / images, 0.95);
}
#endif

TEST_F(Sift, FindsBlobsWhereTheyAreWithoutBias) {
  // Gaussian blobs at known places: the extremum lies at the centre, and its scale is that of the blob.
  constexpr double kSigma = 3;
  cv::Mat image(200, 260, CV_8U, cv::Scalar(100));
  std::vector<cv::Point2d> centres;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 5; ++column) {
      centres.emplace_back(40 + 45 * column + 0.13 * row, 35 + 42 * row + 0.21 * column);
    }
  }
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      double value = 60;
      for (const cv::Point2d& c : centres) {
        value += 150 * std::exp(-((x - c.x) * (x - c.x) + (y - c.y) * (y - c.y)) / (2 * kSigma * kSigma));
      }
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(value);
    }
  }
  for (const int first_octave : {-1, 0}) {
    SiftOptions options;
    options.first_octave = first_octave;
    const Features found = detected(image, options);
    cv::Point2d bias;
    for (const cv::Point2d& c : centres) {
      double nearest = 1e9;
      cv::KeyPoint best;
      for (const cv::KeyPoint& k : found.keypoints) {
        const double distance = std::hypot(k.pt.x - c.x, k.pt.y - c.y);
        if (distance < nearest) {
          nearest = distance;
          best = k;
        }
      }
      EXPECT_LT(nearest, 0.15);
      EXPECT_NEAR(best.size / 2, kSigma, 0.2 * kSigma);
      bias += (cv::Point2d(best.pt) - c) / double(centres.size());
    }
    EXPECT_LT(std::hypot(bias.x, bias.y), 0.03) << "first octave " << first_octave;
  }
}

TEST_F(Sift, IsTheSameAtEveryKernelLevelAndForAnyNumberOfThreads) {
  const cv::Mat image = picture();
  for (const int first_octave : {-1, 0}) {
    for (const int most : {0, 100}) {
      SiftOptions options;
      options.first_octave = first_octave;
      options.max_features = most;
      setKernelLevel(KernelLevel::kPlain);
      const Features expected = detected(image, options);
      ASSERT_GT(expected.keypoints.size(), 50u);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        for (const int threads : {1, 2, 3, 7}) {
          SCOPED_TRACE(toString(level) + " " + std::to_string(threads));
          expectSame(detected(image, options, threads), expected);
        }
      }
    }
  }
}

TEST_F(Sift, CappedFeaturesAreTheStrongestOfAll) {
  const cv::Mat image = picture();
  Features all = detected(image);
  keepStrongest(0, false, image.size(), all);
  for (const bool spread : {false, true}) {
    for (const int most : {1, 7, 100, 333, 100000}) {
      SiftOptions options;
      options.max_features = most;
      options.spread = spread;
      Features expected = all, capped = detected(image, options);
      keepStrongest(most, spread, image.size(), expected);
      keepStrongest(most, spread, image.size(), capped);
      ASSERT_EQ(expected.keypoints.size(), std::min(all.keypoints.size(), std::size_t(most)));
      expectSame(capped, expected);
    }
  }
}

TEST_F(Sift, MasksDropFeaturesAndChangeNoOther) {
  const cv::Mat image = picture();
  Random random(8);
  for (int round = 0; round < 6; ++round) {
    cv::Mat mask(image.size(), CV_8U, cv::Scalar(0));
    for (int k = 0; k <= round; ++k) {
      const int x = int(random.index(400)), y = int(random.index(340));
      const int width = 10 + int(random.index(150)), height = 5 + int(random.index(150));
      cv::rectangle(mask, cv::Rect(x, y, width, height), 255, cv::FILLED);
    }
    const PlaceMask places(mask, AreaTransform(image.size(), {{0, 0}, image.size()}));
    for (const int most : {0, 40}) {
      SiftOptions options;
      Features expected = detected(image);
      places.apply(expected);
      keepStrongest(most, false, image.size(), expected);
      options.max_features = most;
      Features masked = detected(image, options, 2, places);
      keepStrongest(most, false, image.size(), masked);
      expectSame(masked, expected);
    }
  }
}

TEST_F(Sift, ImagesWithoutFeaturesAreFine) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 300), cv::Size(300, 1), cv::Size(5, 5),
                              cv::Size(6, 200), cv::Size(11, 13), cv::Size(200, 7)}) {
    for (const int first_octave : {-1, 0}) {
      SiftOptions options;
      options.first_octave = first_octave;
      for (const cv::Mat& image : {cv::Mat(size, CV_8U, cv::Scalar(77)), picture(size)}) {
        const Features features = detected(image, options, 3);
        ASSERT_EQ(features.frames.size(), features.keypoints.size());
        ASSERT_EQ(features.descriptors.rows, int(features.keypoints.size()));
      }
    }
  }
  EXPECT_TRUE(detected(cv::Mat(300, 400, CV_8U, cv::Scalar(200))).keypoints.empty());
}

TEST_F(Sift, ExtremeOptionsWork) {
  const cv::Mat image = picture({150, 130});
  for (const double sigma : {0.5, 5.0}) {
    for (const int layers : {1, 10}) {
      for (const int first_octave : {-1, 0}) {
        SiftOptions options;
        options.sigma = sigma;
        options.octave_layers = layers;
        options.first_octave = first_octave;
        options.contrast_threshold = 0;
        const Features one = detected(image, options), three = detected(image, options, 3);
        EXPECT_FALSE(one.keypoints.empty());
        expectSame(one, three);
      }
    }
  }
  SiftOptions options;
  options.contrast_threshold = 1;
  EXPECT_TRUE(detected(image, options).keypoints.empty());
}

TEST_F(Sift, KeypointsFollowTheConventions) {
  const Features f = detected(picture());
  ASSERT_GT(f.keypoints.size(), 300u);
  ASSERT_EQ(f.frames.size(), f.keypoints.size());
  ASSERT_EQ(f.descriptors.type(), CV_32F);
  ASSERT_EQ(f.descriptors.cols, 128);
  for (std::size_t i = 0; i < f.keypoints.size(); ++i) {
    const cv::KeyPoint& k = f.keypoints[i];
    const AffineFrame& a = f.frames[i];
    ASSERT_TRUE(k.angle >= 0 && k.angle < 360);
    ASSERT_NEAR(std::hypot(a[0], a[3]), k.size / 2, 1e-3);
    // The octave and the level that are packed are those of the size.
    const int octave = std::int8_t(k.octave & 255), level = k.octave >> 8 & 255;
    const double part = (k.octave >> 16 & 255) / 255.0 - 0.5;
    ASSERT_NEAR(k.size / 2, 1.6 * std::exp2(octave + (level + part) / 3), 0.01 * k.size);
    ASSERT_NEAR(cv::norm(f.descriptors.row(int(i))), 512, 40);
  }
}

TEST_F(Sift, DirectionsFollowARotationOfTheImage) {
  const cv::Mat image = picture({300, 300});
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const Features straight = detected(image), rotated = detected(turned);
  int compared = 0, right = 0;
  for (const cv::KeyPoint& k : straight.keypoints) {
    const cv::Point2f there(299 - k.pt.y, k.pt.x);
    double least = 360;
    for (const cv::KeyPoint& r : rotated.keypoints) {
      if (std::hypot(r.pt.x - there.x, r.pt.y - there.y) > 0.3 || std::abs(r.size - k.size) > 0.05 * k.size)
        continue;
      least = std::min(least, std::abs(std::remainder(double(r.angle) - k.angle - 90, 360.0)));
    }
    if (least == 360) continue;
    ++compared;
    right += least < 5;
  }
  EXPECT_GT(compared, int(straight.keypoints.size()) / 2);
  EXPECT_GT(right, 0.95 * compared);
}

TEST_F(Sift, RootTurnsTheDescriptorsIntoRootSift) {
  const cv::Mat image = picture();
  SiftOptions options;
  options.root = true;
  const Features plain = detected(image), root = detected(image, options);
  ASSERT_EQ(plain.keypoints.size(), root.keypoints.size());
  for (int row = 0; row < plain.descriptors.rows; row += 17) {
    const double sum = cv::sum(plain.descriptors.row(row))[0];
    for (int k = 0; k < 128; ++k) {
      ASSERT_NEAR(root.descriptors.at<float>(row, k),
                  std::min(255.0, 512 * std::sqrt(plain.descriptors.at<float>(row, k) / sum)), 0.51);
    }
  }
}

TEST_F(Sift, OrientationKernelsAreThePlainSum) {
  Random random(4);
  constexpr int kWidth = 90, kHeight = 70, kBins = OrientationKernels::kBins;
  std::vector<std::int16_t> pixels(std::size_t(kWidth * kHeight));
  for (std::int16_t& pixel : pixels) pixel = std::int16_t(random.index(255 * kGreyUnit));
  for (const int columns : {1, 5, 8, 9, 16, 17, 31, 40}) {
    for (const int rows : {1, 4, 30}) {
      std::vector<float> across(std::size_t(columns + OrientationKernels::kLanes), 0.0F), down;
      for (int k = 0; k < columns; ++k) across[std::size_t(k)] = float(0.1 + random.index(100) / 100.0);
      for (int k = 0; k < rows; ++k) down.push_back(float(0.1 + random.index(100) / 100.0));
      const std::int16_t* const window = pixels.data() + 7 * kWidth + 11;
      std::vector<double> expected(kBins, 0.0);
      double total = 0;
      for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
          const std::int16_t* const p = window + y * kWidth + x;
          const double dx = p[1] - p[-1], dy = p[kWidth] - p[-kWidth];
          double turn = std::atan2(dy, dx) / (2 * CV_PI);
          turn = turn < 0 ? turn + 1 : turn;
          const double weight = std::hypot(dx, dy) * across[std::size_t(x)] * down[std::size_t(y)];
          expected[std::size_t(int(turn * kBins + 0.5) % kBins)] += weight;
          total += weight;
        }
      }
      std::vector<float> first;
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        std::vector<float> bins(kBins);
        kernels().orientation.histogram(window, kWidth, columns, rows, across.data(), down.data(),
                                        bins.data());
        if (first.empty()) first = bins;
        ASSERT_EQ(bins, first) << toString(level);
      }
      // A direction at the border of two bins may fall into the other one.
      double difference = 0;
      for (int k = 0; k < kBins; ++k)
        difference += std::abs(first[std::size_t(k)] - expected[std::size_t(k)]);
      EXPECT_LT(difference, 0.02 * total + 1e-3);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
