#include "corrsel/database/colmap_store.h"
#include "test_support.h"

using namespace corrsel::core;

namespace {

/// A folder that is removed at the end.
class ColmapStoreTest : public ::testing::Test {
 protected:
  ColmapStoreTest() {
    std::string name = (std::filesystem::temp_directory_path() / "corrsel_store_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  ~ColmapStoreTest() override { std::filesystem::remove_all(folder); }

  std::filesystem::path folder;
};

StoredImage imageOf(const std::string& name) {
  StoredImage image;
  image.name = name;
  image.size = {640, 480};
  return image;
}

StoredKeypoints somePoints() { return {{{0, 0}, {10.5F, 20.25F}, {639, 479}}, {}}; }

TEST_F(ColmapStoreTest, ReadsBackWhatItWrote) {
  const auto path = folder / "house.db";
  ColmapStore::create(path);
  ColmapStore store(path, ColmapStore::Access::kWrite);
  const std::uint32_t a = store.addImage(imageOf("a.jpg"), somePoints(), cv::Mat());
  const std::uint32_t b = store.addImage(imageOf("b.jpg"), somePoints(), cv::Mat());
  StoredMatches matches;
  matches.rows = {{0, 1}, {1, 2}};
  store.writeMatches({{{a, b}, matches}});
  const ColmapStore reader(path);
  ASSERT_EQ(reader.images().size(), 2U);
  EXPECT_EQ(reader.images()[1].name, "b.jpg");
  ASSERT_EQ(reader.pairs().size(), 1U);
  EXPECT_EQ(reader.matches(reader.pairs()[0]).rows, matches.rows);
  EXPECT_EQ(reader.keypoints(a).positions, somePoints().positions);

  VerifiedPair pair;
  pair.pair = {a, b};
  pair.putative = 2;
  pair.geometry.config = TwoViewConfig::kUncalibrated;
  pair.geometry.inliers = {{1, 2}};
  pair.geometry.fundamental = cv::Matx33d(1, 2, 3, 4, 5, 6, 7, 8, 9);
  pair.geometry.pose = Pose{cv::Matx33d::eye(), {0, 0, 1}};
  pair.confidence = 12.5;
  store.write({pair}, "auto");
  ASSERT_EQ(store.verifiedPairs("auto").size(), 1U);
  EXPECT_TRUE(store.verifiedPairs("other").empty());
  const VerifiedPair back = store.verified({a, b});
  EXPECT_EQ(back.geometry.inliers, pair.geometry.inliers);
  EXPECT_LE(cv::norm(*back.geometry.fundamental - *pair.geometry.fundamental), 1e-12);
  EXPECT_EQ(back.confidence, 12.5);
  EXPECT_EQ(back.putative, 2U);
}

}  // namespace
