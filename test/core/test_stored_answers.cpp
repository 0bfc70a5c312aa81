#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
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
    const Selection selection = selector->select(makeScene({kind, kMatches, inlier_ratio, seed}).matches);
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

/// Masks are the same on all machines, and models up to rounding; see docs/evaluation.md. A change that is
/// meant to move results needs new answers: CORRSEL_STORE_ANSWERS=1 test_stored_answers.
TEST(StoredAnswers, HoldOnAllMachines) {
  const bool store = std::getenv("CORRSEL_STORE_ANSWERS") != nullptr;
  std::ofstream out;
  std::ifstream in;
  if (store) {
    out.open(storedFile());
    out.precision(9);
  } else {
    in.open(storedFile());
  }
  ASSERT_TRUE(store ? out.is_open() : in.is_open()) << storedFile();
  for (const auto& scene : kScenes) {
    for (const std::string& spec : allSpecs()) {
      SCOPED_TRACE(std::string(scene.name) + " " + spec);
      const Answers answers = answersOf(spec, scene.kind, scene.inlier_ratio);
      if (store) {
        out << scene.name << " " << spec << " " << answers.selected << " " << answers.masks.text();
        for (const double value : answers.model.val) out << " " << value;
        out << "\n";
        continue;
      }
      std::string name, selector, masks;
      std::size_t selected = 0;
      cv::Matx33d model;
      in >> name >> selector >> selected >> masks;
      for (double& value : model.val) in >> value;
      ASSERT_EQ(name + " " + selector, std::string(scene.name) + " " + spec)
          << "the selectors are others than those stored in " << storedFile();
      EXPECT_EQ(answers.selected, selected);
      EXPECT_EQ(answers.masks.text(), masks);
      EXPECT_LT(difference(answers.model, model), 1e-8);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
