#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dataset_folder.h"
#include "datasets/dataset_report.h"
#include "datasets/unrelated.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// A dataset in memory: every sequence has as many pairs as stated. The value of an image's pixels is the
/// number of its pair, plus 100 in a right image.
class FakeReader : public DatasetReader {
 public:
  explicit FakeReader(const std::vector<std::pair<std::string, int>>& sequences) {
    for (const auto& [sequence, pairs] : sequences) {
      for (int k = 0; k < pairs; ++k) ids_.push_back({"fake", sequence, "1-" + std::to_string(k + 2)});
    }
  }
  std::size_t size() const override { return ids_.size(); }
  PairId id(std::size_t index) const override { return ids_.at(index); }
  ImagePair read(std::size_t index) const override {
    check(index);
    ImagePair pair;
    pair.id = id(index);
    pair.left = cv::Mat(2, 3, CV_8U, cv::Scalar(static_cast<double>(index)));
    pair.right = cv::Mat(2, 3, CV_8U, cv::Scalar(static_cast<double>(index) + 100));
    pair.left_name = "left" + std::to_string(index);
    pair.right_name = "right" + std::to_string(index);
    pair.truth.kind = TruthKind::kHomography;
    pair.left_camera.emplace().matrix(0, 2) = static_cast<double>(index);
    pair.right_camera.emplace().matrix(0, 2) = static_cast<double>(index) + 100;
    pair.given.emplace();
    return pair;
  }
  void check(std::size_t index) const override {
    if (index == broken) throw DatasetError("the image is missing");
  }
  std::vector<std::string> files() const override { return {"a", "b"}; }
  std::vector<std::string> ignored() const override { return {"documents"}; }

  std::size_t broken = static_cast<std::size_t>(-1);

 private:
  std::vector<PairId> ids_;
};

UnrelatedReader unrelated(const std::vector<std::pair<std::string, int>>& sequences, int seed = 0) {
  return UnrelatedReader(std::make_unique<FakeReader>(sequences), seed);
}

std::vector<std::string> idsOf(const DatasetReader& reader) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < reader.size(); ++i) ids.push_back(reader.id(i).text());
  return ids;
}

TEST(Unrelated, PairsImagesOfDifferentSequences) {
  const std::vector<std::pair<std::string, int>> sequences = {{"bark", 5}, {"wall", 5}, {"ubc", 3}};
  const FakeReader scenes(sequences);
  const UnrelatedReader reader = unrelated(sequences);
  EXPECT_EQ(reader.size(), 5u * 2 + 5 * 2 + 3 * 2) << "every right image beside each other sequence";
  std::set<std::string> ids;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.id, reader.id(i));
    EXPECT_TRUE(ids.insert(pair.id.text()).second) << pair.id.text();
    const PairId left = scenes.id(pair.left.at<std::uint8_t>(0, 0));
    const PairId right = scenes.id(pair.right.at<std::uint8_t>(1, 1) - 100u);
    EXPECT_NE(left.sequence, right.sequence);
    EXPECT_EQ(pair.left_name, "left" + std::to_string(pair.left.at<std::uint8_t>(0, 0)));
    EXPECT_EQ(pair.right_name, "right" + std::to_string(pair.right.at<std::uint8_t>(1, 1) - 100));
    EXPECT_EQ(pair.left_camera->matrix(0, 2), pair.left.at<std::uint8_t>(0, 0));
    EXPECT_EQ(pair.right_camera->matrix(0, 2), pair.right.at<std::uint8_t>(0, 0));
    EXPECT_EQ(pair.id.dataset, "unrelated_fake");
    EXPECT_EQ(pair.id.sequence, left.sequence + "+" + right.sequence);
    EXPECT_EQ(pair.id.pair, left.pair + "+" + right.pair);
    EXPECT_EQ(pair.truth.kind, TruthKind::kNone);
    EXPECT_FALSE(pair.given.has_value());
  }
  EXPECT_EQ(reader.files(), scenes.files());
  EXPECT_EQ(reader.ignored(), scenes.ignored());
}

TEST(Unrelated, DrawsAtMost120PairsWithTheSeed) {
  const std::vector<std::pair<std::string, int>> sequences = {{"bark", 30}, {"wall", 30}, {"ubc", 30}};
  const UnrelatedReader reader = unrelated(sequences, 3);
  EXPECT_EQ(reader.size(), 120u);
  EXPECT_EQ(idsOf(reader), idsOf(unrelated(sequences, 3)));
  EXPECT_NE(idsOf(reader), idsOf(unrelated(sequences, 4)));
  std::map<std::string, int> rights, lefts;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const std::string sequence = reader.id(i).sequence;
    ++lefts[sequence.substr(0, sequence.find('+'))];
    ++rights[sequence.substr(sequence.find('+') + 1)];
  }
  for (const auto& [name, pairs] : sequences) {
    EXPECT_GT(lefts[name], 20) << name;
    EXPECT_GT(rights[name], 20) << name;
  }
}

TEST(Unrelated, LeavesOutSequencesThatMayShowThePlace) {
  const UnrelatedReader reader = unrelated({{"notredame", 1}, {"notredame12", 1}, {"taj", 1}});
  EXPECT_EQ(reader.size(), 4u);
  for (std::size_t i = 0; i < reader.size(); ++i) EXPECT_TRUE(contains(reader.id(i).sequence, "taj"));

  for (const auto& [a, b] : std::vector<std::pair<std::string, std::string>>{{"arch", "arch_easy"},
                                                                             {"sanmarco2", "sanmarco"},
                                                                             {"johnsona", "johnsonb"},
                                                                             {"breadcube", "cubechips"},
                                                                             {"Cube", "breadCUBE"},
                                                                             {"7", "7"}}) {
    EXPECT_TRUE(mayShowOnePlace(a, b)) << a << " " << b;
    EXPECT_TRUE(mayShowOnePlace(b, a)) << a << " " << b;
  }
  for (const auto& [a, b] :
       std::vector<std::pair<std::string, std::string>>{{"bark", "bikes"}, {"2011_1", "2011_2"}, {"", "a"}}) {
    EXPECT_FALSE(mayShowOnePlace(a, b)) << a << " " << b;
  }
}

TEST(Unrelated, ABeginningOfAllNamesDoesNotCount) {
  EXPECT_TRUE(mayShowOnePlace("scene_1", "scene_2"));
  EXPECT_FALSE(mayShowOnePlace("scene_1", "scene_2", 6));
  EXPECT_EQ(unrelated({{"scene_1", 2}, {"scene_2", 2}}).size(), 4u);
  EXPECT_EQ(unrelated({{"scene_one", 1}, {"scene_oneb", 1}, {"scene_two", 1}}).size(), 4u);
}

TEST(Unrelated, NamesADatasetWithoutDifferentScenes) {
  for (const auto& sequences : {std::vector<std::pair<std::string, int>>{{"kitti", 37}}, {}}) {
    const std::string error = errorOf<DatasetError>([&] { unrelated(sequences); });
    EXPECT_TRUE(contains(error, "has no two sequences that show different places")) << error;
    EXPECT_TRUE(contains(error, sequences.empty() ? "it has 0" : "dataset 'fake'")) << error;
  }
}

TEST(Unrelated, ABrokenImageIsReportedWithItsPairs) {
  auto scenes = std::make_unique<FakeReader>(
      std::vector<std::pair<std::string, int>>{{"bark", 1}, {"wall", 1}, {"ubc", 1}});
  scenes->broken = 2;
  const UnrelatedReader reader(std::move(scenes));
  ASSERT_EQ(reader.size(), 6u);
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const bool broken = contains(reader.id(i).sequence, "ubc");
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.read(i); }), broken ? "the image is missing" : "");
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(i); }), broken ? "the image is missing" : "");
  }
  EXPECT_EQ(describe(reader, {}).problems.size(), 4u);
}

TEST(Unrelated, HasMoreThan200PairsOfTheRealDatasets) {
  std::size_t pairs = 0;
  for (const std::string name : {"vgg", "symbench"}) {
    if (sharedData(name).empty()) GTEST_SKIP() << "skipped: no dataset " << name;
    const auto reader = openDataset("unrelated_" + name, sharedData(name));
    pairs += reader->size();
    EXPECT_EQ(describe(*reader, {}).problems, std::vector<std::string>());
  }
  EXPECT_GE(pairs, 200u);
}

}  // namespace
}  // namespace corrsel::core
