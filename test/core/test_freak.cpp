#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgproc.hpp>
#include <set>

#include "corrsel/matching/matcher.h"
#include "features/descriptors/freak.h"
#include "features/descriptors/freak_pattern.h"
#include "features/detectors/blob.h"
#include "features/parts/feature_list.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Discs and squares of all sizes, no two neighbourhoods alike.
cv::Mat picture(cv::Size size = {500, 400}, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat image(size, CV_8U, cv::Scalar(128));
  for (int i = 0; i < size.area() / 250; ++i) {
    const int y = int(random.uniform(0, size.height)), x = int(random.uniform(0, size.width));
    const cv::Point centre(x, y);
    const int radius = int(random.uniform(2, 16));
    const cv::Scalar grey(random.uniform(10, 200));
    if (i % 2) {
      cv::circle(image, centre, radius, grey, cv::FILLED);
    } else {
      cv::rectangle(image, centre, centre + cv::Point(radius, 2 * radius), grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 1.0);
  return image;
}

Features featuresAt(const std::vector<cv::KeyPoint>& keypoints) {
  Features features;
  features.keypoints = keypoints;
  features.frames = similarityFrames(keypoints);
  return features;
}

Features describe(const cv::Mat& image, const std::vector<cv::KeyPoint>& keypoints,
                  const FreakOptions& options = {}, int threads = 1) {
  Features features = featuresAt(keypoints);
  FreakDescriptor(options).describe(image, threads, Workspace::ofThread(), features);
  features.image_size = image.size();
  return features;
}

std::vector<cv::KeyPoint> blobs(const cv::Mat& image) {
  Features features;
  BlobDetector().detect({image, 2}, features);
  return features.keypoints;
}

double distance(const cv::Mat& a, int i, const cv::Mat& b, int j) {
  return cv::norm(a.row(i), b.row(j), cv::NORM_HAMMING);
}

TEST(FreakPattern, HasSevenRingsOfSixAndACentre) {
  const auto fields = freakPattern();
  EXPECT_EQ(fields.size(), 43u);
  double before = 1;
  for (std::size_t ring = 0; ring < 7; ++ring) {
    const double radius = std::hypot(fields[6 * ring].x, fields[6 * ring].y);
    EXPECT_LT(radius, before);
    for (std::size_t i = 0; i < 6; ++i) {
      const FreakField& f = fields[6 * ring + i];
      EXPECT_NEAR(std::hypot(f.x, f.y), radius, 1e-12);
      EXPECT_NEAR(f.sigma, radius / 2, 1e-12);
      const double angle = 60.0 * double(i) + (ring % 2 ? 30 : 0);
      EXPECT_NEAR(std::remainder(std::atan2(f.y, f.x) * 180 / CV_PI - angle, 360), 0, 1e-9);
      // Fields of neighbouring rings overlap.
      if (ring > 0) {
        EXPECT_GT(radius + f.sigma, before - before / 2);
      }
    }
    before = radius;
  }
  EXPECT_NEAR(std::hypot(fields[0].x, fields[0].y), 2.0 / 3, 1e-12);
  EXPECT_NEAR(std::hypot(fields[6].x, fields[6].y), 0.5, 1e-12);  // 2/3 - 6 (7/12) / 21
  EXPECT_NEAR(before, 2.0 / 24, 1e-12);
  EXPECT_TRUE(fields[42].x == 0 && fields[42].y == 0 && fields[42].sigma == fields[36].sigma);
}

TEST(FreakPattern, OrientationPairsAreSymmetric) {
  const auto fields = freakPattern();
  const auto pairs = freakOrientationPairs();
  std::set<FreakPair> distinct;
  int diameters = 0;
  double xx = 0, xy = 0, yy = 0;
  for (const auto& [a, b] : pairs) {
    distinct.insert(std::minmax(a, b));
    EXPECT_EQ(a / 6, b / 6);  // of one ring
    const double dx = fields[a].x - fields[b].x, dy = fields[a].y - fields[b].y, d = std::hypot(dx, dy);
    diameters += std::hypot(fields[a].x + fields[b].x, fields[a].y + fields[b].y) < 1e-12;
    xx += dx * dx / d, xy += dx * dy / d, yy += dy * dy / d;
  }
  EXPECT_EQ(distinct.size(), 45u);
  EXPECT_EQ(diameters, 21);
  // A slope is seen alike in every direction.
  EXPECT_NEAR(xx, yy, 1e-9);
  EXPECT_NEAR(xy, 0, 1e-9);
}

TEST(FreakPattern, TestsAreDistinctCandidatesCoarseToFine) {
  const std::vector<FreakPair> all = freakCandidatePairs();
  const std::set<FreakPair> candidates(all.begin(), all.end());
  EXPECT_EQ(candidates.size(), 903u);
  const auto fields = freakPattern();
  std::set<FreakPair> distinct;
  double before = 10;
  for (const FreakPair& pair : kFreakPairs) {
    EXPECT_EQ(candidates.count(pair), 1u) << int(pair.first) << " " << int(pair.second);
    distinct.insert(pair);
    const double extent = fields[pair.first].sigma + fields[pair.second].sigma;
    EXPECT_LT(extent, before + 1e-9);
    before = extent;
  }
  EXPECT_EQ(distinct.size(), 512u);
}

TEST(FreakSampler, BoxesCountCoveredParts) {
  // On a slope the mean of a box is the level at its centre, wherever between pixels it begins.
  cv::Mat image(100, 120, CV_8U);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 120; ++x) image.at<std::uint8_t>(y, x) = std::uint8_t(x + y);
  }
  const auto fields = freakPattern();
  const FreakSampler sampler(image, 22);
  for (const double size : {2.0, 7.0, 9.3, 14.0}) {
    const cv::Point2f position(60.3F, 50.45F);
    ASSERT_TRUE(sampler.fits(position, size));
    for (const double angle : {0.0, 0.4, 2.0}) {
      const auto means = sampler.means(position, size, angle);
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const double scale = 22 * size / 7, c = scale * std::cos(angle), s = scale * std::sin(angle);
        const double x = position.x + c * fields[i].x - s * fields[i].y;
        const double y = position.y + s * fields[i].x + c * fields[i].y;
        // A box narrower than two pixels sees the steps between them.
        EXPECT_NEAR(means[i], x + y, 0.2) << size << " " << i;
      }
    }
    EXPECT_NEAR(sampler.orientation(position, size), CV_PI / 4, 0.02) << size;
  }
}

TEST(FreakSampler, SumsOfLargeImagesAreRight) {
  // 255 * 6000 * 4000 exceeds 2^32: the integral image wraps around.
  cv::Mat image(6000, 4000, CV_8U, cv::Scalar(255));
  image.rowRange(5900, 6000).setTo(250);
  const FreakSampler sampler(image, 22);
  for (const double size : {5.0, 30.0, 600.0}) {
    ASSERT_TRUE(sampler.fits({2000, 3500}, size));
    for (const float mean : sampler.means({2000, 3500}, size, 0.3)) ASSERT_EQ(mean, 255) << size;
  }
  for (const float mean : sampler.means({3950, 5960}, 5, 0)) ASSERT_EQ(mean, 250);
}

TEST(FreakSampler, PatternsMustLieWithinTheImage) {
  const cv::Mat image(101, 121, CV_8U, cv::Scalar(9));
  const FreakSampler sampler(image, 21);
  // Of a keypoint of 7 px it reaches 21 px, and the pixels reach half a pixel beyond their centres.
  EXPECT_TRUE(sampler.fits({20.5F, 50}, 7));
  EXPECT_FALSE(sampler.fits({20.4F, 50}, 7));
  EXPECT_TRUE(sampler.fits({60, 79.5F}, 7));
  EXPECT_FALSE(sampler.fits({60, 79.6F}, 7));
  EXPECT_TRUE(sampler.fits({60, 50}, 16));
  EXPECT_FALSE(sampler.fits({60, 50}, 17));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(sampler.fits({nan, 50}, 7));
  EXPECT_FALSE(sampler.fits({60, 50}, 0));
  EXPECT_FALSE(sampler.fits({60, 50}, nan));
  EXPECT_FALSE(sampler.fits({60, 50}, infinity));
  // At the very border nothing is read outside.
  for (const double angle : {0.0, CV_PI / 6, CV_PI / 2}) {
    for (const float mean : sampler.means({20.5F, 20.5F}, 7, angle)) ASSERT_EQ(mean, 9);
    for (const float mean : sampler.means({99.5F, 79.5F}, 7, angle)) ASSERT_EQ(mean, 9);
  }
}

TEST(Freak, DescribesInOrderAndRemovesTheBorder) {
  const cv::Mat image = picture();
  const std::vector<cv::KeyPoint> all = blobs(image);
  const Features features = describe(image, all);
  ASSERT_GT(features.keypoints.size(), 100u);
  ASSERT_LT(features.keypoints.size(), all.size());
  EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()));
  EXPECT_EQ(features.descriptors.cols, 64);
  EXPECT_EQ(features.descriptors.type(), CV_8U);
  ASSERT_EQ(features.frames.size(), features.keypoints.size());
  const FreakSampler sampler(image, 22);
  std::size_t kept = 0;
  for (const cv::KeyPoint& k : all) {
    if (!sampler.fits(k.pt, k.size)) continue;
    ASSERT_LT(kept, features.keypoints.size());
    EXPECT_EQ(features.keypoints[kept].pt, k.pt);
    EXPECT_EQ(features.keypoints[kept].size, k.size);
    ++kept;
  }
  EXPECT_EQ(kept, features.keypoints.size());
  EXPECT_EQ(features.frames, similarityFrames(features.keypoints));
  for (const cv::KeyPoint& k : features.keypoints) EXPECT_TRUE(k.angle >= 0 && k.angle <= 360);
}

TEST(Freak, BitsAreTheTests) {
  const cv::Mat image = picture();
  FreakOptions upright;
  upright.orientation_normalized = false;
  const Features features = describe(image, {{250.3F, 200.8F, 9, 77}}, upright);
  ASSERT_EQ(features.descriptors.rows, 1);
  EXPECT_EQ(features.keypoints[0].angle, 77);
  const auto means = FreakSampler(image, 22).means({250.3F, 200.8F}, 9, 0);
  for (std::size_t i = 0; i < 512; ++i) {
    const auto [a, b] = kFreakPairs[i];
    EXPECT_EQ((features.descriptors.at<std::uint8_t>(0, int(i / 8)) >> (i % 8)) & 1, means[a] > means[b])
        << i;
  }
}

TEST(Freak, AffineFramesAreKept) {
  const cv::Mat image = picture();
  Features features = featuresAt({{250, 200, 9, 77}, {150, 200, 9, 77}, {2, 2, 9, 77}, {300, 200, 9, 77}});
  const AffineFrame ellipse = {6, 1, 150, 0, 3, 200}, mirrored = {4.5F, 0, 300, 0, -4.5F, 200};
  features.frames[1] = ellipse;
  features.frames[3] = mirrored;
  FreakDescriptor().describe(image, 1, Workspace::ofThread(), features);
  ASSERT_EQ(features.keypoints.size(), 3u);
  EXPECT_EQ(features.frames[0], similarityFrames(features.keypoints)[0]);
  EXPECT_NE(features.keypoints[0].angle, 77);
  EXPECT_EQ(features.frames[1], ellipse);
  EXPECT_EQ(features.frames[2], mirrored);
}

/// The map of an image onto a canvas that holds all of it, turned by `degrees` and `scale` times as large.
cv::Matx33d similarity(const cv::Size& size, double degrees, double scale, cv::Size& canvas) {
  const double c = scale * std::cos(degrees * CV_PI / 180), s = scale * std::sin(degrees * CV_PI / 180);
  const double w = size.width - 1, h = size.height - 1;
  const double width = std::abs(c) * w + std::abs(s) * h, height = std::abs(s) * w + std::abs(c) * h;
  canvas = {cvRound(width) + 1, cvRound(height) + 1};
  return {c, -s, (width - c * w + s * h) / 2, s, c, (height - s * w - c * h) / 2, 0, 0, 1};
}

struct Turn {
  double degrees, scale;
};

constexpr Turn kTurns[] = {{30, 1}, {90, 1}, {180, 1}, {0, 1.5}, {30, 1.5}};

/// Shares of the nearest neighbours between an image and itself turned and scaled that are right within 3 px,
/// percent.
struct Shares {
  double mapped;  ///< keypoints found in the first image and mapped, their angles discarded
  double anew;    ///< keypoints found in both images
  double mutual;  ///< of those that are nearest to each other: others may not have been found again
};

Shares sharesOfRight(const cv::Mat& image, const Turn& turn) {
  cv::Size canvas;
  const cv::Matx33d map = similarity(image.size(), turn.degrees, turn.scale, canvas);
  cv::Mat turned;
  cv::warpPerspective(image, turned, map, canvas, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  const Features left = describe(image, blobs(image));
  std::vector<cv::KeyPoint> keypoints;
  for (const cv::KeyPoint& k : left.keypoints) {
    const cv::Point2d place = projected(map, k.pt.x, k.pt.y);
    keypoints.emplace_back(cv::Point2f(place), k.size * float(turn.scale), 0.0F);
  }
  const auto share = [&](const Features& right, bool mutual) {
    MatchOptions options;
    options.mutual = mutual;
    const Correspondences matches = matchFeatures(left, right, options);
    EXPECT_GT(matches.size(), 200u);
    GroundTruth truth;
    truth.kind = TruthKind::kHomography;
    truth.matrix = map;
    int right_ones = 0;
    for (const double error : groundTruthErrors(truth, matches)) right_ones += error <= 3;
    return 100.0 * right_ones / double(matches.size());
  };
  const Features anew = describe(turned, blobs(turned));
  return {share(describe(turned, keypoints), false), share(anew, false), share(anew, true)};
}

void expectInvariance(const cv::Mat& image) {
  for (const Turn& turn : kTurns) {
    const Shares shares = sharesOfRight(image, turn);
    EXPECT_GE(shares.mapped, 95) << turn.degrees << " " << turn.scale;
    EXPECT_GE(shares.anew, 80) << turn.degrees << " " << turn.scale;
    EXPECT_GE(shares.mutual, 90) << turn.degrees << " " << turn.scale;
  }
}

TEST(Freak, DoesNotDependOnRotationAndScale) { expectInvariance(picture()); }

TEST(Freak, AnglesTurnWithTheImage) {
  const cv::Mat image = picture();
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_180);
  const Features a = describe(image, blobs(image));
  std::vector<cv::KeyPoint> keypoints;
  for (const cv::KeyPoint& k : a.keypoints) {
    keypoints.emplace_back(499 - k.pt.x, 399 - k.pt.y, k.size, 0.0F);
  }
  const Features b = describe(turned, keypoints);
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    EXPECT_NEAR(std::remainder(a.keypoints[i].angle - b.keypoints[i].angle - 180, 360), 0, 0.5);
    EXPECT_LE(distance(a.descriptors, int(i), b.descriptors, int(i)), 12);
  }
}

TEST(Freak, DoesNotDependOnBrightness) {
  const cv::Mat image = picture();
  const std::vector<cv::KeyPoint> keypoints = blobs(image);
  cv::Mat brighter, doubled, half;
  image.convertTo(brighter, CV_8U, 1, 40);
  image.convertTo(half, CV_8U, 0.5);
  half.convertTo(doubled, CV_8U, 2);
  const Features a = describe(image, keypoints), b = describe(brighter, keypoints);
  EXPECT_EQ(cv::norm(a.descriptors, b.descriptors, cv::NORM_INF), 0);
  const Features c = describe(half, keypoints), d = describe(doubled, keypoints);
  EXPECT_LT(cv::norm(c.descriptors, d.descriptors, cv::NORM_HAMMING) / c.descriptors.rows, 8);
}

TEST(Freak, NormalisationCanBeSwitchedOff) {
  const cv::Mat image = picture();
  FreakOptions options;
  options.scale_normalized = false;
  const cv::Point2f place(250, 200);
  const auto at = [&](float size) { return describe(image, {{place, size, 0}}, options).descriptors; };
  EXPECT_EQ(distance(at(7), 0, at(30), 0), 0);
  options.scale_normalized = true;
  EXPECT_GT(distance(at(7), 0, at(30), 0), 50);
  options.pattern_scale = 44;
  const cv::Mat twice = at(7);
  options.pattern_scale = 22;
  EXPECT_EQ(distance(twice, 0, at(14), 0), 0);
}

TEST(Freak, DoesNotDependOnThreads) {
  const cv::Mat image = picture();
  const std::vector<cv::KeyPoint> keypoints = blobs(image);
  const Features expected = describe(image, keypoints);
  const int before = cv::getNumThreads();
  for (const int opencv_threads : {1, 3}) {
    cv::setNumThreads(opencv_threads);
    for (const int threads : {0, 1, 2, 3}) {
      const Features features = describe(image, keypoints, {}, threads);
      ASSERT_EQ(features.keypoints.size(), expected.keypoints.size());
      EXPECT_EQ(cv::norm(features.descriptors, expected.descriptors, cv::NORM_INF), 0);
      EXPECT_EQ(features.frames, expected.frames);
    }
  }
  cv::setNumThreads(before);
}

TEST(Freak, BlankTinyAndHugeImages) {
  const auto count = [](const cv::Size& size, const cv::KeyPoint& keypoint) {
    const Features features = describe(cv::Mat(size, CV_8U, cv::Scalar(77)), {keypoint});
    EXPECT_EQ(features.descriptors.type(), CV_8U);
    EXPECT_EQ(features.descriptors.cols, 64);
    if (features.descriptors.rows) {
      EXPECT_EQ(cv::countNonZero(features.descriptors), 0);
    }
    return features.keypoints.size();
  };
  EXPECT_EQ(count({1, 1}, {0, 0, 7}), 0u);
  EXPECT_EQ(count({16, 16}, {8, 8, 7}), 0u);
  EXPECT_EQ(count({16, 16}, {8, 8, 2}), 1u);
  EXPECT_EQ(count({200, 200}, {100, 100, 7}), 1u);
  EXPECT_EQ(count({8000, 6000}, {4000, 3000, 900}), 1u);
  EXPECT_EQ(count({8000, 6000}, {4000, 3000, 1e9F}), 0u);
  EXPECT_EQ(describe(cv::Mat(50, 50, CV_8U, cv::Scalar(1)), {}).descriptors.rows, 0);
}

TEST(Freak, PartsOfImagesAreImages) {
  const cv::Mat part = picture()(cv::Rect(50, 40, 300, 200));
  const std::vector<cv::KeyPoint> keypoints = blobs(part);
  const Features a = describe(part, keypoints), b = describe(part.clone(), keypoints);
  ASSERT_GT(a.descriptors.rows, 20);
  EXPECT_EQ(cv::norm(a.descriptors, b.descriptors, cv::NORM_INF), 0);
}

TEST(Freak, NamesOptionsOutOfRange) {
  FreakOptions options;
  options.pattern_scale = 1;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { FreakDescriptor descriptor(options); }),
            "option pattern_scale = 1 is outside [5, 100]");
  EXPECT_EQ(FreakDescriptor().name(), "freak");
}

class FreakOnPhotographs : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = sharedData("vgg");
    if (folder.empty()) GTEST_SKIP() << "no vgg data";
    reader_ = openDataset("vgg", folder);
  }

  ImagePair read(const std::string& scene) const {
    for (std::size_t i = 0; i < reader_->size(); ++i) {
      if (reader_->id(i).text() == "vgg/" + scene + "/1-2") return reader_->read(i);
    }
    ADD_FAILURE() << scene << " is missing";
    return {};
  }

  static cv::Mat grey(const cv::Mat& image) {
    cv::Mat result = image;
    if (image.channels() == 3) cv::cvtColor(image, result, cv::COLOR_BGR2GRAY);
    return result;
  }

  std::unique_ptr<DatasetReader> reader_;
};

TEST_F(FreakOnPhotographs, MatchesOfBlobsAreRight) {
  const std::pair<const char*, double> least[] = {{"graf", 45},  {"boat", 38}, {"leuven", 60}, {"ubc", 70},
                                                  {"bikes", 50}, {"wall", 50}, {"trees", 25}};
  for (const auto& [scene, percent] : least) {
    const ImagePair pair = read(scene);
    const cv::Mat left = grey(pair.left), right = grey(pair.right);
    const Features a = describe(left, blobs(left)), b = describe(right, blobs(right));
    EXPECT_GE(a.keypoints.size(), 500u) << scene;
    const Correspondences matches = matchFeatures(a, b);
    double right_ones = 0;
    for (const double error : groundTruthErrors(pair.truth, matches)) right_ones += error <= 5;
    EXPECT_GE(100 * right_ones / double(matches.size()), percent) << scene;
  }
}

TEST_F(FreakOnPhotographs, DoesNotDependOnRotationAndScale) {
  for (const char* scene : {"graf", "boat", "leuven"}) {
    const cv::Mat image = grey(read(scene).left);
    SCOPED_TRACE(scene);
    expectInvariance(image);
  }
}

}  // namespace
}  // namespace corrsel::core
