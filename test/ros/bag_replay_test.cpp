// A dataset bag played by replay.launch through the live nodelets gives the selections that the core computes
// offline.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "../core/test_support.h"
#include "benchmark/saved_matches.h"
#include "corrsel/Score.h"
#include "corrsel/Selection.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"
#include "ros/bags/dataset_bag_writer.h"
#include "shell.h"
#include "test_paths.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr int kPairs = 4;

/// roslaunch as a child process, ended with Ctrl-C.
class Launch {
 public:
  explicit Launch(const std::vector<std::string>& arguments) : pid_(fork()) {
    if (pid_ != 0) return;
    setpgid(0, 0);
    std::vector<std::string> words = {"roslaunch", "corrsel", "replay.launch"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ~Launch() {
    kill(pid_, SIGINT);
    waitpid(pid_, nullptr, 0);
  }
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;

 private:
  pid_t pid_;
};

/// Pairs with images and with matches of their own, whose truth is a label per match.
std::vector<core::ImagePair> makePairs() {
  std::vector<core::ImagePair> pairs;
  for (int k = 0; k < kPairs; ++k) {
    core::testing::SceneOptions options;
    options.seed = static_cast<std::uint64_t>(k) + 1;
    const core::testing::Scene scene = core::testing::homographyScene(options);
    core::ImagePair pair;
    pair.id = {"replayed", "scene", std::to_string(k)};
    core::Random random(options.seed);
    pair.left = cv::Mat(core::testing::kSceneHeight, core::testing::kSceneWidth, CV_8U, cv::Scalar(40));
    for (int blob = 0; blob < 400; ++blob) {
      const auto y = static_cast<int>(random.index(core::testing::kSceneHeight));
      const auto x = static_cast<int>(random.index(core::testing::kSceneWidth));
      const cv::Scalar grey(random.uniform(60, 255));
      const int radius = 3 + static_cast<int>(random.index(12));
      cv::circle(pair.left, {x, y}, radius, grey, -1);
    }
    cv::warpPerspective(pair.left, pair.right, scene.model, pair.left.size());
    pair.truth.kind = core::TruthKind::kLabels;
    pair.truth.labels.assign(scene.inlier.begin(), scene.inlier.end());
    pair.given = scene.matches;
    pairs.push_back(pair);
  }
  return pairs;
}

class BagReplay : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    bag_ = fs::temp_directory_path() / ("corrsel_replay_" + std::to_string(getpid()) + ".bag");
    pairs_ = makePairs();
    DatasetBagWriter writer(bag_.string());
    for (const core::ImagePair& pair : pairs_) writer.write(pair);
    writer.close();
  }
  static void TearDownTestSuite() { fs::remove(bag_); }

  /// Plays the bag and collects the results by their stamps. Waits until every pair has a selection and, if
  /// wanted, a score. On a busy machine the nodelets can be too late for the first pairs, so the bag is then
  /// played again with a longer delay.
  std::map<ros::Time, SelectionConstPtr> play(const std::vector<std::string>& arguments, bool scored,
                                              const fs::path& bag = bag_) {
    std::map<ros::Time, SelectionConstPtr> selections;
    for (const int delay : {6, 20, 60}) {
      selections = playOnce(arguments, scored, bag, delay);
      if (isComplete(selections, scored)) break;
    }
    return selections;
  }

  static fs::path bag_;
  static std::vector<core::ImagePair> pairs_;
  std::map<ros::Time, ScoreConstPtr> scores_;

 private:
  bool isComplete(const std::map<ros::Time, SelectionConstPtr>& selections, bool scored) const {
    return selections.size() == kPairs && (!scored || scores_.size() == kPairs);
  }

  /// @param delay time between the start of the nodelets and the first pair, s
  std::map<ros::Time, SelectionConstPtr> playOnce(const std::vector<std::string>& arguments, bool scored,
                                                  const fs::path& bag, int delay) {
    std::mutex mutex;
    std::map<ros::Time, SelectionConstPtr> selections;
    scores_.clear();
    ros::NodeHandle node;
    const auto on_selection = [&](const SelectionConstPtr& msg) {
      const std::lock_guard<std::mutex> lock(mutex);
      selections[msg->header.stamp] = msg;
    };
    const auto on_score = [&](const ScoreConstPtr& msg) {
      const std::lock_guard<std::mutex> lock(mutex);
      scores_[msg->header.stamp] = msg;
    };
    const ros::Subscriber selection = node.subscribe<Selection>("/selection", 100, on_selection);
    const ros::Subscriber score = node.subscribe<Score>("/score", 100, on_score);
    std::vector<std::string> all = {"bag:=" + bag.string(), "rate:=1",
                                    "start_delay:=" + std::to_string(delay)};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Launch launch(all);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(40 + delay);
    while (std::chrono::steady_clock::now() < deadline) {
      {
        const std::lock_guard<std::mutex> lock(mutex);
        if (isComplete(selections, scored)) break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    return selections;
  }
};

fs::path BagReplay::bag_;
std::vector<core::ImagePair> BagReplay::pairs_;

class BagReplayOf : public BagReplay, public ::testing::WithParamInterface<std::string> {};

TEST_P(BagReplayOf, GivesTheCoresSelections) {
  const auto selections = play({"given:=true", "selector:=" + GetParam()}, true);
  ASSERT_EQ(selections.size(), static_cast<std::size_t>(kPairs));
  ASSERT_EQ(scores_.size(), static_cast<std::size_t>(kPairs));
  const auto selector = core::createSelector(GetParam());
  std::size_t k = 0;
  for (const auto& [stamp, msg] : selections) {
    const core::Selection offline = selector->select(*pairs_[k].given);
    EXPECT_EQ(msg->selector, GetParam());
    EXPECT_EQ(msg->mask, offline.mask);
    EXPECT_EQ(msg->status, static_cast<std::uint8_t>(offline.status));
    EXPECT_GT(offline.n_selected, 0U);
    const core::Evaluation evaluation = core::evaluate(
        pairs_[k].truth.kind, core::groundTruthErrors(pairs_[k].truth, *pairs_[k].given), offline.mask);
    const Score& score = *scores_.at(stamp);
    EXPECT_EQ(score.pair, pairs_[k].id.pair);
    ASSERT_EQ(score.f_paper.size(), 1U);
    EXPECT_EQ(score.f_paper[0], evaluation.metrics[0].f_paper);
    ++k;
  }
}

INSTANTIATE_TEST_SUITE_P(Selectors, BagReplayOf, ::testing::Values("nnsr", "ransac", "gms", "lpm"),
                         [](const ::testing::TestParamInfo<std::string>& info) { return info.param; });

TEST_F(BagReplay, ThroughFeaturesAndMatching) {
  const auto selections = play({"features:=orb+orb", "selector:=gms"}, false);
  ASSERT_EQ(selections.size(), static_cast<std::size_t>(kPairs));
  // In live use detectors keep fewer features by default.
  const auto extractor = core::createExtractor("orb+orb", {{"orb", {{"max_features", "1000"}}}});
  const auto selector = core::createSelector("gms");
  std::size_t k = 0;
  for (const auto& answer : selections) {
    const auto features = core::extractPair(*extractor, pairs_[k].left, pairs_[k].right, 1);
    const core::Selection offline = selector->select(core::matchFeatures(features.first, features.second));
    EXPECT_EQ(answer.second->mask, offline.mask);
    EXPECT_GT(offline.n_selected, 0U);
    ++k;
  }
}

TEST_F(BagReplay, MatchesFromFilesAreSelected) {
  const fs::path folder = bag_.parent_path() / ("corrsel_match_files_" + std::to_string(getpid()));
  for (const core::ImagePair& pair : pairs_) {
    core::SavedMatches files(folder.string(), pair, false);
    files.writePutative({"given", "none"}, *pair.given);
  }
  const fs::path bag = folder / "files.bag";
  const testing::Output output =
      testing::shell("python3 " + testing::sourceDir() + "/scripts/matches_to_bag.py " +
                     (folder / "matches").string() + " --size " + std::to_string(core::testing::kSceneWidth) +
                     "x" + std::to_string(core::testing::kSceneHeight) + " --output " + bag.string());
  ASSERT_EQ(output.code, 0) << output.text;
  const auto selections = play({"given:=true", "selector:=lpm"}, false, bag);
  ASSERT_EQ(selections.size(), static_cast<std::size_t>(kPairs));
  const auto selector = core::createSelector("lpm");
  std::size_t k = 0;
  for (const auto& answer : selections) {
    const core::Selection offline = selector->select(*pairs_[k].given);
    EXPECT_EQ(answer.second->mask, offline.mask);
    EXPECT_GT(offline.n_selected, 0U);
    ++k;
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "bag_replay_test");
  const ros::NodeHandle node;
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
