#include <gtest/gtest.h>

#include <numeric>

#include "geometry/residual.h"
#include "search/homography_model.h"
#include "search/ordering.h"
#include "search/prosac_proposal.h"
#include "search/search.h"
#include "search/uniform_proposal.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// A scene in the order of a search, and the positions of its inliers and outliers.
struct Shuffled {
  explicit Shuffled(const Scene& scene) {
    Ordering ordering;
    std::vector<std::uint32_t> rows;
    ordering.shuffle(scene.matches, 0, rows);
    normalizeMatches(scene.matches, rows, matches);
    for (std::uint32_t i = 0; i < rows.size(); ++i)
      (scene.inlier[rows[i]] != 0 ? inliers : outliers).push_back(i);
  }

  /// All inliers, and then some outliers.
  std::vector<std::uint32_t> inliersFirst(std::size_t wrong) const {
    std::vector<std::uint32_t> order = inliers;
    order.insert(order.end(), outliers.begin(), outliers.begin() + static_cast<std::ptrdiff_t>(wrong));
    return order;
  }

  NormalizedMatches matches;
  std::vector<std::uint32_t> inliers, outliers;
};

SearchParameters within(double threshold, int max_iterations) {
  SearchParameters parameters;
  parameters.threshold = threshold;
  parameters.max_iterations = max_iterations;
  return parameters;
}

template <class P>
SearchOutcome searchWith(const Shuffled& scene, const SearchParameters& parameters,
                         const std::vector<std::uint32_t>* best_first) {
  P proposal;
  Workspace workspace;
  return search(scene.matches, {HomographyModel(), proposal}, parameters, best_first, Deadline(0), workspace);
}

TEST(Search, DrawsInTheOrderThatItIsGiven) {
  const Shuffled scene(homographyScene({2000, 0.05, 0.5, 2}));
  ASSERT_EQ(scene.inliers.size(), 100u);
  std::vector<std::uint32_t> order = scene.inliersFirst(1900);
  EXPECT_GT(searchWith<ProsacProposal>(scene, within(3, 20), &order).best.inliers, 95u);
  // The outliers first: the inliers are not drawn within so few hypotheses.
  std::reverse(order.begin(), order.end());
  EXPECT_LT(searchWith<ProsacProposal>(scene, within(3, 20), &order).best.inliers, 50u);
}

TEST(Search, OnlyTheMatchesThatAreGivenTakePart) {
  const Shuffled scene(homographyScene({2000, 0.05, 0.5, 2}));
  std::vector<std::uint32_t> some = scene.inliersFirst(30);
  some.erase(some.begin(), some.begin() + 60);  // 40 inliers and 30 outliers
  for (const SearchOutcome& found : {searchWith<ProsacProposal>(scene, within(3, 500), &some),
                                     searchWith<UniformProposal>(scene, within(3, 500), &some)}) {
    EXPECT_GE(found.best.inliers, 38u);
    EXPECT_LE(found.best.inliers, 70u);
  }
}

TEST(Search, DeadlineEndsIt) {
  const Shuffled scene(homographyScene({3000, 0.0, 0.5, 1}));
  UniformProposal proposal;
  Workspace workspace;
  const TickingClock clock(1);
  const SearchOutcome outcome =
      search(scene.matches, {HomographyModel(), proposal}, within(3, 0), nullptr, Deadline(5.5), workspace);
  EXPECT_TRUE(outcome.timed_out);
  EXPECT_GT(outcome.iterations, 0);
  EXPECT_LT(outcome.iterations, 2000);
}

/// Similarities x' = a x - b y + c, y' = b x + a y + d, from two matches: a further kind of model is one
/// class.
class SimilarityModel final : public Model {
 public:
  SimilarityModel() : Model(similarityTraits()) {}

  bool isValidSample(const NormalizedMatches& m, const std::uint32_t* s) const override {
    return m.left_x[s[0]] != m.left_x[s[1]] || m.left_y[s[0]] != m.left_y[s[1]];
  }

  int solve(const NormalizedMatches& m, const std::uint32_t* s, cv::Matx33d* models) const override {
    return fit(m, {s[0], s[1]}, models[0]) ? 1 : 0;
  }

  bool refine(const NormalizedMatches& m, float squared_threshold, cv::Matx33d& model) const override {
    std::vector<float> errors(m.size());
    modelErrors(traits.residual, model, m, 0, m.size(), errors.data());
    std::vector<std::uint32_t> inliers;
    for (std::uint32_t i = 0; i < m.size(); ++i)
      if (errors[i] <= squared_threshold) inliers.push_back(i);
    return fit(m, inliers, model);
  }

  cv::Matx33d toPixels(const NormalizedMatches& m, const cv::Matx33d& model) const override {
    return m.homographyToPixels(model);
  }

  double chanceWithinOnePixel(double width, double height) const override { return 3.14 / (width * height); }

  Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                            std::uint64_t hypotheses) const override {
    return test.homography(pixels, hypotheses);
  }

 private:
  static ModelTraits similarityTraits() {
    ModelTraits traits = HomographyModel(Residual::kTransfer).traits;
    traits.sample_size = 2;
    return traits;
  }

  /// Least squares, in complex numbers: the slope is sum conj(dx) dx' / sum |dx|^2.
  static bool fit(const NormalizedMatches& m, const std::vector<std::uint32_t>& rows, cv::Matx33d& model) {
    cv::Vec4d mean(0, 0, 0, 0);
    const auto match = [&m](std::uint32_t i) {
      return cv::Vec4d(m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
    };
    for (const std::uint32_t i : rows) mean += match(i) * (1.0 / static_cast<double>(rows.size()));
    double along = 0, across = 0, squares = 0;
    for (const std::uint32_t i : rows) {
      const cv::Vec4d d = match(i) - mean;
      along += d[0] * d[2] + d[1] * d[3];
      across += d[0] * d[3] - d[1] * d[2];
      squares += d[0] * d[0] + d[1] * d[1];
    }
    if (!(squares > 0)) return false;
    const double a = along / squares, b = across / squares;
    model = {a, -b, mean[2] - a * mean[0] + b * mean[1], b, a, mean[3] - b * mean[0] - a * mean[1], 0, 0, 1};
    return true;
  }
};

TEST(Search, AFurtherKindOfModelIsOneClass) {
  Random random(3);
  Scene scene;
  for (int i = 0; i < 1000; ++i) {
    const cv::Point2d left = uniformPoint(random, 640, 480);
    const bool inlier = i % 10 < 2;
    const cv::Point2d right(0.8 * left.x - 0.3 * left.y + 150, 0.3 * left.x + 0.8 * left.y - 20);
    scene.matches.add(cv::Point2f(left),
                      cv::Point2f(inlier ? right + normalPoint(random) : uniformPoint(random, 640, 480)));
    scene.inlier.push_back(inlier ? 1 : 0);
  }
  const Shuffled shuffled(scene);
  UniformProposal proposal;
  Workspace workspace;
  const SimilarityModel model;
  const SearchOutcome found =
      search(shuffled.matches, {model, proposal}, within(5, 0), nullptr, Deadline(0), workspace);
  EXPECT_GE(found.best.inliers, 198u);
  EXPECT_LE(found.best.inliers, 206u);
  // A sample of two is pure once in 25 draws, so a fraction of what four matches need is drawn.
  EXPECT_LT(found.iterations, 400);
  const cv::Matx33d pixels = model.toPixels(shuffled.matches, found.best.model);
  EXPECT_NEAR(pixels(0, 0), 0.8, 0.01);
  EXPECT_NEAR(pixels(1, 0), 0.3, 0.01);
  EXPECT_NEAR(pixels(0, 2), 150, 3);
}

/// Proposes given hypotheses, one at a time, and remembers what it is told.
class GivenHypotheses final : public Proposal {
 public:
  explicit GivenHypotheses(std::vector<cv::Matx33d> models, bool rough)
      : Proposal(traitsOf(rough)), models_(std::move(models)) {}
  void start(const ProposalInput&) override { drawn_ = 0; }
  Proposed propose(Hypotheses& hypotheses) override {
    if (drawn_ == models_.size()) return Proposed::kNothingLeft;
    hypotheses.models[0] = models_[drawn_++];
    hypotheses.count = 1;
    return Proposed::kHypotheses;
  }
  void learn(const cv::Matx33d& hypothesis) override { learnt.push_back(hypothesis); }

  std::vector<cv::Matx33d> learnt;

 private:
  static ProposalTraits traitsOf(bool rough) {
    ProposalTraits traits{"given"};
    traits.rough = rough;
    return traits;
  }
  std::vector<cv::Matx33d> models_;
};

TEST(Search, TriesWhatIsProposedAndEndsWhereNothingIsLeft) {
  const Scene scene = homographyScene({500, 0.5, 0.5, 4});
  const Shuffled shuffled(scene);
  const cv::Matx33d truth = shuffled.matches.homographyFromPixels(scene.model);
  cv::Matx33d rough = truth;
  rough(0, 2) += 4 * shuffled.matches.scale * truth(2, 2);  // 4 px to the side
  const cv::Matx33d nothing = cv::Matx33d::eye();
  SearchParameters parameters = within(3, 100);
  parameters.local_optimization = parameters.refine = false;
  parameters.confidence = 1;
  for (const bool refines : {false, true}) {
    GivenHypotheses proposal({nothing, rough}, refines);
    Workspace workspace;
    const SearchOutcome found =
        search(shuffled.matches, {HomographyModel(), proposal}, parameters, nullptr, Deadline(0), workspace);
    EXPECT_EQ(found.iterations, 2);
    EXPECT_EQ(proposal.learnt, (std::vector<cv::Matx33d>{nothing, rough}));
    EXPECT_FALSE(found.no_valid_sample);
    // Only a proposal that says that its hypotheses are rough has them refined.
    if (refines) {
      EXPECT_NE(found.best.model, rough);
      EXPECT_GE(found.best.inliers, 245u);
    } else {
      EXPECT_EQ(found.best.model, rough);
    }
  }
}

/// Prefers the hypothesis with the smallest element (0, 2), whatever its cost.
class SmallestShift final : public SecondScore {
 public:
  void start(const Model&, const Verifier&) override { ++starts; }
  std::int64_t limit(const Candidate&) const override { return std::numeric_limits<std::int64_t>::max(); }
  bool isBest(const cv::Matx33d& hypothesis) override {
    if (hypothesis(0, 2) >= smallest) return false;
    smallest = hypothesis(0, 2);
    return true;
  }
  void adopt(const Candidate&, bool optimized) override { optimizations += optimized ? 1 : 0; }

  int starts = 0, optimizations = 0;
  double smallest = 1e9;
};

TEST(Search, TheSecondScoreDecides) {
  const Scene scene = homographyScene({500, 0.5, 0.5, 4});
  const Shuffled shuffled(scene);
  const cv::Matx33d truth = shuffled.matches.homographyFromPixels(scene.model);
  cv::Matx33d shifted = truth;
  shifted(0, 2) -= 0.001;
  SearchParameters parameters = within(3, 100);
  parameters.local_optimization = parameters.refine = parameters.sprt = false;
  parameters.confidence = 1;
  GivenHypotheses proposal({truth, shifted, truth}, false);
  SmallestShift score;
  Workspace workspace;
  const SearchOutcome found = search(shuffled.matches, {HomographyModel(), proposal, &score}, parameters,
                                     nullptr, Deadline(0), workspace);
  EXPECT_EQ(found.best.model, shifted);
  EXPECT_EQ(score.starts, 1);
  EXPECT_EQ(score.optimizations, 0);
}

TEST(Search, EverySamplerAndScoreIsTheSameWithEveryKernelLevelAndOrder) {
  const LevelGuard guard;
  const Scene scene = homographyScene({700, 0.3, 0.5, 6});
  std::vector<std::uint32_t> rows(700);
  std::iota(rows.begin(), rows.end(), 0U);
  std::reverse(rows.begin(), rows.end());
  const Correspondences reversed = scene.matches.subset(rows);
  for (const char* const spec :
       {"ransac:lo[sampler=local]", "ransac:lo[sampler=prosac]", "pnapsac", "multigs", "mlesac"}) {
    const auto selector = createSelector(spec);
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
  for (const char* const spec :
       {"ransac[sampler=local]", "usac[sampler=local]", "pnapsac", "multigs", "mlesac"}) {
    const auto selector = createSelector(spec);
    SCOPED_TRACE(spec);
    EXPECT_EQ(selector->select({}).status, Status::kTooFew);
    for (const Correspondences* const matches : {&equal, &few, &line}) {
      const Selection found = selector->select(*matches);
      EXPECT_EQ(found.status, Status::kDegenerate) << found.message;
      EXPECT_EQ(found.n_selected, 0u);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
