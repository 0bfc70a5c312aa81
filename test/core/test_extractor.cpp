#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "feature_checks.h"
#include "features/descriptors/descriptor.h"
#include "features/detectors/blob.h"
#include "features/parts/image_options.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class EveryExtractor : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<FeatureExtractor> create(const OptionMap& options = {}) const {
    const std::string detector = algorithmsOf(GetParam()).front();
    AlgorithmOptions all = {{detector, options}};
    if (detector == "asift") all["asift"].insert({"tilts", "2"});  // 10 of 43 views
    return createExtractor(GetParam(), all);
  }
};

/// Type and length of the descriptors of every algorithm.
const std::map<std::string, std::pair<int, int>>& descriptorForms() {
  static const std::map<std::string, std::pair<int, int>> forms = {
      {"sift", {CV_32F, 128}}, {"asift", {CV_32F, 128}}, {"orb", {CV_8U, 32}},       {"akaze", {CV_8U, 61}},
      {"brisk", {CV_8U, 64}},  {"freak", {CV_8U, 64}},   {"cv_sift", {CV_32F, 128}}, {"cv_orb", {CV_8U, 32}}};
  return forms;
}

TEST_P(EveryExtractor, DescribesEveryKeypoint) {
  const cv::Mat image = shapes();
  const auto extractor = create();
  EXPECT_EQ(extractor->name(), GetParam());
  const Features features = extractor->extract(image);
  EXPECT_GT(features.keypoints.size(), 100u);
  EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()));
  const auto [type, columns] = descriptorForms().at(algorithmsOf(GetParam()).back());
  EXPECT_EQ(features.descriptors.type(), type);
  EXPECT_EQ(features.descriptors.cols, columns);
  EXPECT_EQ(features.image_size, image.size());
  EXPECT_GT(features.detect_seconds, 0);
  const bool one_pass = algorithmsOf(GetParam()).size() == 1;
  EXPECT_EQ(features.describe_seconds > 0, !one_pass);
  std::vector<std::string> names = algorithmsOf(GetParam());
  names.emplace_back(kImageOptions);
  std::vector<std::string> of_options;
  for (const auto& [name, options] : extractor->options()) of_options.push_back(name);
  EXPECT_EQ(of_options, names);
  for (const cv::KeyPoint& p : features.keypoints) {
    EXPECT_TRUE(cv::Rect2f(-0.5F, -0.5F, 400, 300).contains(p.pt)) << p.pt;
  }
}

TEST_P(EveryExtractor, FramesFitTheirKeypoints) {
  const std::string detector = algorithmsOf(GetParam()).front();
  const bool affine = detector == "hessian_affine" || detector == "asift";
  const Features f = create()->extract(shapes());
  ASSERT_EQ(f.frames.size(), f.keypoints.size());
  for (std::size_t i = 0; i < f.frames.size(); ++i) {
    const cv::KeyPoint& k = f.keypoints[i];
    const AffineFrame& a = f.frames[i];
    ASSERT_TRUE(a[2] == k.pt.x && a[5] == k.pt.y);
    ASSERT_NEAR(std::sqrt(a[0] * a[4] - a[1] * a[3]), k.size / 2, 1e-3 * k.size);
    ASSERT_TRUE(k.angle >= 0 && k.angle <= 360) << k.angle;
    if (!affine) {
      ASSERT_TRUE(a[0] == a[4] && a[1] == -a[3]);
    }
    // FREAK measures an angle of its own and leaves affine frames as they are.
    if (affine && algorithmsOf(GetParam()).back() == "freak") continue;
    const double difference = std::atan2(a[3], a[0]) * 180 / CV_PI - k.angle;
    ASSERT_NEAR(std::remainder(difference, 360), 0, 1e-2);
  }
}

TEST_P(EveryExtractor, DescriptorsBelongToTheirKeypoints) {
  // Of a picture and the same picture moved by 8 px, the nearest descriptors must be 8 px apart.
  const cv::Mat image = shapes(1, {408, 300});
  const Features a = create()->extract(image.colRange(0, 400)), b = create()->extract(image.colRange(8, 408));
  const Correspondences m = matchFeatures(a, b);
  int distinct = 0, moved = 0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (!(m.distance[i] < 0.5 * m.second_distance[i])) continue;
    ++distinct;
    moved += std::abs(m.left_x[i] - m.right_x[i] - 8) < 1 && std::abs(m.left_y[i] - m.right_y[i]) < 1;
  }
  EXPECT_GT(distinct, 20);
  EXPECT_GE(moved, 0.9 * distinct);
}

TEST_P(EveryExtractor, StrongestFirst) {
  const Features features = create()->extract(shapes());
  for (std::size_t i = 1; i < features.keypoints.size(); ++i) {
    ASSERT_GE(features.keypoints[i - 1].response, features.keypoints[i].response) << i;
  }
}

TEST_P(EveryExtractor, KeepsTheStrongestUpToTheCap) {
  const cv::Mat image = shapes();
  const Features all = create()->extract(image);
  const Features some = create({{"max_features", "40"}})->extract(image);
  EXPECT_LE(some.keypoints.size(), 40u);
  const bool one_pass = algorithmsOf(GetParam()).size() == 1;
  EXPECT_GE(some.keypoints.size(), one_pass ? 35u : 20u);
  EXPECT_EQ(some.descriptors.rows, int(some.keypoints.size()));
  // ORB hands out its cap over the levels of the pyramid;
  // descriptors of other detectors' keypoints may lose those near the border.
  if (GetParam() == "sift+sift" || GetParam() == "hessian_affine+sift") {
    for (std::size_t i = 0; i < 40; ++i) {
      EXPECT_EQ(some.keypoints[i].pt, all.keypoints[i].pt);
      EXPECT_EQ(some.keypoints[i].response, all.keypoints[i].response);
    }
    EXPECT_EQ(cv::norm(some.descriptors, all.descriptors.rowRange(0, 40), cv::NORM_INF), 0);
  }
  EXPECT_LE(create({{"max_features", "1"}})->extract(image).keypoints.size(), 1u);
}

TEST_P(EveryExtractor, SpreadsWhatItKeeps) {
  // Strong contrast on the left, weak on the right.
  cv::Mat image = shapes(1, {800, 300});
  cv::Mat weak = image.colRange(400, 800);
  weak.convertTo(weak, -1, 0.4, 128 * 0.6);
  const auto onTheRight = [&](const OptionMap& options) {
    const Features features = create(options)->extract(image);
    EXPECT_LE(features.keypoints.size(), 100u);
    // Descriptors of other detectors' keypoints may lose those near the border.
    EXPECT_GE(features.keypoints.size(), algorithmsOf(GetParam()).size() == 1 ? 90u : 60u);
    return std::count_if(features.keypoints.begin(), features.keypoints.end(),
                         [](const cv::KeyPoint& k) { return k.pt.x > 400; });
  };
  const auto strongest = onTheRight({{"max_features", "100"}});
  const auto spread = onTheRight({{"max_features", "100"}, {"spread", "true"}});
  EXPECT_GT(spread, strongest + 5);
  EXPECT_GT(spread, 10);
}

TEST_P(EveryExtractor, LargeImagesAreReduced) {
  const cv::Mat image = shapes(1, {800, 600});
  const Features whole = create()->extract(image);
  cv::Mat large;
  cv::resize(image, large, {8000, 6000}, 0, 0, cv::INTER_NEAREST);
  const Features features = create({{"max_megapixels", "0.48"}})->extract(large);
  EXPECT_EQ(features.image_size, cv::Size(8000, 6000));
  ASSERT_EQ(features.keypoints.size(), whole.keypoints.size());
  EXPECT_EQ(cv::norm(features.descriptors, whole.descriptors, cv::NORM_INF), 0);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const cv::KeyPoint &large_one = features.keypoints[i], &small = whole.keypoints[i];
    ASSERT_NEAR(large_one.pt.x, (small.pt.x + 0.5) * 10 - 0.5, 1e-2);
    ASSERT_NEAR(large_one.pt.y, (small.pt.y + 0.5) * 10 - 0.5, 1e-2);
    ASSERT_NEAR(large_one.size, small.size * 10, 1e-3 * large_one.size);
    const AffineFrame& frame = features.frames[i];
    ASSERT_TRUE(frame[2] == large_one.pt.x && frame[5] == large_one.pt.y);
    ASSERT_NEAR(frame[0], whole.frames[i][0] * 10, 1e-3 * large_one.size);
  }
}

TEST_P(EveryExtractor, BlankAndTinyImagesHaveNoFeatures) {
  const std::vector<cv::Mat> images = {
      cv::Mat(200, 200, CV_8U, cv::Scalar(0)), cv::Mat(200, 200, CV_8UC3, cv::Scalar::all(255)),
      cv::Mat(1, 1, CV_8U, cv::Scalar(7)),     cv::Mat(1, 500, CV_8U, cv::Scalar(7)),
      cv::Mat(500, 1, CV_8U, cv::Scalar(7)),   shapes()({0, 0, 8, 8}).clone()};
  for (const cv::Mat& image : images) {
    const Features features = create()->extract(image);
    EXPECT_TRUE(features.keypoints.empty()) << image.size();
    EXPECT_TRUE(features.descriptors.empty());
    EXPECT_EQ(features.image_size, image.size());
  }
}

TEST_P(EveryExtractor, SmallImagesDoNoHarm) {
  for (int side = 1; side <= 90; side += 1 + side / 20) {
    const Features features = create()->extract(shapes(1, {side, side}));
    ASSERT_EQ(features.descriptors.rows, int(features.keypoints.size())) << side;
  }
  const Features sixteen = create()->extract(shapes()({100, 100, 16, 16}));
  EXPECT_EQ(sixteen.image_size, cv::Size(16, 16));
  EXPECT_EQ(sixteen.descriptors.rows, int(sixteen.keypoints.size()));
}

TEST_P(EveryExtractor, ColourIsTurnedToGrey) {
  const cv::Mat colour = shapes(3);
  cv::Mat grey, with_alpha;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(colour, with_alpha, cv::COLOR_BGR2BGRA);
  const Features expected = create()->extract(grey);
  EXPECT_GT(expected.keypoints.size(), 50u);
  expectSame(create()->extract(colour), expected);
  expectSame(create()->extract(with_alpha), expected);
}

TEST_P(EveryExtractor, SixteenBitsAreScaledToEight) {
  cv::Mat grey = shapes(), deep;
  const Features expected = create()->extract(grey);
  EXPECT_GT(expected.keypoints.size(), 50u);
  grey.convertTo(deep, CV_16U, 257);
  expectSame(create()->extract(deep), expected);
  // Up to half a step is rounded away.
  cv::Mat noise(deep.size(), CV_16S);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, -128, 129);
  cv::add(deep, noise, deep, cv::noArray(), CV_16U);
  expectSame(create()->extract(deep), expected);
}

TEST_P(EveryExtractor, PartsOfImagesAreImages) {
  const cv::Mat image = shapes();
  const cv::Rect part(50, 40, 300, 200);
  const Features expected = create()->extract(image(part).clone());
  expectSame(create()->extract(image(part)), expected);
  // Pixels outside the part do not matter.
  cv::Mat framed(400, 500, CV_8U, cv::Scalar(255));
  image(part).copyTo(framed({60, 70, part.width, part.height}));
  expectSame(create()->extract(framed({60, 70, part.width, part.height})), expected);
}

TEST_P(EveryExtractor, RefusesOtherImagesByName) {
  const auto refusal = [this](const cv::Mat& image) {
    return errorOf<std::invalid_argument>([&] { create()->extract(image); });
  };
  const std::string needed = "; needed: 8 or 16 bits with 1, 3 (BGR) or 4 (BGRA) channels";
  EXPECT_TRUE(mentions(refusal({}), {"image", "empty"}));
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_16S, cv::Scalar(0))), "image has type CV_16SC1" + needed);
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_32FC3, cv::Scalar(0))), "image has type CV_32FC3" + needed);
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_8UC2, cv::Scalar(0))), "image has type CV_8UC2" + needed);
  EXPECT_EQ(refusal(cv::Mat(100, 100, CV_16UC2, cv::Scalar(0))), "image has type CV_16UC2" + needed);
  EXPECT_EQ(refusal(cv::Mat(2, 2, CV_64F, cv::Scalar(0))), "image has type CV_64FC1" + needed);
}

TEST_P(EveryExtractor, DoesNotDependOnThreads) {
  const cv::Mat left = shapes(1, {500, 400}, 2), right = shapes(3, {400, 300}, 3);
  const auto extractor = create();
  const Features expected_left = create()->extract(left), expected_right = create()->extract(right);
  const int before = cv::getNumThreads();
  for (const int opencv_threads : {1, 2}) {
    cv::setNumThreads(opencv_threads);
    for (const int threads : {0, 1, 2}) {
      const auto [a, b] = extractPair(*extractor, left, right, threads);
      expectSame(a, expected_left);
      expectSame(b, expected_right);
    }
  }
  cv::setNumThreads(before);
  // An error on either side comes through, from the other thread too.
  for (const int threads : {1, 2}) {
    EXPECT_TRUE(mentions(errorOf([&] { extractPair(*extractor, left, {}, threads); }), {"image", "empty"}));
    EXPECT_TRUE(mentions(errorOf([&] { extractPair(*extractor, {}, right, threads); }), {"image", "empty"}));
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryExtractor, ::testing::ValuesIn(combinations()), combinationName);

TEST(Extractor, NamesWhatIsValid) {
  EXPECT_EQ(extractorNames(),
            (std::vector<std::string>{"hessian_affine+sift", "sift+sift", "orb+orb", "asift+asift",
                                      "blob+freak", "akaze+akaze", "brisk+brisk"}));
  const std::string valid = "; valid: detector+descriptor, e.g. " + joinList(extractorNames()) +
                            "; detectors: " + joinList(detectorNames()) +
                            "; descriptors: " + joinList(descriptorNames());
  for (const std::string name :
       {"surf+surf", "xyz", "", "+", "+sift", "sift+sift+sift", "sift+xyz", "xyz+sift", "freak+freak"}) {
    EXPECT_EQ(errorOf<std::invalid_argument>([&] { createExtractor(name); }),
              "unknown features '" + name + "'" + valid);
  }
  const std::pair<std::string, std::string> misspelt[] = {
      // One algorithm where two are needed: the usual combination with it.
      {"sift", "sift+sift"},
      {"orb", "orb+orb"},
      {"sift+", "sift+sift"},
      {"hessian_affine", "hessian_affine+sift"},
      {"freak", "blob+freak"},
      {"cv_sift", "cv_sift+cv_sift"},
      {"SIFT", "sift+sift"},
      {"sfit", "sift+sift"},
      {"hessian", "hessian_affine+sift"},
      // Two algorithms, of which one is misspelt or both are.
      {"sift+sfit", "sift+sift"},
      {"hesian_afine+sift", "hessian_affine+sift"},
      {"obr+obr", "orb+orb"},
      {"orb+freek", "orb+freak"},
      {"akaze+akase", "akaze+akaze"},
      // The descriptor comes first.
      {"sift+hessian_affine", "hessian_affine+sift"},
      {"freak+blob", "blob+freak"},
  };
  for (const auto& [name, meant] : misspelt) {
    EXPECT_EQ(errorOf<std::invalid_argument>([name = name] { createExtractor(name); }),
              "unknown features '" + name + "'; did you mean '" + meant + "'?" + valid.substr(1));
    if (!isMissing(meant)) {
      EXPECT_EQ(createExtractor(meant)->name(), meant);
    }
  }
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] {
                         createExtractor("orb+orb", {{"orb", {{"sigma", "1"}}}});
                       }),
                       {"orb.sigma", "valid: max_features"}));
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { createExtractor("orb+akaze"); }),
                       {"'orb+akaze'", "akaze+akaze"}));
}

TEST(Extractor, NeedsADescriptorWhereTheDetectorHasNone) {
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(
                           [] { FeatureExtractor("blob", std::make_unique<BlobDetector>(), nullptr, {}); }),
                       {"'blob'", "descriptor", "keypoints"}));
}

TEST(Extractor, EveryPairingWorksOrSaysWhyNot) {
  const cv::Mat image = shapes(1, {160, 120});
  for (const std::string& detector : detectorNames()) {
    for (const std::string& descriptor : descriptorNames()) {
      const std::string name = detector + "+" + descriptor;
      if (isMissing(name)) continue;
      const bool possible = detector == descriptor || (descriptor != "akaze" && descriptor != "asift" &&
                                                       descriptor != "cv_sift" && descriptor != "cv_orb");
      if (possible) {
        const Features features = createExtractor(name)->extract(image);
        EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size())) << name;
        EXPECT_EQ(features.frames.size(), features.keypoints.size()) << name;
        EXPECT_GT(features.keypoints.size(), 10u) << name;
      } else {
        EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { createExtractor(name); }), "cannot work"))
            << name;
      }
    }
  }
}

TEST(Extractor, OptionsOfOtherAlgorithmsAreNotLookedAt) {
  const cv::Mat image = shapes();
  expectSame(createExtractor("orb+orb", {{"sift", {{"nonsense", "1"}}}})->extract(image),
             createExtractor("orb+orb")->extract(image));
}

TEST(Extractor, ClaheFindsFeaturesInTheEqualizedImage) {
  cv::Mat dark, expected;
  shapes().convertTo(dark, CV_8U, 0.15);
  cv::createCLAHE(3.0, {4, 4})->apply(dark, expected);
  const OptionMap clahe = {{"equalize", "clahe"}, {"clahe_clip", "3"}, {"clahe_tiles", "4"}};
  for (const std::string name : {"sift+sift", "orb+orb", "sift+freak"}) {
    const auto plain = createExtractor(name);
    const Features raised = createExtractor(name, {{kImageOptions, clahe}})->extract(dark);
    expectSame(raised, plain->extract(expected));
    EXPECT_GT(raised.keypoints.size(), plain->extract(dark).keypoints.size()) << name;
    expectSame(createExtractor(name, {{kImageOptions, {{"equalize", "none"}}}})->extract(dark),
               plain->extract(dark));
  }
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([] {
                         createExtractor("orb+orb", {{kImageOptions, {{"equalize", "all"}}}});
                       }),
                       "equalize"));
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([] {
                         createExtractor("orb+orb", {{kImageOptions, {{"clahe_tiles", "0"}}}});
                       }),
                       "image: option clahe_tiles = 0"));
}

TEST(Extractor, RootSiftIsTheSquareRoot) {
  const cv::Mat image = shapes();
  for (const std::string name : {"sift+sift", "hessian_affine+sift"}) {
    const Features plain = createExtractor(name)->extract(image);
    const Features root = createExtractor(name, {{"sift", {{"root", "true"}}}})->extract(image);
    ASSERT_EQ(root.descriptors.size(), plain.descriptors.size());
    for (int i = 0; i < root.descriptors.rows; ++i) {
      const double total = cv::norm(plain.descriptors.row(i), cv::NORM_L1);
      for (int k = 0; k < 128; ++k) {
        ASSERT_NEAR(root.descriptors.at<float>(i, k),
                    512 * std::sqrt(plain.descriptors.at<float>(i, k) / total), 0.51);
      }
    }
  }
}

TEST(Extractor, NamesOptionsOutOfRange) {
  const auto refusal = [](const std::string& name, const OptionMap& options) {
    return errorOf<std::invalid_argument>([&] {
      createExtractor(name, {{algorithmsOf(name).front(), options}});
    });
  };
  EXPECT_TRUE(mentions(refusal("orb+orb", {{"levels", "0"}}), {"orb", "levels = 0", "[1, 16]"}));
  EXPECT_TRUE(
      mentions(refusal("orb+orb", {{"scale_factor", "1"}}), {"orb", "scale_factor = 1", "[1.05, 3]"}));
  EXPECT_TRUE(
      mentions(refusal("sift+sift", {{"max_features", "-1"}}), {"sift", "max_features = -1", "[0, 100000]"}));
  EXPECT_TRUE(mentions(refusal("sift+sift", {{"sigma", "x"}}), {"'x'", "sift.sigma"}));
}

TEST(Extractor, OptionsReachTheAlgorithm) {
  const cv::Mat image = shapes();
  const auto count = [&image](const std::string& name, const OptionMap& options) {
    return createExtractor(name, {{algorithmsOf(name).front(), options}})->extract(image).keypoints.size();
  };
  EXPECT_LT(count("sift+sift", {{"contrast_threshold", "0.15"}}), count("sift+sift", {}));
  EXPECT_LT(count("sift+sift", {{"edge_threshold", "2"}}), count("sift+sift", {}));
  EXPECT_NE(count("sift+sift", {{"sigma", "2.5"}}), count("sift+sift", {}));
  EXPECT_NE(count("sift+sift", {{"octave_layers", "5"}}), count("sift+sift", {}));
  EXPECT_LT(count("orb+orb", {{"levels", "1"}}), count("orb+orb", {}));
  EXPECT_LT(count("orb+orb", {{"fast_threshold", "100"}}), count("orb+orb", {}));
  EXPECT_NE(count("orb+orb", {{"scale_factor", "1.5"}}), count("orb+orb", {}));
  EXPECT_NE(count("orb+orb", {{"patch_size", "15"}}), count("orb+orb", {}));
}

TEST(Extractor, ExtremeOptionsDoNoHarm) {
  // Every option at both ends of its range, the others at their defaults.
  const cv::Mat image = shapes(1, {200, 150});
  for (const std::string& name : extractorNames()) {
    const auto extractor = createExtractor(name);
    for (const auto& [algorithm, defaults] : extractor->options()) {
      for (const OptionText& option : listOptions(*defaults)) {
        const bool number = option.range.front() == '[';
        const std::string range = number ? option.range.substr(1, option.range.size() - 2) : option.range;
        for (const std::string& value : splitList(range)) {
          // The smallest scale must not be above the largest.
          if (option.name == "max_sigma" && value == "1") continue;
          const Features features =
              createExtractor(name, {{algorithm, {{option.name, value}}}})->extract(image);
          EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size()))
              << name << " " << algorithm << "." << option.name << " " << value;
        }
      }
    }
  }
}

}  // namespace
}  // namespace corrsel::core
