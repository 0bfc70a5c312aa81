#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/checksum.h"
#include "corrsel/datasets/scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr std::size_t kMatches = 300;
constexpr int kSeeds = 4;

const struct {
  const char* name;
  MatchSceneKind kind;
  double inlier_ratio;
} kScenes[] = {{"plane", MatchSceneKind::kPlane, 0.3},
               {"space", MatchSceneKind::kSpace, 0.5},
               {"moving_object", MatchSceneKind::kMovingObject, 0.6},
               {"facade", MatchSceneKind::kFacade, 0.5}};

/// What a selector returns for the scenes of one kind.
struct Answers {
  std::size_t selected = 0;                  ///< in all scenes
  Checksum masks;                            ///< of all scenes
  cv::Matx33d model = cv::Matx33d::zeros();  ///< of the last scene with a model, norm 1
};

Answers answersOf(const std::string& spec, MatchSceneKind kind, double inlier_ratio) {
  Answers answers;
  const auto selector = createSelector(spec);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Correspondences matches = makeScene({kind, kMatches, inlier_ratio, seed}).matches;
    if (testing::needsCameras(*selector)) matches.left_camera = matches.right_camera = sceneCamera();
    const Selection selection = selector->select(matches);
    answers.selected += selection.n_selected;
    answers.masks.add(selection.mask.data(), selection.mask.size());
    const double norm = cv::norm(selection.model);
    if (norm > 0) answers.model = selection.model * (1 / norm);
  }
  return answers;
}

/// The largest difference of the elements. Fundamental matrices have no sign.
double difference(const cv::Matx33d& a, const cv::Matx33d& b) {
  return std::min(cv::norm(a - b, cv::NORM_INF), cv::norm(a + b, cv::NORM_INF));
}

std::string storedFile() { return corrsel::testing::sourceDir() + "/test/core/stored_answers.txt"; }

/// The lines of the file by their first two words, the scene and the selector.
std::map<std::string, std::string> storedAnswers() {
  std::map<std::string, std::string> answers;
  std::ifstream in(storedFile());
  std::string scene, spec, rest;
  while (in >> scene >> spec && std::getline(in, rest)) answers[scene + " " + spec] = rest;
  return answers;
}

/// Masks are the same on all machines, and models up to rounding; see docs/evaluation.md. A change that is
/// meant to move results needs new answers: CORRSEL_STORE_ANSWERS=1 test_stored_answers.
TEST(StoredAnswers, HoldOnAllMachines) {
  const bool store = std::getenv("CORRSEL_STORE_ANSWERS") != nullptr;
  std::ofstream out;
  std::map<std::string, std::string> stored;
  if (store) {
    out.open(storedFile());
    ASSERT_TRUE(out.is_open()) << storedFile();
    out.precision(9);
  } else {
    stored = storedAnswers();
  }
  for (const auto& scene : kScenes) {
    for (const std::string& spec : allSpecs()) {
      const std::string key = std::string(scene.name) + " " + spec;
      SCOPED_TRACE(key);
      const Answers answers = answersOf(spec, scene.kind, scene.inlier_ratio);
      if (store) {
        out << key << " " << answers.selected << " " << answers.masks.text();
        for (const double value : answers.model.val) out << " " << value;
        out << "\n";
        continue;
      }
      ASSERT_EQ(stored.count(key), 1U) << "not stored in " << storedFile();
      std::istringstream in(stored.at(key));
      stored.erase(key);
      std::string masks;
      std::size_t selected = 0;
      cv::Matx33d model;
      in >> selected >> masks;
      for (double& value : model.val) in >> value;
      EXPECT_EQ(answers.selected, selected);
      EXPECT_EQ(answers.masks.text(), masks);
      EXPECT_LT(difference(answers.model, model), 1e-8);
    }
  }
  EXPECT_TRUE(stored.empty()) << stored.begin()->first << " is stored, but no selector";
}

}  // namespace
}  // namespace corrsel::core
