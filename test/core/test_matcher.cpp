#include <gtest/gtest.h>
#include <sys/resource.h>

#include <limits>

#include "corrsel/matching/matcher.h"
#include "kernels/descriptor.h"
#include "matching/nearest.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Features with the given descriptors; keypoint i is at (i, 2 i).
Features features(const cv::Mat& descriptors, const cv::Size& size = {640, 480}) {
  Features f;
  f.descriptors = descriptors;
  f.image_size = size;
  for (int i = 0; i < descriptors.rows; ++i) f.keypoints.emplace_back(float(i), float(2 * i), 5.0f);
  return f;
}

/// Random descriptors of small whole numbers: many equal distances.
cv::Mat randomDescriptors(int rows, int columns, int type, int values, std::uint64_t seed) {
  Random random(seed);
  cv::Mat d(rows, columns, type);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const std::uint32_t value = random.index(std::uint32_t(values));
      if (type == CV_8U) {
        d.at<std::uint8_t>(r, c) = std::uint8_t(value);
      } else {
        d.at<float>(r, c) = float(value);
      }
    }
  }
  return d;
}

/// As it is defined: whole Hamming distance, or the float sum of squares in the order of the columns.
float distance(const cv::Mat& a, int i, const cv::Mat& b, int j) {
  float sum = 0;
  for (int c = 0; c < a.cols; ++c) {
    if (a.type() == CV_8U) {
      for (int bits = a.at<std::uint8_t>(i, c) ^ b.at<std::uint8_t>(j, c); bits; bits &= bits - 1) ++sum;
    } else {
      const float difference = a.at<float>(i, c) - b.at<float>(j, c);
      sum += difference * difference;
    }
  }
  return a.type() == CV_8U ? sum : std::sqrt(sum);
}

/// What matchFeatures() promises, pair by pair.
Correspondences naiveMatches(const Features& left, const Features& right, bool mutual = false,
                             double radius = 0) {
  const int rows = left.descriptors.rows, columns = right.descriptors.rows;
  cv::Mat_<float> d(rows, columns);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) d(i, j) = distance(left.descriptors, i, right.descriptors, j);
  }
  Correspondences result;
  for (int i = 0; i < rows; ++i) {
    int best = -1;
    for (int j = 0; j < columns; ++j) {
      // Strictly: the lowest of equals; neither NaN nor infinity.
      if (d(i, j) < (best < 0 ? INFINITY : d(i, best))) best = j;
    }
    if (best < 0) continue;
    const cv::Point2d centre = right.keypoints[std::size_t(best)].pt;
    float second = INFINITY;
    for (int j = 0; j < columns; ++j) {
      const cv::Point2d offset = cv::Point2d(right.keypoints[std::size_t(j)].pt) - centre;
      if (j == best || offset.dot(offset) < radius * radius) continue;
      if (d(i, j) < second) second = d(i, j);
    }
    bool kept = true;
    for (int k = 0; mutual && k < rows; ++k) {
      kept = kept && !(d(k, best) < d(i, best) || (d(k, best) == d(i, best) && k < i));
    }
    if (!kept) continue;
    result.left_index.push_back(std::uint32_t(i));
    result.right_index.push_back(std::uint32_t(best));
    result.distance.push_back(d(i, best));
    result.second_distance.push_back(std::isinf(second) ? kNaN : second);
  }
  return result;
}

void expectSame(const Correspondences& m, const Correspondences& expected) {
  ASSERT_EQ(m.left_index, expected.left_index);
  ASSERT_EQ(m.right_index, expected.right_index);
  ASSERT_EQ(m.distance, expected.distance);
  ASSERT_EQ(m.second_distance.size(), expected.second_distance.size());
  for (std::size_t i = 0; i < m.second_distance.size(); ++i) {
    const float a = m.second_distance[i], b = expected.second_distance[i];
    ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << "row " << i << ": " << a << ", wanted " << b;
  }
}

/// Compares with the naive loop: plain, mutual and with a radius, at every level.
void expectNaive(const cv::Mat& left_descriptors, const cv::Mat& right_descriptors,
                 const std::vector<int>& thread_counts = {1}) {
  const Features left = features(left_descriptors), right = features(right_descriptors);
  const LevelGuard guard;
  for (const bool mutual : {false, true}) {
    for (const double radius : {0.0, 5.0}) {
      const Correspondences expected = naiveMatches(left, right, mutual, radius);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        SCOPED_TRACE(toString(level) + (mutual ? " mutual" : "") + (radius > 0 ? " radius" : ""));
        MatchOptions options;
        options.mutual = mutual;
        options.second_distance_radius = radius;
        for (const int threads : thread_counts) {
          SCOPED_TRACE(std::to_string(threads) + " threads");
          expectSame(matchFeatures(left, right, options, threads), expected);
          if (::testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

/// Unit-free values that are not whole, of both signs.
cv::Mat fractions(int rows, int columns, std::uint64_t seed) {
  Random random(seed);
  cv::Mat_<float> d(rows, columns);
  for (float& value : d) value = float(random.normal());
  return d;
}

/// SIFT-like: sparse, largest values cut off, length near 512.
cv::Mat siftLike(int rows, std::uint64_t seed) {
  Random random(seed);
  cv::Mat_<float> d(rows, 128);
  for (int r = 0; r < rows; ++r) {
    double squares = 0;
    for (int c = 0; c < 128; ++c) {
      const double value = std::exp(1.2 * random.normal());
      d(r, c) = float(value);
      squares += value * value;
    }
    for (int c = 0; c < 128; ++c)
      d(r, c) = float(std::min(std::floor(512 * d(r, c) / std::sqrt(squares)), 255.0));
  }
  return d;
}

/// Numbers from 0 to 255 in the columns [begin, end), whose squares add up to `squares` at most and to as
/// much as can be.
cv::Mat rowsOfLength(int rows, int squares, std::uint64_t seed, int begin = 0, int end = 128) {
  const int greedy = 20;  // the last ones take what is left
  Random random(seed);
  cv::Mat_<float> d(rows, 128, 0.0F);
  for (int r = 0; r < rows; ++r) {
    int rest = squares;
    for (int c = begin; c < end; ++c) {
      const int most = c < end - greedy ? int(random.index(std::uint32_t(12800 / (end - begin)))) : 255;
      const int value = std::min(most, int(std::sqrt(double(rest))));
      rest -= value * value;
      d(r, c) = float(value);
    }
    for (int c = end - 1; c > begin; --c) {
      std::swap(d(r, c), d(r, begin + int(random.index(std::uint32_t(c - begin) + 1))));
    }
  }
  return d;
}

TEST(Matcher, GivesPointsAndSizes) {
  const Features left = features(randomDescriptors(70, 4, CV_32F, 9, 1), {640, 480}),
                 right = features(randomDescriptors(90, 4, CV_32F, 9, 2), {320, 240});
  const Correspondences m = matchFeatures(left, right);
  ASSERT_EQ(m.size(), 70u);
  EXPECT_EQ(m.inconsistency(), "");
  EXPECT_EQ(m.left_size, cv::Size(640, 480));
  EXPECT_EQ(m.right_size, cv::Size(320, 240));
  for (std::size_t i = 0; i < 70; ++i) {
    EXPECT_EQ(m.left_index[i], i);
    EXPECT_EQ(m.left_x[i], float(i));
    EXPECT_EQ(m.left_y[i], float(2 * i));
    EXPECT_EQ(m.right_x[i], float(m.right_index[i]));
    EXPECT_EQ(m.right_y[i], float(2 * m.right_index[i]));
  }
  EXPECT_TRUE(m.left_frame.empty() && m.right_frame.empty());
}

TEST(Matcher, EqualsTheNaiveLoop) {
  for (const int columns : {1, 2, 3, 4, 5, 32, 61, 64, 124, 125, 128, 130, 512}) {
    SCOPED_TRACE(columns);
    for (const int values : {2, 3, 256}) {
      ASSERT_NO_FATAL_FAILURE(expectNaive(randomDescriptors(70, columns, CV_8U, values, 1),
                                          randomDescriptors(90, columns, CV_8U, values, 2)));
      ASSERT_NO_FATAL_FAILURE(expectNaive(randomDescriptors(70, columns, CV_32F, values, 3),
                                          randomDescriptors(90, columns, CV_32F, values, 4)));
    }
    ASSERT_NO_FATAL_FAILURE(expectNaive(fractions(70, columns, 5), fractions(90, columns, 6)));
    // Whole, but beyond what one or the other way takes.
    ASSERT_NO_FATAL_FAILURE(expectNaive(randomDescriptors(70, columns, CV_32F, 257, 3),
                                        randomDescriptors(90, columns, CV_32F, 300, 4)));
    ASSERT_NO_FATAL_FAILURE(expectNaive(1e5 * randomDescriptors(70, columns, CV_32F, 256, 3),
                                        -1e5 * randomDescriptors(90, columns, CV_32F, 256, 4)));
  }
  ASSERT_NO_FATAL_FAILURE(expectNaive(siftLike(700, 1), siftLike(500, 2)));
}

TEST(Matcher, EqualsTheNaiveLoopAtEverySize) {
  for (const int left : {1, 2, 3, 4, 7, 8, 9, 63, 64, 65, 130}) {
    for (const int right : {1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 32, 33, 100}) {
      SCOPED_TRACE(std::to_string(left) + " " + std::to_string(right));
      ASSERT_NO_FATAL_FAILURE(
          expectNaive(randomDescriptors(left, 9, CV_8U, 4, 1), randomDescriptors(right, 9, CV_8U, 4, 2)));
      ASSERT_NO_FATAL_FAILURE(
          expectNaive(randomDescriptors(left, 9, CV_32F, 4, 1), randomDescriptors(right, 9, CV_32F, 4, 2)));
      ASSERT_NO_FATAL_FAILURE(expectNaive(fractions(left, 9, 1), fractions(right, 9, 2)));
    }
  }
}

TEST(Matcher, EqualDescriptorsGoToTheLowestIndex) {
  for (const cv::Mat& some :
       {randomDescriptors(40, 32, CV_8U, 256, 1), randomDescriptors(40, 128, CV_32F, 256, 1),
        fractions(40, 64, 1), siftLike(40, 1)}) {
    cv::Mat twice;
    cv::vconcat(some, some, twice);
    ASSERT_NO_FATAL_FAILURE(expectNaive(some, twice));
    ASSERT_NO_FATAL_FAILURE(expectNaive(twice, some));
    const Correspondences m = matchFeatures(features(some), features(twice));
    for (std::size_t i = 0; i < m.size(); ++i) {
      EXPECT_EQ(m.right_index[i], i);
      EXPECT_EQ(m.distance[i], 0.0f);
      EXPECT_EQ(m.second_distance[i], 0.0f);
    }
    cv::Mat equal;
    cv::repeat(some.row(0), 83, 1, equal);
    ASSERT_NO_FATAL_FAILURE(expectNaive(equal, equal));
    MatchOptions mutual;
    mutual.mutual = true;
    const Correspondences one = matchFeatures(features(equal), features(equal), mutual);
    EXPECT_EQ(one.left_index, std::vector<std::uint32_t>{0});
    EXPECT_EQ(one.right_index, std::vector<std::uint32_t>{0});
  }
}

TEST(Matcher, TheLargestValuesDoNotOverflow) {
  for (const int columns : {128, 257, 258, 259, 600, 1100, 3000}) {
    const cv::Mat low = cv::Mat::zeros(20, columns, CV_32F), high(20, columns, CV_32F, cv::Scalar(255));
    cv::Mat mixed = randomDescriptors(20, columns, CV_32F, 2, 1) * 255;
    ASSERT_NO_FATAL_FAILURE(expectNaive(low, high));
    ASSERT_NO_FATAL_FAILURE(expectNaive(high, low));
    ASSERT_NO_FATAL_FAILURE(expectNaive(mixed, high));
    ASSERT_NO_FATAL_FAILURE(expectNaive(high, mixed));
    const cv::Mat none = cv::Mat::zeros(20, columns, CV_8U), all(20, columns, CV_8U, cv::Scalar(255));
    ASSERT_NO_FATAL_FAILURE(expectNaive(none, all));
  }
}

TEST(Matcher, LongRowsDoNotOverflow) {
  const int most = 8192;
  for (const int columns : {most - 1, most, most + 1, 3 * most}) {
    SCOPED_TRACE(columns);
    const int largest = int(std::sqrt(double(1 << 24) / columns));
    const cv::Mat low = cv::Mat::zeros(9, columns, CV_32F), high(9, columns, CV_32F, cv::Scalar(largest));
    const cv::Mat mixed = randomDescriptors(20, columns, CV_32F, largest + 1, 1);
    ASSERT_NO_FATAL_FAILURE(expectNaive(low, high));
    ASSERT_NO_FATAL_FAILURE(expectNaive(high, low));
    ASSERT_NO_FATAL_FAILURE(expectNaive(mixed, high));
    ASSERT_NO_FATAL_FAILURE(expectNaive(high, mixed));
    ASSERT_NO_FATAL_FAILURE(expectNaive(mixed, randomDescriptors(20, columns, CV_32F, largest + 1, 2)));
  }
}

TEST(Matcher, EqualsTheNaiveLoopAroundTheLongestProjections) {
  const double units = std::sqrt(4.0 * 0x7fff / 128);
  const int longest = int(std::pow(Projection::kMaxStep * units, 2));
  for (const int squares : {1000, 262144, longest, longest + 1, 2 * longest}) {
    SCOPED_TRACE(squares);
    const cv::Mat trains = rowsOfLength(150, squares, 1);
    EXPECT_NEAR(trains.row(0).dot(trains.row(0)), squares, 1);
    // Random queries, trains, queries near trains, and the origin.
    cv::Mat queries = rowsOfLength(40, squares, 2), twice;
    cv::vconcat(queries, trains.rowRange(10, 50), queries);
    cv::Mat near = queries.rowRange(40, 80) + randomDescriptors(40, 128, CV_32F, 3, 5) - 1;
    cv::vconcat(queries, cv::min(cv::max(near, 0), 255), queries);
    queries.row(70).setTo(0);
    cv::vconcat(trains, trains.rowRange(20, 35), twice);
    ASSERT_NO_FATAL_FAILURE(expectNaive(queries, twice, {1, 2}));
  }
}

/// Rows of 128 numbers from 0 to 255, of which some have near neighbours, as those of real features.
cv::Mat nearRows(int rows, std::uint64_t seed) {
  const cv::Mat centres = randomDescriptors(40, 128, CV_32F, 100, 1);
  Random random(seed);
  cv::Mat result(rows, 128, CV_32F);
  for (int row = 0; row < rows; ++row) {
    const int centre = int(random.index(40));
    const std::uint32_t noise = 1 + random.index(50);
    for (int c = 0; c < 128; ++c) {
      result.at<float>(row, c) = centres.at<float>(centre, c) + float(random.index(noise));
    }
  }
  return result;
}

TEST(Matcher, TheTestOfRatiosDropsWhatFailsItAtEveryLevel) {
  const LevelGuard guard;
  std::size_t passed = 0, failed = 0;
  for (const int rows : {1, 2, 16, 17, 33, 300}) {
    const cv::Mat queries = nearRows(70, 2), trains = nearRows(rows, 3);
    cv::Mat fractions_of_queries = queries / 3, fractions_of_trains = trains / 3;
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      for (const double ratio : {0.3, 0.8, 0.99}) {
        SCOPED_TRACE(toString(level) + " " + std::to_string(rows) + " " + std::to_string(ratio));
        for (const bool whole : {true, false}) {
          const cv::Mat& a = whole ? queries : fractions_of_queries;
          const cv::Mat& b = whole ? trains : fractions_of_trains;
          Neighbours expected = findNeighbours(a, b);
          for (std::size_t i = 0; i < expected.train.size(); ++i) {
            const bool fails = expected.distance[i] >= ratio * expected.second_distance[i];
            if (fails) expected.train[i] = Neighbours::kNone;
            fails ? ++failed : ++passed;
          }
          NeighbourSearch search;
          search.ratio = ratio;
          const Neighbours found = findNeighbours(a, b, search);
          ASSERT_EQ(found.train, expected.train);
          for (std::size_t i = 0; i < found.train.size(); ++i) {
            if (found.train[i] == Neighbours::kNone) continue;
            ASSERT_EQ(found.distance[i], expected.distance[i]);
          }
        }
      }
    }
  }
  EXPECT_GT(passed, 1000U);
  EXPECT_GT(failed, 1000U);
}

TEST(Matcher, BytesAsNumbersAreComparedAsTheSameFloats) {
  const LevelGuard guard;
  NeighbourSearch search;
  search.bytes = NeighbourSearch::Bytes::kNumbers;
  search.nearest_query = true;
  // With 300 columns, sums may exceed what is exact in float.
  for (const int columns : {1, 31, 128, 300}) {
    const cv::Mat queries = randomDescriptors(40, columns, CV_8U, 256, 1);
    const cv::Mat trains = randomDescriptors(50, columns, CV_8U, 256, 2);
    cv::Mat float_queries, float_trains;
    queries.convertTo(float_queries, CV_32F);
    trains.convertTo(float_trains, CV_32F);
    for (const KernelLevel level : supportedKernelLevels()) {
      SCOPED_TRACE(toString(level) + " " + std::to_string(columns));
      setKernelLevel(level);
      const Neighbours found = findNeighbours(queries, trains, search);
      const Neighbours expected = findNeighbours(float_queries, float_trains, search);
      ASSERT_EQ(found.train, expected.train);
      ASSERT_EQ(found.query, expected.query);
      ASSERT_EQ(found.distance, expected.distance);
      ASSERT_EQ(found.second_distance, expected.second_distance);
    }
  }
}

TEST(Matcher, QueriesFarFromAllTrainsHaveNeighbours) {
  // Their coarse numbers do not fit, as the means are those of the trains, of which few are near the queries.
  for (const int squares : {262144, 600000}) {
    SCOPED_TRACE(squares);
    cv::Mat trains = rowsOfLength(200, squares, 3, 0, 64), queries = rowsOfLength(60, squares, 4, 64, 128),
            alike;
    ASSERT_NO_FATAL_FAILURE(expectNaive(queries, trains));
    cv::repeat(trains.row(0), 200, 1, alike);
    alike = cv::min(alike + randomDescriptors(200, 128, CV_32F, 3, 5), 255);
    cv::vconcat(alike, queries.rowRange(0, 10), trains);
    cv::vconcat(trains, queries.rowRange(0, 10), trains);
    cv::vconcat(queries, trains.rowRange(0, 30), queries);
    ASSERT_NO_FATAL_FAILURE(expectNaive(queries, trains, {1, 2}));
  }
}

TEST(Matcher, EqualsTheNaiveLoopForShortRows) {
  // Of fewer columns than the smallest projection has, and around powers of two.
  for (const int columns : {1, 7, 8, 9, 31, 32, 33, 63, 65, 127}) {
    SCOPED_TRACE(columns);
    const cv::Mat trains = siftLike(300, 1).colRange(0, columns),
                  queries = siftLike(90, 2).colRange(0, columns);
    ASSERT_NO_FATAL_FAILURE(expectNaive(queries, trains));
  }
}

TEST(Matcher, NoSecondWithinTheRadius) {
  // Six right features in two places, 10 px apart; the nearest three are in one of them.
  Features left = features((cv::Mat_<float>(1, 1) << 0)),
           right = features((cv::Mat_<float>(6, 1) << 3, 2, 1, 4, 6, 5));
  for (std::size_t i = 0; i < 6; ++i)
    right.keypoints[i].pt = {i < 3 ? 100.0f : 110.0f, 50.0f + 0.1f * float(i % 3)};
  MatchOptions options;
  const auto second = [&](double radius) {
    options.second_distance_radius = radius;
    const Correspondences m = matchFeatures(left, right, options);
    EXPECT_EQ(m.right_index, std::vector<std::uint32_t>{2});
    return m.second_distance[0];
  };
  EXPECT_EQ(second(0), 2.0f);
  EXPECT_EQ(second(0.05), 2.0f);
  EXPECT_EQ(second(2), 4.0f);
  EXPECT_TRUE(std::isnan(second(30)));
  // Exactly so far away is far enough.
  right.keypoints[3].pt = {103, 54.2f};
  right.keypoints[2].pt = {100, 50.2f};
  EXPECT_EQ(second(5), 4.0f);
}

TEST(Matcher, AnyNumberOfThreadsGivesTheSame) {
  Features many[2][2] = {
      {features(siftLike(1000, 3)), features(siftLike(900, 4))},
      {features(randomDescriptors(1000, 2, CV_8U, 4, 3)), features(randomDescriptors(900, 2, CV_8U, 4, 4))}};
  for (auto& [left, right] : many) {
    MatchOptions options;
    options.mutual = true;
    options.second_distance_radius = 4;
    const Correspondences one = matchFeatures(left, right, options);
    EXPECT_GT(one.size(), 4u);
    for (const int threads : {0, 2, 3, 7, 1024}) {
      expectSame(matchFeatures(left, right, options, threads), one);
    }
  }
}

TEST(Matcher, MoreFeaturesThan16BitsCount) {
  const int n = 70000;
  cv::Mat_<float> left(3, 2), right(n, 2);
  for (int i = 0; i < n; ++i) {
    right(i, 0) = float(i % 256);
    right(i, 1) = float(i / 256 % 200);
  }
  right(69990, 0) = right(69991, 0) = right(69990, 1) = right(69991, 1) = 255;
  left << 255, 255, 254, 255, 0, 0;
  for (const bool swapped : {false, true}) {
    const Features a = features(left), b = features(right);
    MatchOptions options;
    options.mutual = true;
    const Correspondences m = swapped ? matchFeatures(b, a, options) : matchFeatures(a, b, options);
    ASSERT_EQ(m.size(), 2u);
    EXPECT_EQ((swapped ? m.left_index[1] : m.right_index[0]), 69990u);
  }
}

TEST(Matcher, MemoryDoesNotGrowWithTheSquare) {
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024;
  };
  const int n = 20000;
  const Features left = features(randomDescriptors(n, 4, CV_8U, 256, 1)),
                 right = features(randomDescriptors(n, 4, CV_8U, 256, 2));
  MatchOptions options;
  options.mutual = true;
  const double before = peak();
  EXPECT_GT(matchFeatures(left, right, options, 2).size(), 1000u);
  // A byte per pair were 400 MB.
  EXPECT_LT(peak() - before, 100e6);
}

TEST(Matcher, RefusesBadOptions) {
  const Features some = features(randomDescriptors(3, 8, CV_32F, 9, 1));
  MatchOptions options;
  options.second_distance_radius = kNaN;
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { matchFeatures(some, some, options); }),
                       "second_distance_radius"));
  Features lacking = some;
  lacking.keypoints.pop_back();
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { matchFeatures(some, lacking); }),
                       {"right features", "2 keypoints", "3 descriptors"}));
}

TEST(Matcher, OneRightFeatureHasNoSecond) {
  for (const int type : {CV_32F, CV_8U}) {
    const Correspondences m = matchFeatures(features(randomDescriptors(3, 8, type, 9, 1)),
                                            features(randomDescriptors(1, 8, type, 9, 2)));
    ASSERT_EQ(m.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(m.right_index[i], 0u);
      EXPECT_TRUE(std::isnan(m.second_distance[i]));
    }
  }
}

TEST(Matcher, EmptySidesGiveNoMatches) {
  const Features some = features(randomDescriptors(3, 8, CV_32F, 9, 1)), none = features({}, {20, 10});
  for (const auto& [left, right] : {std::pair(some, none), std::pair(none, some), std::pair(none, none)}) {
    const Correspondences m = matchFeatures(left, right);
    EXPECT_TRUE(m.empty());
    EXPECT_EQ(m.left_size, left.image_size);
    EXPECT_EQ(m.right_size, right.image_size);
  }
}

TEST(Matcher, RefusesDescriptorsThatDiffer) {
  const auto refusal = [](const cv::Mat& left, const cv::Mat& right) {
    return errorOf<std::invalid_argument>([&] { matchFeatures(features(left), features(right)); });
  };
  const cv::Mat floats = cv::Mat::zeros(2, 8, CV_32F), bytes = cv::Mat::zeros(2, 8, CV_8U);
  EXPECT_TRUE(mentions(refusal(floats, bytes), {"left 8 x CV_32FC1", "right 8 x CV_8UC1"}));
  EXPECT_TRUE(
      mentions(refusal(bytes, cv::Mat::zeros(2, 9, CV_8U)), {"left 8 x CV_8UC1", "right 9 x CV_8UC1"}));
  EXPECT_TRUE(mentions(refusal(cv::Mat::zeros(2, 8, CV_64F), cv::Mat::zeros(2, 8, CV_64F)),
                       {"CV_64FC1", "CV_8U or CV_32F"}));
}

TEST(Matcher, DescriptorsWithNaNHaveNoNeighbour) {
  cv::Mat left = (cv::Mat_<float>(3, 2) << 0, 0, kNaN, 0, 5, 5);
  cv::Mat right = (cv::Mat_<float>(4, 2) << kNaN, kNaN, 0, 3, 5, kNaN, 5, 1);
  const Correspondences m = matchFeatures(features(left), features(right));
  EXPECT_EQ(m.inconsistency(), "");
  EXPECT_EQ(m.left_index, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(m.right_index, (std::vector<std::uint32_t>{1, 3}));
  EXPECT_EQ(m.distance, (std::vector<float>{3, 4}));
  EXPECT_FLOAT_EQ(m.second_distance[0], std::sqrt(26.0f));
  EXPECT_FLOAT_EQ(m.second_distance[1], std::sqrt(29.0f));
  // Only one right descriptor is left, or none.
  right.at<float>(1, 0) = kNaN;
  EXPECT_TRUE(std::isnan(matchFeatures(features(left), features(right)).second_distance[0]));
  right.setTo(kNaN);
  EXPECT_TRUE(matchFeatures(features(left), features(right)).empty());
}

TEST(Matcher, NaNAndInfinityMatchTheNaiveLoop) {
  for (const bool whole : {false, true}) {
    cv::Mat left = whole ? randomDescriptors(70, 5, CV_32F, 9, 1) : fractions(70, 5, 1);
    cv::Mat right = whole ? randomDescriptors(80, 5, CV_32F, 9, 2) : fractions(80, 5, 2);
    Random random(3);
    for (const float value : {kNaN, INFINITY, -INFINITY, 1e30f}) {
      for (int k = 0; k < 10; ++k) {
        const int left_column = int(random.index(5)), left_row = int(random.index(70));
        left.at<float>(left_row, left_column) = value;
        const int right_column = int(random.index(5)), right_row = int(random.index(80));
        right.at<float>(right_row, right_column) = value;
      }
      ASSERT_NO_FATAL_FAILURE(expectNaive(left, right));
    }
  }
}

TEST(Matcher, TakesFramesWhereBothSidesHaveThem) {
  Features left = features((cv::Mat_<float>(2, 1) << 10, 20)),
           right = features((cv::Mat_<float>(2, 1) << 21, 11));
  left.frames = {AffineFrame{1}, AffineFrame{2}};
  EXPECT_TRUE(matchFeatures(left, right).left_frame.empty());
  right.frames = {AffineFrame{3}, AffineFrame{4}};
  const Correspondences m = matchFeatures(left, right);
  EXPECT_EQ(m.left_frame, (std::vector<AffineFrame>{{1}, {2}}));
  EXPECT_EQ(m.right_frame, (std::vector<AffineFrame>{{4}, {3}}));
}

}  // namespace
}  // namespace corrsel::core
