#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "base/checksum.h"
#include "dataset_folder.h"
#include "datasets/generator.h"
#include "datasets/heinly_generated.h"
#include "datasets/sample.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Rectangles of all sizes with a little noise, made of whole numbers only.
cv::Mat drawn(const cv::Size& size, int type, std::uint64_t seed) {
  Random random(seed);
  const auto below = [&random](int bound) { return static_cast<int>(random.index(std::uint32_t(bound))); };
  cv::Mat image(size, type, cv::Scalar::all(128));
  for (int i = 0; i < 60; ++i) {
    const int x = below(size.width), y = below(size.height);
    const int width = 2 + below(40), height = 2 + below(30);
    const int first = below(256), second = below(256), third = below(256);
    image(cv::Rect(x, y, width, height) & cv::Rect({0, 0}, size)).setTo(cv::Scalar(first, second, third));
  }
  for (int y = 0; y < image.rows; ++y) {
    std::uint8_t* const row = image.ptr(y);
    for (int i = 0; i < image.cols * image.channels(); ++i) row[i] = std::uint8_t(row[i] / 2 + below(100));
  }
  return image;
}

void add(const cv::Mat& image, Checksum& checksum) {
  for (int y = 0; y < image.rows; ++y) {
    checksum.add(image.ptr(y), image.elemSize() * static_cast<std::size_t>(image.cols));
  }
}

double largestDifference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

TEST(Generator, BlursLikeAGaussian) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image = drawn({90, 70}, type, 1), before = image.clone();
    for (const double sigma : {0.33, 1.0, 2.5, 6.0}) {
      cv::Mat exact, expected;
      image.convertTo(exact, CV_64F);
      cv::GaussianBlur(exact, expected, {}, sigma, sigma, cv::BORDER_REFLECT_101);
      cv::Mat blurred;
      blur(image, sigma, cv::BORDER_REFLECT_101).convertTo(blurred, CV_64F);
      EXPECT_LT(largestDifference(blurred, expected), 3) << sigma;
      EXPECT_LT(cv::norm(blurred, expected, cv::NORM_L1) / double(expected.total()), 1) << sigma;
    }
    EXPECT_EQ(largestDifference(image, before), 0);
  }
}

TEST(Generator, BlurKeepsEvenAreas) {
  for (const double sigma : {0.33, 1.0, 2.5, 6.0, 40.0}) {
    const cv::Mat even(40, 30, CV_8UC1, cv::Scalar(200));
    EXPECT_EQ(largestDifference(blur(even, sigma, cv::BORDER_REPLICATE), even), 0) << sigma;
  }
}

TEST(Generator, WarpsLikeOpenCv) {
  const cv::Mat image = drawn({120, 90}, CV_8UC3, 2);
  for (const double degrees : {0.0, 30.0, 90.0, 200.0}) {
    cv::Matx33d map = similarity(0.8, degrees, image.size());
    map(2, 0) = 1e-3;
    cv::Mat expected;
    cv::warpPerspective(image, expected, map, image.size());
    // OpenCV 4.11 and its replacement on ARM interpolate on a finer grid.
    EXPECT_LT(cv::norm(warp(image, map), expected, cv::NORM_L1) / double(3 * image.total()), 2) << degrees;
  }
  EXPECT_EQ(largestDifference(warp(image, cv::Matx33d::eye()), image), 0);
}

TEST(Generator, SmoothsDistantViewsOnly) {
  const cv::Mat image = drawn({120, 90}, CV_8UC1, 3), before = image.clone();
  EXPECT_EQ(antialiased(image, similarity(1, 30, image.size())).data, image.data);
  const cv::Mat smooth = antialiased(image, similarity(3, 0, image.size()));
  EXPECT_EQ(largestDifference(smooth, blur(image, std::sqrt(2.0), cv::BORDER_REPLICATE)), 0);
  EXPECT_EQ(largestDifference(image, before), 0);
}

TEST(Generator, RoundsTheElementsOfAHomography) {
  cv::Matx33d homography(1.0 / 3, -1e-7 / 3, 500.0 / 3, 0, 1, -1, 1e-300, 2, 0.5);
  const cv::Matx33d once = rounded(homography);
  for (int i = 0; i < 9; ++i) {
    EXPECT_LE(std::abs(once.val[i] - homography.val[i]), std::ldexp(std::abs(homography.val[i]), -40)) << i;
    homography.val[i] *= 1 + 1e-15;  // more than a mathematics library is wrong
  }
  EXPECT_NE(once(0, 0), 1.0 / 3);
  EXPECT_EQ(rounded(homography), once);
}

/// The datasets that are made of photographs, with drawn ones in their places.
class GeneratedPictures : public DatasetFolder {
 protected:
  void SetUp() override {
    DatasetFolder::SetUp();
    std::uint64_t seed = 0;
    for (const std::string& name : SampleReader::imageNames()) {
      // The content decides about the format. PNG keeps every pixel.
      std::vector<std::uint8_t> file;
      ASSERT_TRUE(cv::imencode(".png", drawn({200, 150}, CV_8UC3, ++seed), file));
      write(name, std::string(file.begin(), file.end()));
    }
  }

  /// Of the homographies and pictures of one sequence.
  static std::string checksumOf(const DatasetReader& reader, const std::string& sequence) {
    Checksum checksum;
    for (std::size_t i = 0; i < reader.size(); ++i) {
      if (reader.id(i).sequence != sequence) continue;
      const ImagePair pair = reader.read(i);
      checksum.add(pair.truth.matrix.val, sizeof(pair.truth.matrix.val));
      add(pair.left, checksum);
      add(pair.right, checksum);
    }
    return checksum.text();
  }
};

/// The same values come from all compilers, processors and versions of OpenCV, see docs/evaluation.md.
TEST_F(GeneratedPictures, AreTheSameOnAllMachines) {
  const struct {
    const char *dataset, *sequence, *checksum;
  } expected[] = {{"sample", "zoom_rotation_1", "9dc678809373f3a3"},
                  {"sample", "zoom_rotation_2", "1587cde2205e337f"},
                  {"sample", "blur_1", "9415c2d980c9a848"},
                  {"sample", "blur_2", "302fc17f930eaa84"},
                  {"sample", "viewpoint_1", "04a225e80fd975a0"},
                  {"sample", "viewpoint_2", "86d3d46ad2a0e466"},
                  {"sample", "light", "134c96fce52be97e"},
                  {"sample", "jpeg", "a6ba36ce773cda6a"},
                  {"sample", "zoom", "25c89b60007a3914"},
                  {"sample", "rotation", "4060c4de85c73b11"},
                  {"heinly_generated", "zoom_1", "833cb8cb1e0a2075"},
                  {"heinly_generated", "zoom_2", "c0efe75456e0d6a9"},
                  {"heinly_generated", "rotation_1", "91b7ba190ed1e35b"},
                  {"heinly_generated", "rotation_2", "4d4c50835eac4763"}};
  const SampleReader sample(path(), 3);
  const HeinlyGeneratedReader heinly(path(), 3);
  for (const auto& e : expected) {
    const DatasetReader& reader = e.dataset == std::string("sample")
                                      ? static_cast<const DatasetReader&>(sample)
                                      : static_cast<const DatasetReader&>(heinly);
    const std::string checksum = checksumOf(reader, e.sequence);
    std::cout << checksum << " " << e.dataset << "/" << e.sequence << "\n";
    EXPECT_EQ(checksum, e.checksum) << e.dataset << "/" << e.sequence;
  }
}

}  // namespace
}  // namespace corrsel::core
