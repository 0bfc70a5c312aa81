#include <gtest/gtest.h>

#include <set>

#include "search/homography_model.h"
#include "search/local_proposal.h"
#include "search/prosac_proposal.h"
#include "search/uniform_proposal.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// A homography with a sample size and a schedule of its own. Its samples are all valid.
class AnyModel final : public Model {
 public:
  explicit AnyModel(int sample_size, const ProsacSchedule& schedule = {})
      : Model(traitsOf(sample_size, schedule)) {}
  bool isValidSample(const NormalizedMatches&, const std::uint32_t*) const override { return valid; }
  int solve(const NormalizedMatches&, const std::uint32_t*, cv::Matx33d* models) const override {
    models[0] = cv::Matx33d::eye();
    return 1;
  }
  bool refine(const NormalizedMatches&, float, cv::Matx33d&) const override { return false; }
  cv::Matx33d toPixels(const NormalizedMatches&, const cv::Matx33d& model) const override { return model; }
  double chanceWithinOnePixel(double, double) const override { return 0; }
  Significance significance(SignificanceTest&, const cv::Matx33d&, std::uint64_t) const override {
    return {};
  }

  bool valid = true;

 private:
  static ModelTraits traitsOf(int sample_size, const ProsacSchedule& schedule) {
    ModelTraits traits = HomographyModel().traits;
    traits.sample_size = sample_size;
    traits.prosac = schedule;
    return traits;
  }
};

/// A proposal that has begun a search.
template <class P>
struct Started {
  Started(const NormalizedMatches& given, const std::vector<std::uint32_t>* order, const AnyModel& any,
          std::uint64_t seed = 1)
      : matches(given), model(any) {
    proposal.start({matches, order, model, 100, seed, deadline});
  }
  Started(std::size_t count, const std::vector<std::uint32_t>* order, const AnyModel& any,
          std::uint64_t seed = 1)
      : Started(zeros(count), order, any, seed) {}

  static NormalizedMatches zeros(std::size_t count) {
    NormalizedMatches matches;
    for (auto* column : {&matches.left_x, &matches.left_y, &matches.right_x, &matches.right_y})
      column->assign(count, 0.0F);
    return matches;
  }

  NormalizedMatches matches;
  AnyModel model;
  Deadline deadline{0};
  P proposal;
};

TEST(SampleProposal, SolvesValidSamplesAndGivesUpWhereThereAreNone) {
  Started<UniformProposal> started(20, nullptr, AnyModel(4));
  Hypotheses hypotheses;
  EXPECT_EQ(started.proposal.propose(hypotheses), Proposed::kHypotheses);
  EXPECT_EQ(hypotheses.count, 1);
  EXPECT_EQ(hypotheses.models[0], cv::Matx33d::eye());
  EXPECT_EQ(started.proposal.drawn(), 1u);
  started.model.valid = false;
  EXPECT_EQ(started.proposal.propose(hypotheses), Proposed::kNoValidSample);
  EXPECT_EQ(started.proposal.drawn(), 10001u);
  // Up to 10000 and 50 for each of the 100 hypotheses.
  EXPECT_EQ(started.proposal.propose(hypotheses), Proposed::kNoValidSample);
  EXPECT_EQ(started.proposal.drawn(), 15000u);
}

TEST(UniformProposal, SamplesAreDistinctAndEven) {
  Started<UniformProposal> started(20, nullptr, AnyModel(4));
  UniformProposal& sampler = started.proposal;
  std::vector<int> counts(20, 0);
  std::uint32_t sample[4];
  for (int i = 0; i < 20000; ++i) {
    sampler.draw(sample);
    EXPECT_EQ(std::set<std::uint32_t>(sample, sample + 4).size(), 4u);
    for (const std::uint32_t k : sample) ++counts[k];
  }
  EXPECT_EQ(sampler.drawn(), 20000u);
  EXPECT_EQ(sampler.prefixes(), nullptr);
  for (const int count : counts) EXPECT_NEAR(count, 4000, 300);
}

/// Matches on a lattice of 20 x 20, which a shift moves: neighbours in four dimensions are those of the
/// lattice.
Correspondences lattice() {
  Correspondences m;
  for (int i = 0; i < 400; ++i) {
    const cv::Point2f p(static_cast<float>(10 * (i % 20)), static_cast<float>(10 * (i / 20)));
    m.add(p, p + cv::Point2f(5, 7));
  }
  return m;
}

TEST(MatchNeighbourhood, IsNearInBothImages) {
  Correspondences m = lattice();
  // A match that begins beside match 210 and ends elsewhere is not near.
  m.right_x[211] += 500;
  const NormalizedMatches normalized = normalizeMatches(m);
  MatchNeighbourhood near;
  near.build(normalized);
  std::uint32_t found[8];
  ASSERT_EQ(near.find(210, 8, found), 8);
  // The eight around it, without itself and without that one; the ninth is two columns away.
  const std::set<std::uint32_t> numbers(found, found + 8);
  EXPECT_EQ(numbers.count(210), 0u);
  EXPECT_EQ(numbers.count(211), 0u);
  for (const std::uint32_t expected : {189U, 190U, 191U, 209U, 229U, 230U, 231U})
    EXPECT_EQ(numbers.count(expected), 1u);
}

TEST(LocalProposal, LocalSamplesAreNearOneAnotherInThreeOfFourDraws) {
  const NormalizedMatches normalized = normalizeMatches(lattice());
  Started<LocalProposal> started(normalized, nullptr, AnyModel(4));
  LocalProposal& sampler = started.proposal;
  int local = 0;
  for (int draw = 0; draw < 4000; ++draw) {
    std::uint32_t sample[4];
    sampler.draw(sample);
    EXPECT_EQ(std::set<std::uint32_t>(sample, sample + 4).size(), 4u);
    bool all_near = true;
    for (const std::uint32_t k : sample) {
      const int dx = int(k % 20) - int(sample[0] % 20), dy = int(k / 20) - int(sample[0] / 20);
      all_near = all_near && dx * dx + dy * dy <= 200;
    }
    local += all_near ? 1 : 0;
  }
  EXPECT_GE(local, 3000);
  EXPECT_LE(local, 3900);
}

TEST(LocalProposal, LocalSamplesBeginWithTheBestMatchesInEverySecondRound) {
  const NormalizedMatches normalized = normalizeMatches(lattice());
  const std::vector<std::uint32_t> order = permutation(400, 3);
  Started<LocalProposal> started(normalized, &order, AnyModel(4));
  LocalProposal& sampler = started.proposal;
  std::uint32_t sample[4];
  for (std::uint64_t draw = 1; draw <= 800; ++draw) {
    sampler.draw(sample);
    if (draw % 4 < 3 && draw / 4 % 2 == 0) {
      EXPECT_EQ(sample[0], order[draw / 8]) << draw;
    }
  }
}

/// Two planes with 30 % of the matches each: the share of samples whose members are all of one plane.
TEST(LocalProposal, LocalSamplesAreMoreOftenPure) {
  Random random(1);
  Correspondences m;
  std::vector<int> plane;
  for (int i = 0; i < 300; ++i) {
    const int of = i % 10 < 3 ? 0 : i % 10 < 6 ? 1 : 2;
    const cv::Point2d left = uniformPoint(random, 320, 480) + cv::Point2d(of == 1 ? 320 : 0, 0);
    m.add(left, of == 2   ? uniformPoint(random, 640, 480)
                : of == 0 ? left + cv::Point2d(20, 5)
                          : 0.8 * left + cv::Point2d(60, 40));
    plane.push_back(of);
  }
  const NormalizedMatches normalized = normalizeMatches(m);
  Started<LocalProposal> local(normalized, nullptr, AnyModel(4));
  Started<UniformProposal> uniform(normalized, nullptr, AnyModel(4));
  const auto pure = [&](SampleProposal& sampler) {
    int count = 0;
    for (int draw = 0; draw < 4000; ++draw) {
      std::uint32_t s[4];
      sampler.draw(s);
      count += plane[s[0]] < 2 && plane[s[1]] == plane[s[0]] && plane[s[2]] == plane[s[0]] &&
                       plane[s[3]] == plane[s[0]]
                   ? 1
                   : 0;
    }
    return count;
  };
  EXPECT_GT(pure(local.proposal), 5 * pure(uniform.proposal));
}

TEST(ProsacProposal, ProsacGrowsItsPoolAsThePaperSays) {
  const std::vector<std::uint32_t> order = permutation(1000, 3);
  constexpr int kSample = 4;
  // T'_n by the recurrence of the paper on PROSAC.
  std::vector<std::uint64_t> last(1001, 0);
  double t = 200000;
  for (int i = 0; i < kSample; ++i) t *= (4.0 - i) / (1000.0 - i);
  last[4] = 1;
  for (std::size_t n = 4; n < 1000; ++n) {
    const double next = t * (double(n) + 1) / (double(n) + 1 - kSample);
    last[n + 1] = last[n] + std::uint64_t(std::ceil(next - t));
    t = next;
  }
  EXPECT_NEAR(t, 200000, 1);
  Started<ProsacProposal> started(1000, &order, AnyModel(kSample));
  ProsacProposal& sampler = started.proposal;
  std::uint32_t sample[kSample];
  std::size_t n = 4;
  for (std::uint64_t draw = 1; draw <= 60000; ++draw) {
    while (draw > last[n]) ++n;
    sampler.draw(sample);
    ASSERT_EQ(sampler.pool(), n);
    // The newest member of the pool, and three of those before it.
    ASSERT_EQ(sample[3], order[n - 1]);
    for (int k = 0; k < 3; ++k) {
      const auto rank = std::find(order.begin(), order.end(), sample[k]) - order.begin();
      ASSERT_LT(rank, std::ptrdiff_t(n) - 1);
    }
  }
}

TEST(ProsacProposal, PrefixesTakeTurnsAfterProsac) {
  const std::vector<std::uint32_t> order = permutation(1000, 3);
  std::vector<std::size_t> rank(1000);
  for (std::size_t i = 0; i < 1000; ++i) rank[order[i]] = i;
  Started<ProsacProposal> started(1000, &order, AnyModel(4, {500, 8}));
  ProsacProposal& sampler = started.proposal;
  std::uint32_t sample[4];
  while (sampler.pool() < 1000) sampler.draw(sample);
  for (int i = 0; i < 100; ++i) sampler.draw(sample);  // the last samples of the pool of all matches
  std::vector<std::size_t> largest(8, 0);
  for (int i = 0; i < 40000; ++i) {
    sampler.draw(sample);
    std::size_t& seen = largest[sampler.drawn() % 8];
    for (const std::uint32_t k : sample) seen = std::max(seen, rank[k] + 1);
  }
  // All matches, the best half, quarter... but 20 at least.
  EXPECT_EQ(largest, (std::vector<std::size_t>{1000, 500, 250, 125, 62, 31, 20, 20}));
  EXPECT_EQ(sampler.pool(), 1000u);
  // With fewer matches than the least prefix, all of them.
  const std::vector<std::uint32_t> few = permutation(10, 3);
  Started<ProsacProposal> small(10, &few, AnyModel(4, {1, 8}));
  std::set<std::uint32_t> drawn;
  for (int i = 0; i < 1000; ++i) {
    small.proposal.draw(sample);
    drawn.insert(sample, sample + 4);
  }
  EXPECT_EQ(drawn.size(), 10u);
}

TEST(ProsacProposal, ProsacEndsUniform) {
  const std::vector<std::uint32_t> order = permutation(30, 3);
  Started<ProsacProposal> started(30, &order, AnyModel(4));
  ProsacProposal& sampler = started.proposal;
  std::uint32_t sample[4];
  std::uint64_t grown = 0;
  while (sampler.pool() < 30) sampler.draw(sample), ++grown;
  EXPECT_LT(grown, 201000u);
  for (int i = 0; i < 201000; ++i) sampler.draw(sample);
  std::vector<int> counts(30, 0);
  for (int i = 0; i < 30000; ++i) {
    sampler.draw(sample);
    for (const std::uint32_t k : sample) ++counts[k];
  }
  for (const int count : counts) EXPECT_NEAR(count, 4000, 300);
}

TEST(UniformProposal, SeedDecides) {
  const auto first = [](std::uint64_t seed) {
    Started<UniformProposal> started(1000, nullptr, AnyModel(7), seed);
    std::vector<std::uint32_t> sample(7);
    started.proposal.draw(sample.data());
    return sample;
  };
  EXPECT_EQ(first(5), first(5));
  EXPECT_NE(first(5), first(6));
}

}  // namespace
}  // namespace corrsel::core
