#include <atomic>
#include <fstream>

#include "base/temporary_folder.h"
#include "corrsel/database/pair_matching.h"
#include "database/sqlite.h"
#include "test_support.h"

using namespace corrsel::core;
using namespace corrsel::core::testing;

namespace {

using Access = ColmapStore::Access;
namespace fs = std::filesystem;

/// Descriptors of which some are near to each other: variants of a few centres, as those of real features.
cv::Mat clusteredDescriptors(int rows, int centres, std::uint64_t seed) {
  Random centre_random(1), random(seed);
  cv::Mat centre(centres, 128, CV_8U), result(rows, 128, CV_8U);
  for (int i = 0; i < centres * 128; ++i) {
    const std::uint32_t value = centre_random.index(100);
    centre.data[i] = std::uint8_t(value * value / 100);
  }
  for (int row = 0; row < rows; ++row) {
    const int own = int(random.index(std::uint32_t(centres)));
    const std::uint32_t noise = 1 + random.index(40);
    for (int c = 0; c < 128; ++c) {
      const int value = centre.at<std::uint8_t>(own, c) + int(random.index(noise)) - int(noise / 2);
      result.at<std::uint8_t>(row, c) = cv::saturate_cast<std::uint8_t>(value);
    }
  }
  return result;
}

/// The two nearest rows of `others`: the number of the first one, and both distances.
struct Two {
  std::uint32_t row = 0;
  float first = INFINITY, second = INFINITY;
};

Two nearestOf(const cv::Mat& descriptor, const cv::Mat& others) {
  Two two;
  for (int i = 0; i < others.rows; ++i) {
    const auto distance = float(cv::norm(descriptor, others.row(i), cv::NORM_L2));
    if (distance < two.first) {
      two = {std::uint32_t(i), distance, two.first};
    } else if (distance < two.second) {
      two.second = distance;
    }
  }
  return two;
}

std::vector<KeypointPair> naiveMatches(const cv::Mat& first, const cv::Mat& second, double ratio) {
  std::vector<KeypointPair> matches;
  const auto passes = [&](const Two& two) { return ratio == 1 || two.first < ratio * two.second; };
  for (int i = 0; i < first.rows; ++i) {
    const Two forth = nearestOf(first.row(i), second);
    const Two back = nearestOf(second.row(int(forth.row)), first);
    if (back.row == std::uint32_t(i) && passes(forth) && passes(back)) {
      matches.push_back({std::uint32_t(i), forth.row});
    }
  }
  return matches;
}

TEST(PairMatching, EqualsTheNaiveLoopAtEveryLevel) {
  const LevelGuard guard;
  std::size_t total = 0;
  for (const int rows : {1, 2, 15, 33, 64, 250}) {
    const cv::Mat first = clusteredDescriptors(rows, 60, 2), second = clusteredDescriptors(rows + 20, 60, 3);
    for (const double ratio : {0.5, 0.8, 0.95, 1.0}) {
      const std::vector<KeypointPair> expected = naiveMatches(first, second, ratio);
      total += expected.size();
      for (const KernelLevel level : supportedKernelLevels()) {
        SCOPED_TRACE(toString(level) + " " + std::to_string(rows) + " " + std::to_string(ratio));
        setKernelLevel(level);
        EXPECT_EQ(matchDescriptors(first, second, ratio), expected);
      }
    }
  }
  EXPECT_GT(total, 100U);
}

TEST(PairMatching, ImagesWithoutDescriptorsHaveNoMatches) {
  const cv::Mat none(0, 128, CV_8U), some = clusteredDescriptors(5, 5, 1);
  EXPECT_TRUE(matchDescriptors(none, some).empty());
  EXPECT_TRUE(matchDescriptors(some, none).empty());
}

std::vector<StoredImage> imagesOf(const std::vector<std::string>& names) {
  std::vector<StoredImage> images;
  for (const std::string& name : names) {
    StoredImage image;
    image.id = std::uint32_t(images.size() + 1);
    image.name = name;
    image.size = {640, 480};
    images.push_back(image);
  }
  return images;
}

TEST(PairMatching, ExhaustivePairsAreAllPairs) {
  const std::vector<ImagePairKey> expected = {{1, 2}, {1, 3}, {2, 3}};
  EXPECT_EQ(exhaustivePairs(imagesOf({"b", "c", "a"})), expected);
  EXPECT_TRUE(exhaustivePairs(imagesOf({"a"})).empty());
}

TEST(PairMatching, SequentialPairsFollowTheNames) {
  // In the order of names: 3, 1, 4, 2.
  const std::vector<StoredImage> images = imagesOf({"b", "d", "a", "c"});
  EXPECT_EQ(sequentialPairs(images, 1), (std::vector<ImagePairKey>{{1, 3}, {1, 4}, {2, 4}}));
  EXPECT_EQ(sequentialPairs(images, 2), (std::vector<ImagePairKey>{{1, 2}, {1, 3}, {1, 4}, {2, 4}, {3, 4}}));
}

/// A folder that is removed at the end, with a database of four images whose descriptors match.
class PairMatchingTest : public ::testing::Test {
 protected:
  PairMatchingTest() {
    path = folder / "house.db";
    fill(path);
  }

  void fill(const fs::path& database) {
    ColmapStore::create(database);
    ColmapStore store(database, Access::kWrite);
    for (const StoredImage& image : imagesOf({"a.jpg", "b.jpg", "c.jpg", "d.jpg"})) {
      descriptors.push_back(clusteredDescriptors(50, 60, descriptors.size()));
      store.addImage(image, {std::vector<cv::Point2f>(50, {5, 5}), {}}, descriptors.back());
    }
  }

  std::string listError(const std::string& text) const {
    std::ofstream(folder / "pairs.txt") << text;
    return errorOf<StoreError>([&] { listedPairs(folder / "pairs.txt", ColmapStore(path).images()); });
  }

  const TemporaryFolder temporary{"corrsel_matching"};
  const fs::path folder = temporary.path();
  fs::path path;
  std::vector<cv::Mat> descriptors;
};

TEST_F(PairMatchingTest, StoresTheMatchesOfAllPairs) {
  ColmapStore store(path, Access::kWrite);
  const std::vector<ImagePairKey> pairs = exhaustivePairs(store.images());
  const PairMatchingSummary summary = matchPairs(store, pairs, {}, 1);
  EXPECT_EQ(summary.pairs, 6U);
  EXPECT_EQ(summary.matched, 6U);
  EXPECT_TRUE(store.warnings().empty());
  EXPECT_EQ(ColmapStore(path).pairs(), pairs);
  std::size_t total = 0;
  for (const ImagePairKey& pair : pairs) {
    const std::vector<KeypointPair> rows = ColmapStore(path).matches(pair).rows;
    EXPECT_EQ(rows, naiveMatches(descriptors[pair.first - 1], descriptors[pair.second - 1], 0.8));
    total += rows.size();
  }
  EXPECT_GT(total, 20U);
  EXPECT_EQ(summary.matches, total);
}

TEST_F(PairMatchingTest, ThreadsAndMemoryDoNotChangeWhatIsStored) {
  const fs::path other = folder / "other.db";
  descriptors.clear();
  fill(other);
  ColmapStore store(path, Access::kWrite), other_store(other, Access::kWrite);
  const std::vector<ImagePairKey> pairs = exhaustivePairs(store.images());
  PairMatchingOptions options;
  matchPairs(store, pairs, options, 1);
  options.memory_gib = 0.01;
  std::size_t last = 0;
  matchPairs(other_store, pairs, options, 3, [&](std::size_t done, std::size_t total) {
    last = done;
    EXPECT_EQ(total, 6U);
  });
  EXPECT_EQ(last, 6U);
  for (const ImagePairKey& pair : pairs) EXPECT_EQ(store.matches(pair).rows, other_store.matches(pair).rows);
}

TEST_F(PairMatchingTest, PairsWithMatchesAreSkippedUnlessAskedFor) {
  ColmapStore store(path, Access::kWrite);
  const std::vector<ImagePairKey> pairs = exhaustivePairs(store.images());
  store.writeMatches({{{1, 2}, {{{7, 8}}, {}}}, {{2, 3}, {}}});
  PairMatchingOptions options;
  PairMatchingSummary summary = matchPairs(store, pairs, options, 2);
  EXPECT_EQ(summary.skipped, 2U);
  EXPECT_EQ(summary.matched, 4U);
  EXPECT_EQ(store.matches({1, 2}).rows, (std::vector<KeypointPair>{{7, 8}}));
  EXPECT_TRUE(store.matches({2, 3}).rows.empty());
  options.again = true;
  summary = matchPairs(store, pairs, options, 2);
  EXPECT_EQ(summary.matched, 6U);
  EXPECT_EQ(store.matches({1, 2}).rows, naiveMatches(descriptors[0], descriptors[1], 0.8));
}

TEST_F(PairMatchingTest, WithoutTheTestMutualMatchesAreStored) {
  ColmapStore store(path, Access::kWrite);
  PairMatchingOptions options;
  options.ratio = 1;
  matchPairs(store, {{1, 2}}, options, 1);
  EXPECT_EQ(store.matches({1, 2}).rows, naiveMatches(descriptors[0], descriptors[1], 1));
}

TEST_F(PairMatchingTest, AnImageWithDamagedDescriptorsIsNamedAndItsPairsAreLeft) {
  SqliteDatabase(path, SqliteDatabase::Mode::kWrite, 1)
      .execute("UPDATE descriptors SET data = x'00' WHERE image_id = 2");
  ColmapStore store(path, Access::kWrite);
  const PairMatchingSummary summary = matchPairs(store, exhaustivePairs(store.images()), {}, 2);
  ASSERT_EQ(summary.faulty.size(), 1U);
  EXPECT_TRUE(mentions(summary.faulty[0], {path.string(), "descriptors", "b.jpg", "50 x 128"}));
  EXPECT_EQ(summary.matched, 3U);
  EXPECT_EQ(store.pairs(), (std::vector<ImagePairKey>{{1, 3}, {1, 4}, {3, 4}}));
}

TEST_F(PairMatchingTest, AnInterruptedCallStoresWhatIsComplete) {
  ColmapStore store(path, Access::kWrite);
  const std::atomic<bool> interrupt{true};
  const PairMatchingSummary summary =
      matchPairs(store, exhaustivePairs(store.images()), {}, 1, {}, &interrupt);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(summary.matched, store.pairs().size());
  EXPECT_LT(summary.matched, 6U);
}

TEST_F(PairMatchingTest, OptionsOutOfRangeAreRefused) {
  ColmapStore store(path, Access::kWrite);
  PairMatchingOptions options;
  options.ratio = 1.5;
  EXPECT_TRUE(mentions(errorOf([&] { matchPairs(store, {}, options, 1); }), {"ratio", "1.5", "[0, 1]"}));
}

TEST_F(PairMatchingTest, ListsOfPairs) {
  EXPECT_EQ(listError("b.jpg a.jpg\n# d.jpg\n\nc.jpg c.jpg\na.jpg b.jpg\na.jpg d.jpg\n"), "");
  EXPECT_EQ(listedPairs(folder / "pairs.txt", ColmapStore(path).images()),
            (std::vector<ImagePairKey>{{1, 2}, {1, 4}}));
  EXPECT_TRUE(mentions(listError("a.jpg b.jpg\na.jpg z.jpg\n"), {"pairs.txt", "line 2", "z.jpg"}));
  EXPECT_TRUE(mentions(listError("a.jpg\n"), {"pairs.txt", "line 1", "'a.jpg'", "two names"}));
  EXPECT_TRUE(mentions(listError("a.jpg b.jpg 7\n"), {"line 1", "two names"}));
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] { listedPairs(folder / "no.txt", {}); }), {"no.txt"}));
}

}  // namespace
