#include <gtest/gtest.h>

#include <numeric>

#include "corrsel/selectors/usac.h"
#include "search/ordering.h"
#include "search/search.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Rows of the scene: right matches first, then `wrong` wrong ones.
std::vector<std::uint32_t> rightFirst(const Scene& scene, std::size_t wrong) {
  std::vector<std::uint32_t> rows = selectedRows(scene.inlier);
  for (std::uint32_t i = 0; i < scene.inlier.size() && wrong > 0; ++i) {
    if (scene.inlier[i]) continue;
    rows.push_back(i);
    --wrong;
  }
  return rows;
}

Selection consensusOf(const Scene& scene, const ConsensusOptions& options,
                      const std::vector<std::uint32_t>* best_first) {
  Selection result;
  result.mask.assign(scene.matches.size(), 0);
  searchConsensus(scene.matches, options, 3, result, best_first);
  return result;
}

TEST(Search, DrawsInTheOrderThatItIsGiven) {
  const Scene scene = homographyScene({2000, 0.05, 0.5, 2});
  std::vector<std::uint32_t> order = rightFirst(scene, 1900);
  ASSERT_EQ(order.size(), 2000u);
  UsacOptions options;
  options.max_iterations = 20;
  const Selection found = consensusOf(scene, options, &order);
  EXPECT_EQ(found.message, "");
  EXPECT_GT(quality(found.mask, scene.inlier).recall, 99);
  // The wrong matches first: the right ones are not drawn within so few hypotheses.
  std::reverse(order.begin(), order.end());
  EXPECT_LT(quality(consensusOf(scene, options, &order).mask, scene.inlier).recall, 50);
}

TEST(Search, MatchesThatAreNotGivenDoNotTakePartButAreJudged) {
  const Scene scene = homographyScene({2000, 0.05, 0.5, 2});
  std::vector<std::uint32_t> rows = rightFirst(scene, 30);
  rows.erase(rows.begin(), rows.begin() + 60);  // 40 right matches and 30 wrong ones
  for (const auto sampler : {ConsensusOptions::Sampler::kProsac, ConsensusOptions::Sampler::kUniform}) {
    UsacOptions options;
    options.sampler = sampler;
    options.max_iterations = 500;
    const Selection found = consensusOf(scene, options, &rows);
    EXPECT_EQ(found.status, Status::kOk);
    EXPECT_EQ(found.message, "");
    EXPECT_GT(quality(found.mask, scene.inlier).recall, 95);
    EXPECT_EQ(found.score.size(), 2000u);
  }
  rows.resize(3);
  const Selection few = consensusOf(scene, UsacOptions(), &rows);
  EXPECT_EQ(few.status, Status::kTooFew);
  EXPECT_EQ(few.message, "3 matches, a homography needs 4");
}

TEST(Search, OrderOfTheDistancesIsTheDefault) {
  const Scene scene = homographyScene({1000, 0.3, 0.5, 2});
  const UsacOptions options;
  // byQuality() orders ties as they are shuffled; there are none here.
  std::vector<std::uint32_t> order(1000);
  std::iota(order.begin(), order.end(), 0U);
  const auto ratio = [&scene](std::uint32_t i) {
    return scene.matches.distance[i] / scene.matches.second_distance[i];
  };
  std::sort(order.begin(), order.end(),
            [&ratio](std::uint32_t a, std::uint32_t b) { return ratio(a) < ratio(b); });
  const Selection given = consensusOf(scene, options, &order), own = consensusOf(scene, options, nullptr);
  EXPECT_EQ(given.mask, own.mask);
  EXPECT_EQ(given.model, own.model);
  EXPECT_EQ(given.iterations, own.iterations);
}

TEST(Search, ModelAloneIsThatOfTheSelection) {
  for (const ModelKind kind : {ModelKind::kHomography, ModelKind::kFundamental}) {
    const Scene scene = kind == ModelKind::kHomography ? homographyScene({800, 0.5, 0.5, 4})
                                                       : stereoScene({800, 0.5, 0.5, 4});
    UsacOptions options;
    options.model = kind;
    // With this error the model found is not fitted again before matches are selected.
    options.error = ConsensusOptions::Error::kSymmetricTransfer;
    const std::vector<std::uint32_t> rows = rightFirst(scene, 100);
    const Selection selection = consensusOf(scene, options, &rows);
    Ordering ordering;
    std::vector<std::uint32_t> shuffled, best_first;
    ordering.shuffle(scene.matches, static_cast<std::uint64_t>(options.seed), shuffled);
    NormalizedMatches matches;
    normalizeMatches(scene.matches, shuffled, matches);
    for (const std::uint32_t row : rows) {
      best_first.push_back(
          static_cast<std::uint32_t>(std::find(shuffled.begin(), shuffled.end(), row) - shuffled.begin()));
    }
    const SearchOutcome outcome = searchModel(matches, options, 3, &best_first, Deadline(0));
    EXPECT_FALSE(outcome.timed_out);
    EXPECT_EQ(outcome.iterations, selection.iterations);
    ASSERT_TRUE(outcome.best.exists());
    EXPECT_EQ((matches.*problemOf(options).toPixels)(outcome.best.model), selection.model);
    // Only the matches that take part support the model.
    EXPECT_LE(outcome.best.inliers, rows.size());
    EXPECT_GT(outcome.best.inliers, rows.size() / 2);
  }
}

TEST(Search, EverySamplerAndScoreIsTheSameWithEveryKernelLevelAndOrder) {
  const LevelGuard guard;
  const Scene scene = homographyScene({700, 0.3, 0.5, 6});
  std::vector<std::uint32_t> rows(700);
  std::iota(rows.begin(), rows.end(), 0U);
  std::reverse(rows.begin(), rows.end());
  const Correspondences reversed = scene.matches.subset(rows);
  const OptionMap parts[] = {{{"sampler", "local"}},
                             {{"sampler", "pnapsac"}},
                             {{"sampler", "multigs"}},
                             {{"sampler", "prosac"}, {"score", "mlesac"}}};
  for (const OptionMap& options : parts) {
    const auto selector = createSelector("ransac:lo", options);
    const Selection expected = selector->select(scene.matches);
    EXPECT_GT(quality(expected.mask, scene.inlier).f, 95);
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      EXPECT_EQ(selector->select(scene.matches).model, expected.model);
    }
    EXPECT_EQ(selector->select(reversed).model, expected.model);
  }
}

TEST(Search, EverySamplerKnowsDegenerateInput) {
  Correspondences equal, few, line;
  for (int i = 0; i < 50; ++i) {
    const auto x = static_cast<float>(i);
    equal.add({10, 10}, {20, 20});
    line.add({x, 2 * x}, {3 * x, x});
  }
  few.add({0, 0}, {0, 0});
  few.add({100, 0}, {100, 5});
  few.add({0, 100}, {5, 100});
  few.add({100, 110}, {103, 106});
  for (Correspondences* const matches : {&equal, &few, &line}) {
    matches->distance.assign(matches->size(), 1);
    matches->second_distance.assign(matches->size(), 2);
  }
  for (const char* const sampler : {"local", "pnapsac", "multigs"}) {
    for (const char* const name : {"ransac", "usac"}) {
      const auto selector = createSelector(name, {{"sampler", sampler}});
      SCOPED_TRACE(std::string(name) + ", " + sampler);
      EXPECT_EQ(selector->select({}).status, Status::kTooFew);
      for (const Correspondences* const matches : {&equal, &few, &line}) {
        const Selection found = selector->select(*matches);
        EXPECT_EQ(found.status, Status::kDegenerate) << found.message;
        EXPECT_EQ(found.n_selected, 0u);
      }
    }
  }
}

TEST(Search, DeadlineEndsIt) {
  const Scene scene = homographyScene({3000, 0.0, 0.5, 1});
  const NormalizedMatches matches = normalizeMatches(scene.matches);
  const TickingClock clock(1);
  const SearchOutcome outcome = searchModel(matches, UsacOptions(), 3, nullptr, Deadline(5.5));
  EXPECT_TRUE(outcome.timed_out);
  EXPECT_GT(outcome.iterations, 0);
  EXPECT_LT(outcome.iterations, 2000);
}

}  // namespace
}  // namespace corrsel::core
