#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>

#include "feature_checks.h"
#include "features/detectors/blob.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

struct Disc {
  double x, y, radius, contrast;
};

/// Discs on grey 128; pixels on their rims hold the covered part, of 8 x 8 samples.
cv::Mat discs(const std::vector<Disc>& list, cv::Size size = {200, 160}) {
  constexpr int kSamples = 8;
  cv::Mat image(size, CV_32F, cv::Scalar(128));
  for (const Disc& disc : list) {
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        if (std::hypot(x - disc.x, y - disc.y) > disc.radius + 1) continue;
        int inside = 0;
        for (int i = 0; i < kSamples * kSamples; ++i) {
          const double dx = x - disc.x + (i % kSamples + 0.5) / kSamples - 0.5;
          const double dy = y - disc.y + (i / kSamples + 0.5) / kSamples - 0.5;
          inside += std::hypot(dx, dy) < disc.radius;
        }
        image.at<float>(y, x) += float(disc.contrast * inside / (kSamples * kSamples));
      }
    }
  }
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  return grey;
}

/// Discs of all sizes anywhere.
cv::Mat picture(cv::Size size = {500, 400}, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat image(size, CV_8U, cv::Scalar(128));
  for (int i = 0; i < size.area() / 600; ++i) {
    // Compilers evaluate arguments in different orders: whatever is drawn has a statement of its own.
    const double y = random.uniform(0, size.height), x = random.uniform(0, size.width);
    const std::uint32_t grey = random.index(256);
    const double radius = random.uniform(2, 20);
    cv::circle(image, cv::Point(int(x), int(y)), int(radius), cv::Scalar(grey), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

Features detect(const cv::Mat& image, const BlobOptions& options = {}, int threads = 1) {
  Features features;
  BlobDetector(options).detect({image, threads}, features);
  EXPECT_EQ(features.frames.size(), features.keypoints.size());
  return features;
}

/// The strongest keypoint whose size differs from the disc's by less than half an octave; size 0: none.
cv::KeyPoint blobOf(const Features& features, const Disc& disc) {
  cv::KeyPoint best;
  for (const cv::KeyPoint& k : features.keypoints) {
    if (std::hypot(k.pt.x - disc.x, k.pt.y - disc.y) > disc.radius / 2) continue;
    if (std::abs(std::log2(k.size / (2 * disc.radius))) < 0.5 && k.response > best.response) best = k;
  }
  return best;
}

TEST(Blob, FindsDiscsWithTheirPlaceAndRadius) {
  for (const double radius : {3.5, 5.0, 8.0, 12.0, 20.0, 31.0}) {
    for (const double contrast : {100.0, -100.0}) {
      for (const double shift : {0.0, 0.25, 0.5}) {
        const Disc disc{99 + shift, 80 - shift / 2, radius, contrast};
        const cv::KeyPoint found = blobOf(detect(discs({disc})), disc);
        ASSERT_GT(found.size, 0) << radius << " " << contrast << " " << shift;
        const double sigma = radius / std::sqrt(2.0);
        EXPECT_LT(std::hypot(found.pt.x - disc.x, found.pt.y - disc.y), 0.04 * sigma)
            << radius << " " << shift;
        EXPECT_NEAR(found.size / (2 * radius), 1, 0.03) << radius << " " << shift;
        // 2 / e of the contrast, a little less for the camera's blur that is assumed and not there.
        EXPECT_NEAR(found.response / 100, 2 / std::exp(1.0), 0.03) << radius << " " << shift;
      }
    }
  }
}

TEST(Blob, FindsADiscOnce) {
  // Halfway between pixels, several samples are equal.
  for (const double shift : {0.0, 0.5}) {
    EXPECT_EQ(detect(discs({{100 + shift, 80 + shift, 9, 90}})).keypoints.size(), 1u) << shift;
  }
}

TEST(Blob, SizesFollowTheImage) {
  const std::vector<Disc> small = {{40.3, 40.1, 5, 80}, {90.7, 60.2, 7, -60}, {150, 110.6, 10, 100}};
  std::vector<Disc> large;
  for (const Disc& d : small) large.push_back({1.7 * d.x, 1.7 * d.y, 1.7 * d.radius, d.contrast});
  const Features a = detect(discs(small)), b = detect(discs(large, {340, 272}));
  for (std::size_t i = 0; i < small.size(); ++i) {
    const cv::KeyPoint p = blobOf(a, small[i]), q = blobOf(b, large[i]);
    ASSERT_GT(p.size, 0);
    EXPECT_NEAR(q.size / p.size, 1.7, 0.04);
    EXPECT_NEAR(q.response / p.response, 1, 0.03);
  }
}

TEST(Blob, AnglesFollowTheGradientAndFramesTheAngle) {
  // A disc on a ramp that rises along (cos, sin).
  for (const double angle : {10.0, 100.0, 200.0, 345.0}) {
    cv::Mat image = discs({{100, 80, 6, 60}});
    const double c = std::cos(angle * CV_PI / 180), s = std::sin(angle * CV_PI / 180);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(image.at<std::uint8_t>(y, x) +
                                                                       1.5 * (c * (x - 100) + s * (y - 80)));
      }
    }
    const Features features = detect(image);
    const cv::KeyPoint found = blobOf(features, {100, 80, 6, 60});
    ASSERT_GT(found.size, 0) << angle;
    EXPECT_NEAR(std::remainder(found.angle - angle, 360), 0, 3) << angle;
  }
  const Features features = detect(picture());
  ASSERT_GT(features.keypoints.size(), 100u);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const cv::KeyPoint& k = features.keypoints[i];
    const AffineFrame& a = features.frames[i];
    ASSERT_TRUE(k.angle >= 0 && k.angle < 360);
    ASSERT_NEAR(std::hypot(a[0], a[3]), k.size / 2, 1e-3);
    ASSERT_NEAR(std::remainder(std::atan2(a[3], a[0]) * 180 / CV_PI - k.angle, 360), 0, 1e-2);
  }
}

TEST(Blob, KeepsItsLimits) {
  const cv::Mat image = picture();
  BlobOptions options;
  const std::size_t all = detect(image, options).keypoints.size();
  options.threshold = 30;
  options.min_sigma = 3;
  options.max_sigma = 7;
  const Features some = detect(image, options);
  EXPECT_GT(some.keypoints.size(), 20u);
  EXPECT_LT(some.keypoints.size(), all);
  for (const cv::KeyPoint& k : some.keypoints) {
    EXPECT_GE(k.response, 30);
    EXPECT_GE(k.size, float(2 * std::sqrt(2.0) * 3));
    EXPECT_LE(k.size, float(2 * std::sqrt(2.0) * 7));
    EXPECT_TRUE(k.pt.x >= k.size / 2 && k.pt.y >= k.size / 2 && k.pt.x <= 499 - k.size / 2 &&
                k.pt.y <= 399 - k.size / 2);
  }
}

TEST(Blob, DropsEdges) {
  // Ellipses: the longer, the more their middle is an edge. At the best scale of the narrow side.
  cv::Mat image(200, 300, CV_8U, cv::Scalar(100));
  cv::ellipse(image, {150, 100}, {60, 6}, 0, 0, 360, cv::Scalar(200), cv::FILLED, cv::LINE_AA);
  cv::GaussianBlur(image, image, {}, 1);
  const auto inTheMiddle = [&image](double edge_ratio) {
    BlobOptions options;
    options.edge_ratio = edge_ratio;
    int count = 0;
    for (const cv::KeyPoint& k : detect(image, options).keypoints) count += std::abs(k.pt.x - 150) < 10;
    return count;
  };
  EXPECT_EQ(inTheMiddle(10), 0);
  EXPECT_GT(inTheMiddle(1000), 0);
}

TEST(Blob, BlankAndTinyImagesHaveNoFeatures) {
  for (const cv::Mat& image :
       {cv::Mat(200, 200, CV_8U, cv::Scalar(0)), cv::Mat(300, 200, CV_8U, cv::Scalar(255)),
        cv::Mat(1, 1, CV_8U, cv::Scalar(7)), cv::Mat(1, 500, CV_8U, cv::Scalar(7)),
        cv::Mat(500, 1, CV_8U, cv::Scalar(7)), cv::Mat(picture()({0, 0, 7, 7}))}) {
    BlobOptions options;
    options.threshold = 0.1;
    EXPECT_TRUE(detect(image, options).keypoints.empty()) << image.size();
  }
  for (int side = 1; side < 70; ++side) {
    for (const cv::KeyPoint& k : detect(picture({side, 90 - side})).keypoints) {
      ASSERT_TRUE(std::isfinite(k.pt.x + k.pt.y + k.size + k.angle + k.response)) << side;
    }
  }
  EXPECT_EQ(detect(discs({{7.6, 8.2, 4, 100}}, {16, 16})).keypoints.size(), 1u);
}

TEST(Blob, HugeImages) {
  if (kSanitized) GTEST_SKIP() << "takes minutes under sanitizers";
  cv::Mat image(6000, 8000, CV_8U, cv::Scalar(128));
  const std::vector<Disc> list = {{50, 40, 6, 100}, {4000.5, 3000.25, 20, -90}, {7900, 5950, 12, 100}};
  for (const Disc& d : list) {
    const int side = int(2 * d.radius) + 40, left = int(d.x) - side / 2, top = int(d.y) - side / 2;
    discs({{d.x - left, d.y - top, d.radius, d.contrast}}, {side, side})
        .copyTo(image(cv::Rect(left, top, side, side) & cv::Rect(0, 0, 8000, 6000)));
  }
  BlobOptions options;
  options.layers = 2;  // for time
  const Features features = detect(image, options, 2);
  for (const Disc& d : list) {
    const cv::KeyPoint found = blobOf(features, d);
    EXPECT_LT(std::hypot(found.pt.x - d.x, found.pt.y - d.y), 0.04 * d.radius) << d.x;
    EXPECT_NEAR(found.size / (2 * d.radius), 1, 0.1) << d.x;
  }
}

TEST(Blob, BandsLeaveNoSeam) {
  // 1300 rows are three bands, as are the same rows moved by 130.
  const cv::Mat tall = picture({120, 1430});
  const Features a = detect(tall.rowRange(0, 1300)), b = detect(tall.rowRange(130, 1430));
  const auto places = [](const Features& features, double shift) {
    std::set<std::pair<int, int>> set;
    for (const cv::KeyPoint& k : features.keypoints) {
      if (k.octave > 1) continue;  // the others depend on the place of the first pixel
      const double y = k.pt.y + shift;
      if (y > 330 && y < 1100) set.insert({cvRound(20 * k.pt.x), cvRound(20 * y)});
    }
    return set;
  };
  EXPECT_GT(places(a, 0).size(), 50u);
  EXPECT_EQ(places(a, 0), places(b, 130));
}

TEST(Blob, DoesNotDependOnThreads) {
  const cv::Mat image = picture({400, 1200});
  const Features expected = detect(image);
  EXPECT_GT(expected.keypoints.size(), 200u);
  const int before = cv::getNumThreads();
  for (const int opencv_threads : {1, 2, 3}) {
    cv::setNumThreads(opencv_threads);
    for (const int threads : {0, 1, 2, 3}) expectSameKeypoints(detect(image, {}, threads), expected);
  }
  cv::setNumThreads(before);
}

TEST(Blob, PartsOfImagesAreImages) {
  const cv::Mat part = picture()(cv::Rect(50, 40, 300, 200));
  expectSameKeypoints(detect(part), detect(part.clone()));
}

TEST(Blob, ReplacesWhatWasThere) {
  Features features;
  BlobDetector().detect({picture()}, features);
  BlobDetector().detect({picture({300, 300}, 2)}, features);
  expectSameKeypoints(features, detect(picture({300, 300}, 2)));
}

TEST(Blob, RunsAtTheEndsOfTheRanges) {
  const cv::Mat image = picture()(cv::Rect(0, 0, 200, 150)).clone();
  for (const double min_sigma : {1.0, 16.0}) {
    for (const int layers : {1, 10}) {
      BlobOptions options;
      options.min_sigma = min_sigma;
      options.max_sigma = 1000;
      options.layers = layers;
      options.threshold = 0.1;
      const Features features = detect(image, options);
      EXPECT_GT(features.keypoints.size(), 5u) << min_sigma << " " << layers;
      for (const cv::KeyPoint& k : features.keypoints) {
        ASSERT_TRUE(std::isfinite(k.pt.x + k.pt.y + k.size + k.angle + k.response));
        ASSERT_GE(k.size, float(2 * std::sqrt(2.0) * min_sigma));
      }
    }
  }
}

TEST(Blob, NamesOptionsOutOfRange) {
  const auto refusal = [](const OptionMap& values) {
    BlobOptions options;
    setOptions(options, values, "blob");
    return errorOf<std::invalid_argument>([&] { BlobDetector detector(options); });
  };
  EXPECT_TRUE(mentions(refusal({{"threshold", "0"}}), {"threshold = 0", "[0.1, 255]"}));
  EXPECT_TRUE(mentions(refusal({{"min_sigma", "0.5"}}), {"min_sigma = 0.5", "[1, 16]"}));
  EXPECT_TRUE(mentions(refusal({{"layers", "11"}}), {"layers = 11", "[1, 10]"}));
  EXPECT_TRUE(mentions(refusal({{"max_features", "-1"}}), {"max_features = -1", "[0, 100000]"}));
  EXPECT_TRUE(
      mentions(refusal({{"min_sigma", "8"}, {"max_sigma", "5"}}), {"min_sigma = 8", "max_sigma = 5"}));
  EXPECT_EQ(BlobDetector().name(), "blob");
}

TEST(BlobOnPhotographs, FindsHundreds) {
  const std::string folder = sharedData("vgg");
  if (folder.empty()) GTEST_SKIP() << "no vgg data";
  const auto reader = openDataset("vgg", folder);
  for (std::size_t i = 0; i < reader->size(); i += 5) {
    cv::Mat grey = reader->read(i).left;
    if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    const std::size_t count = detect(grey, {}, 2).keypoints.size();
    EXPECT_GE(count, 500u) << reader->id(i).text();
    EXPECT_LE(count, 4000u) << reader->id(i).text();
  }
}

}  // namespace
}  // namespace corrsel::core
