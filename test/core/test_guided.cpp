#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "cameras.h"
#include "corrsel/matching/guided.h"
#include "pose_scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::allCameras;
using testing::errorOf;
using testing::mentions;

/// Two images of a generated scene, and the right feature of every left one; -1 where there is none.
struct Images {
  Camera camera;
  Features left, right;
  MotionGuess motion;  ///< the true one
  std::vector<int> truth;
};

void fillRow(cv::Mat& descriptors, int row, Random& random) {
  for (int c = 0; c < descriptors.cols; ++c) {
    if (descriptors.type() == CV_8U)
      descriptors.at<std::uint8_t>(row, c) = std::uint8_t(random.index(256));
    else
      descriptors.at<float>(row, c) = std::min(255.0f, std::floor(40 * float(std::exp(random.normal()))));
  }
}

/// The descriptor of the same feature in the other image.
void disturb(const cv::Mat& from, int from_row, cv::Mat& to, int row, Random& random) {
  from.row(from_row).copyTo(to.row(row));
  for (int c = 0; c < to.cols; ++c) {
    if (to.type() == CV_8U) {
      for (int bit = 0; bit < 8; ++bit)
        to.at<std::uint8_t>(row, c) ^= std::uint8_t((random.index(5) == 0) << bit);
    } else {
      float& value = to.at<float>(row, c);
      value = std::min(255.0f, std::floor(value * float(std::max(0.0, 1 + 0.5 * random.normal()))));
    }
  }
}

struct SceneOptions {
  Camera camera = testing::plainCamera();
  int size = 1500, type = CV_8U;
  double degrees = 10, baseline = 0.3, right_share = 0.6;
};

/// Depths of 5 to 40, in random order on both sides.
Images generate(const SceneOptions& options, std::uint64_t seed) {
  Random random(seed);
  Images images;
  images.camera = options.camera;
  const cv::Vec3d w = pose_scene::randomDirection(random) * (options.degrees * CV_PI / 180);
  images.motion.rotation = moved({cv::Matx33d::eye(), {0, 0, 1}}, {w[0], w[1], w[2], 0, 0}).rotation;
  images.motion.translation = pose_scene::randomDirection(random);
  images.motion.rotation_sigma = 0.002;
  const int n = options.size, columns = options.type == CV_8U ? 32 : 128;
  for (Features* features : {&images.left, &images.right}) {
    features->image_size = options.camera.size;
    features->keypoints.resize(std::size_t(n));
    features->descriptors.create(n, columns, options.type);
  }
  std::vector<std::uint32_t> order(static_cast<std::size_t>(n));
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  random.shuffle(order);
  const cv::Size size = options.camera.size;
  const auto anywhere = [&] {
    const double x = random.uniform(0, size.width);
    return cv::Point2d(x, random.uniform(0, size.height));
  };
  for (int i = 0; i < n; ++i) {
    const cv::Point2d left = anywhere();
    const auto r = static_cast<int>(order[std::size_t(i)]);
    images.left.keypoints[std::size_t(i)] = {cv::Point2f(left), 5, -1, float(random.uniform())};
    fillRow(images.left.descriptors, i, random);
    Ray ray;
    cv::Point2d right;
    bool seen = random.uniform() < options.right_share && unproject(options.camera, left, ray);
    const double depth = random.uniform(5, 40);
    seen = seen &&
           project(
               options.camera,
               images.motion.rotation * ray.direction * depth + *images.motion.translation * options.baseline,
               right) &&
           cv::Rect2d({}, cv::Size2d(size)).contains(right);
    if (seen) {
      right = pose_scene::noisy(right, 0.7, random);
      disturb(images.left.descriptors, i, images.right.descriptors, r, random);
    } else {
      right = anywhere();
      fillRow(images.right.descriptors, r, random);
    }
    images.truth.push_back(seen ? r : -1);
    images.right.keypoints[std::size_t(r)] = {cv::Point2f(right), 5, -1, float(random.uniform())};
  }
  return images;
}

GuidedMatches guided(const Images& images, const MotionGuess& guess, const MatchOptions& options = {},
                     int threads = 1) {
  return matchGuided(images.left, images.right, images.camera, images.camera, guess, options, {}, threads);
}

double recall(const Images& images, const Correspondences& matches) {
  double found = 0;
  for (std::size_t i = 0; i < matches.size(); ++i)
    found += images.truth[matches.left_index[i]] == int(matches.right_index[i]) ? 1 : 0;
  return found /
         double(images.truth.size() - std::size_t(std::count(images.truth.begin(), images.truth.end(), -1)));
}

bool isSame(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

void expectSame(const Correspondences& a, const Correspondences& b) {
  EXPECT_EQ(a.left_index, b.left_index);
  EXPECT_EQ(a.right_index, b.right_index);
  EXPECT_TRUE(isSame(a.distance, b.distance));
  EXPECT_TRUE(isSame(a.second_distance, b.second_distance));
  EXPECT_TRUE(isSame(a.right_x, b.right_x));
}

float distance(const Images& images, std::size_t l, std::size_t r) {
  const cv::Mat a = images.left.descriptors.row(int(l)), b = images.right.descriptors.row(int(r));
  return float(cv::norm(a, b, a.type() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2));
}

MotionGuess rotationOf(const Images& images) {
  MotionGuess guess = images.motion;
  guess.translation.reset();
  return guess;
}

TEST(Guided, FindsMoreThanTheExhaustiveSearchWithAllCameras) {
  for (const auto& [name, camera] : allCameras()) {
    SCOPED_TRACE(name);
    SceneOptions options;
    options.camera = camera;
    options.degrees = 20;
    for (const bool translates : {false, true}) {
      const Images images = generate(options, 1);
      const GuidedMatches found = guided(images, translates ? images.motion : rotationOf(images));
      EXPECT_EQ(found.verdict, GuessVerdict::kConfirmed);
      EXPECT_GE(recall(images, found.matches),
                recall(images, matchFeatures(images.left, images.right)) - 0.005);
      EXPECT_GE(recall(images, found.matches), 0.98);
    }
  }
}

TEST(Guided, NearestOfAllNearThePredictedPlace) {
  for (const int type : {CV_8U, CV_32F}) {
    SceneOptions options;
    options.type = type;
    options.size = 600;
    const Images images = generate(options, 2);
    const GuidedMatches found = guided(images, rotationOf(images));
    ASSERT_EQ(found.verdict, GuessVerdict::kConfirmed);
    const double radius = GuidedOptions().radius * 1e-3 * std::hypot(640, 480);
    std::vector<std::uint8_t> matched(images.left.keypoints.size());
    for (std::size_t i = 0; i < found.matches.size(); ++i) {
      const std::uint32_t l = found.matches.left_index[i], r = found.matches.right_index[i];
      matched[l] = 1;
      EXPECT_NEAR(found.matches.distance[i], distance(images, l, r), 1e-3);
      Ray ray;
      cv::Point2d place;
      unproject(images.camera, cv::Point2d(images.left.keypoints[l].pt), ray);
      if (!project(images.camera, images.motion.rotation * ray.direction, place)) continue;
      // The sides of a group of 8 of 600 features and its diagonals are no longer than this.
      const double farthest = 2 * radius + 3 * 1.42 * std::sqrt(8 * 640 * 480 / 600.0);
      EXPECT_LT(cv::norm(cv::Point2d(images.right.keypoints[r].pt) - place), farthest);
      for (std::uint32_t other = 0; other < images.right.keypoints.size(); ++other) {
        if (other == r || cv::norm(cv::Point2d(images.right.keypoints[other].pt) - place) > radius) continue;
        const float d = distance(images, l, other);
        EXPECT_TRUE(d > found.matches.distance[i] || (d == found.matches.distance[i] && other > r));
        EXPECT_LE(found.matches.second_distance[i], d + 1e-3);
      }
    }
    // Features whose area has a right feature are matched.
    for (std::size_t l = 0; l < matched.size(); ++l) {
      Ray ray;
      cv::Point2d place;
      unproject(images.camera, cv::Point2d(images.left.keypoints[l].pt), ray);
      const bool projects = project(images.camera, images.motion.rotation * ray.direction, place);
      const bool has_candidate =
          projects &&
          std::any_of(images.right.keypoints.begin(), images.right.keypoints.end(),
                      [&](const cv::KeyPoint& k) { return cv::norm(cv::Point2d(k.pt) - place) < radius; });
      EXPECT_TRUE(matched[l] || !has_candidate) << l;
    }
  }
}

TEST(Guided, WrongOnesGiveTheExhaustiveMatches) {
  Random random(4);
  for (const int type : {CV_8U, CV_32F}) {
    SceneOptions options;
    options.type = type;
    const Images images = generate(options, 3);
    MatchOptions match;
    match.mutual = type == CV_8U;
    const Correspondences expected = matchFeatures(images.left, images.right, match);
    for (const double degrees : {15.0, 30.0, 60.0}) {
      // About the vertical, so that the images overlap all the same.
      const cv::Matx33d turn =
          moved({cv::Matx33d::eye(), {0, 0, 1}}, {0, degrees * CV_PI / 180, 0, 0, 0}).rotation;
      MotionGuess guess = images.motion;
      guess.rotation = turn * guess.rotation;
      if (degrees > 20) guess.translation.reset();
      const GuidedMatches found = guided(images, guess, match);
      EXPECT_NE(found.verdict, GuessVerdict::kConfirmed);
      EXPECT_TRUE(degrees > 40 || found.verdict == GuessVerdict::kContradicted);
      expectSame(found.matches, expected);
    }
  }
}

TEST(Guided, AWrongTranslationIsLeftOut) {
  SceneOptions options;
  options.baseline = 0.5;
  const Images images = generate(options, 5);
  MotionGuess guess = images.motion;
  guess.translation = cv::normalize(guess.translation->cross(cv::Vec3d(0.3, 0.2, 0.9)));
  const GuidedMatches found = guided(images, guess), expected = guided(images, rotationOf(images));
  EXPECT_EQ(found.verdict, GuessVerdict::kConfirmed);
  expectSame(found.matches, expected.matches);
}

TEST(Guided, TooFewFeaturesDecideNothing) {
  SceneOptions options;
  options.size = 12;
  const Images images = generate(options, 1);
  const GuidedMatches found = guided(images, images.motion);
  EXPECT_EQ(found.verdict, GuessVerdict::kNone);
  expectSame(found.matches, matchFeatures(images.left, images.right));
  Images empty = images;
  empty.right = {};
  EXPECT_TRUE(guided(empty, images.motion).matches.empty());
}

TEST(Guided, UnrelatedImagesConfirmNothing) {
  SceneOptions options;
  options.right_share = 0;
  const Images images = generate(options, 6);
  const GuidedMatches found = guided(images, images.motion);
  EXPECT_NE(found.verdict, GuessVerdict::kConfirmed);
  expectSame(found.matches, matchFeatures(images.left, images.right));
}

TEST(Guided, DoesNotDependOnThreads) {
  for (const bool mutual : {false, true}) {
    const Images images = generate({}, 7);
    MatchOptions options;
    options.mutual = mutual;
    options.second_distance_radius = mutual ? 4 : 0;
    for (const MotionGuess& guess : {images.motion, rotationOf(images)}) {
      const GuidedMatches one = guided(images, guess, options);
      EXPECT_EQ(one.verdict, GuessVerdict::kConfirmed);
      for (const int threads : {2, 5})
        expectSame(guided(images, guess, options, threads).matches, one.matches);
    }
  }
}

TEST(Guided, MutualMatchesAreOneToOne) {
  const Images images = generate({}, 8);
  MatchOptions options;
  options.mutual = true;
  const GuidedMatches all = guided(images, rotationOf(images)),
                      mutual = guided(images, rotationOf(images), options);
  ASSERT_EQ(mutual.verdict, GuessVerdict::kConfirmed);
  EXPECT_LT(mutual.matches.size(), all.matches.size());
  std::vector<std::uint32_t> right = mutual.matches.right_index;
  std::sort(right.begin(), right.end());
  EXPECT_EQ(std::adjacent_find(right.begin(), right.end()), right.end());
  EXPECT_GE(recall(images, mutual.matches), recall(images, all.matches) - 0.01);
}

TEST(Guided, IsSeveralTimesAsFast) {
#if !defined(__x86_64__)
  GTEST_SKIP() << "an emulated processor takes other times";
#endif
  if (testing::kSanitized) GTEST_SKIP() << "sanitizers take times of their own";
  for (const int type : {CV_8U, CV_32F}) {
    SceneOptions options;
    options.type = type;
    options.size = 5000;
    options.camera.matrix = {800, 0, 500, 0, 800, 375, 0, 0, 1};
    options.camera.size = {1000, 750};
    const Images images = generate(options, 9);
    const auto seconds = [](const auto& work) {
      double best = 1e9;
      for (int round = 0; round < 5; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        work();
        best =
            std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
      }
      return best;
    };
    GuidedMatches found;
    const double fast = seconds([&] { found = guided(images, rotationOf(images)); });
    const double slow = seconds([&] { matchFeatures(images.left, images.right); });
    EXPECT_EQ(found.verdict, GuessVerdict::kConfirmed);
    EXPECT_GT(slow / fast, type == CV_8U ? 1.2 : 2) << (type == CV_8U ? "bits" : "numbers");
  }
}

TEST(Guided, ErrorsNameWhatIsWrong) {
  const Images images = generate({}, 1);
  MotionGuess guess = images.motion;
  guess.rotation_sigma = -1;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { guided(images, guess); }), {"rotation_sigma"}));
  GuidedOptions options;
  options.radius = 0;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] {
                         matchGuided(images.left, images.right, images.camera, images.camera, images.motion,
                                     {}, options);
                       }),
                       {"radius"}));
}

}  // namespace
}  // namespace corrsel::core
