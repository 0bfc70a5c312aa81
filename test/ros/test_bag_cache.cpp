#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>

#include "ros/bags/bag_cache.h"
#include "ros/bags/open_bag.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

/// Two tiny pairs that depend on one file; the second is broken on demand.
class TinyReader : public core::DatasetReader {
 public:
  explicit TinyReader(const std::string& file) : file_(file) {}
  std::size_t size() const override { return 2; }
  core::PairId id(std::size_t index) const override { return {"tiny", "s", std::to_string(index)}; }
  core::ImagePair read(std::size_t index) const override {
    if (broken && index == 1) throw core::DatasetError("picture b is broken");
    core::ImagePair pair;
    pair.id = id(index);
    pair.left = pair.right = cv::Mat(8, 8, CV_8U, cv::Scalar(7));
    if (stretched) pair.stretched = core::StretchedBits{12, 4000, "a.png"};
    return pair;
  }
  std::vector<std::string> files() const override { return {file_}; }
  bool broken = false, stretched = false;

 private:
  std::string file_;
};

class BagCache : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_bag_cache_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "source") << "one";
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t bags() const {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "bags"))
      count += entry.path().extension() == ".bag";
    return count;
  }
  fs::path folder_;
};

TEST_F(BagCache, ReusesUntilFilesOrSeedChange) {
  const std::string bags_folder = (folder_ / "bags").string();
  const TinyReader reader((folder_ / "source").string());
  const CachedBag first = cachedDatasetBag(bags_folder, "tiny", reader, 0);
  EXPECT_FALSE(first.reused);
  EXPECT_TRUE(fs::exists(first.path));
  EXPECT_EQ(openBag(first.path)->size(), 2U);
  EXPECT_TRUE(hasCachedBag(bags_folder, "tiny", reader, 0));
  EXPECT_FALSE(hasCachedBag(bags_folder, "tiny", reader, 1));
  EXPECT_TRUE(cachedDatasetBag(bags_folder, "tiny", reader, 0).reused);
  const CachedBag seeded = cachedDatasetBag(bags_folder, "tiny", reader, 1);
  EXPECT_FALSE(seeded.reused);
  EXPECT_NE(seeded.path, first.path);
  std::ofstream(folder_ / "source") << "another length";
  EXPECT_FALSE(cachedDatasetBag(bags_folder, "tiny", reader, 1).reused);
}

TEST_F(BagCache, BagsOfOtherSeedsAreKeptWhileTheyAreUsed) {
  const std::string bags_folder = (folder_ / "bags").string();
  const TinyReader reader((folder_ / "source").string());
  const fs::path old = cachedDatasetBag(bags_folder, "tiny", reader, 0).path;
  const fs::path used = cachedDatasetBag(bags_folder, "tiny", reader, 1).path;
  const auto three_days_ago = fs::file_time_type::clock::now() - std::chrono::hours(72);
  fs::last_write_time(old, three_days_ago);
  fs::last_write_time(used, three_days_ago);
  const fs::path killed = used.string() + "-host-1.part";
  std::ofstream(killed) << "x";
  fs::last_write_time(killed, three_days_ago);
  EXPECT_TRUE(cachedDatasetBag(bags_folder, "tiny", reader, 1).reused);
  EXPECT_FALSE(fs::exists(old) || fs::exists(killed));
  cachedDatasetBag(bags_folder, "tiny", reader, 2);
  EXPECT_TRUE(fs::exists(used)) << "its use was not noted";
  EXPECT_EQ(bags(), 2U);
}

TEST_F(BagCache, AnotherDatasetIsLeftAlone) {
  const std::string bags_folder = (folder_ / "bags").string();
  const TinyReader reader((folder_ / "source").string());
  cachedDatasetBag(bags_folder, "tiny", reader, 0);
  cachedDatasetBag(bags_folder, "other", reader, 0);
  EXPECT_TRUE(cachedDatasetBag(bags_folder, "tiny", reader, 0).reused);
}

TEST_F(BagCache, NamesThatLookAlikeAreDifferentDatasets) {
  const std::string bags_folder = (folder_ / "bags").string();
  const TinyReader reader((folder_ / "source").string());
  const std::string longer = cachedDatasetBag(bags_folder, "tiny-2", reader, 0).path;
  const std::string blank = cachedDatasetBag(bags_folder, "a b", reader, 0).path;
  const std::string comma = cachedDatasetBag(bags_folder, "a,b", reader, 0).path;
  cachedDatasetBag(bags_folder, "tiny", reader, 0);
  EXPECT_TRUE(fs::exists(longer));
  EXPECT_NE(blank, comma);
}

TEST_F(BagCache, ProcessesSideBySideDoNotDisturbEachOther) {
  const std::string bags_folder = (folder_ / "bags").string();
  const TinyReader reader((folder_ / "source").string());
  std::vector<pid_t> children;
  for (int k = 0; k < 4; ++k) {
    children.push_back(fork());
    if (children.back() != 0) continue;
    int code = 1;
    try {
      code = openBag(cachedDatasetBag(bags_folder, "tiny", reader, 0).path)->size() == 2 ? 0 : 2;
    } catch (const std::exception&) {
    }
    _exit(code);
  }
  for (const pid_t child : children) {
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(bags(), 1U);
}

TEST_F(BagCache, ProblemsAreReportedEveryTime) {
  const std::string bags_folder = (folder_ / "bags").string();
  TinyReader reader((folder_ / "source").string());
  reader.broken = true;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const CachedBag bag = cachedDatasetBag(bags_folder, "tiny", reader, 0);
    EXPECT_FALSE(bag.reused);
    ASSERT_EQ(bag.problems.size(), 1U);
    EXPECT_NE(bag.problems[0].error.find("picture b is broken"), std::string::npos);
    EXPECT_EQ(openBag(bag.path)->size(), 1U);
  }
  reader.broken = false;
  EXPECT_TRUE(cachedDatasetBag(bags_folder, "tiny", reader, 0).problems.empty());
  EXPECT_TRUE(cachedDatasetBag(bags_folder, "tiny", reader, 0).reused);
}

TEST_F(BagCache, RemarksOnImagesAreMadeEveryTime) {
  TinyReader reader((folder_ / "source").string());
  reader.stretched = true;
  for (const bool reused : {false, true}) {
    const CachedBag bag = cachedDatasetBag((folder_ / "bags").string(), "tiny", reader, 0);
    EXPECT_EQ(bag.reused, reused);
    ASSERT_EQ(bag.remarks.size(), 1U);
    EXPECT_NE(bag.remarks[0].find("values up to 4000 in a.png"), std::string::npos) << bag.remarks[0];
  }
}

TEST_F(BagCache, FolderFromTheEnvironment) {
  setenv("XDG_CACHE_HOME", "/some/cache", 1);
  EXPECT_EQ(cacheFolder(), "/some/cache/corrsel");
  unsetenv("XDG_CACHE_HOME");
  setenv("HOME", "/some/home", 1);
  EXPECT_EQ(cacheFolder(), "/some/home/.cache/corrsel");
}

}  // namespace
}  // namespace corrsel
