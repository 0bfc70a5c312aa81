#include "corrsel/selectors/ransac.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "corrsel/geometry/fundamental.h"
#include "corrsel/geometry/homography.h"
#include "corrsel/random.h"

namespace corrsel::core {
namespace {

/// What the search must know about a homography.
struct HomographyProblem {
  static constexpr int kSampleSize = 4;
  static constexpr ModelKind kKind = ModelKind::kHomography;
  static bool isValidSample(const NormalizedMatches& m, const std::uint32_t* s) {
    return isValidHomographySample(m, s);
  }
  static int solve(const NormalizedMatches& m, const std::uint32_t* s, cv::Matx33d* models) {
    return homographyFromFour(m, s, models[0]) ? 1 : 0;
  }
  static void errors(const cv::Matx33d& model, const NormalizedMatches& m, std::size_t b, std::size_t e,
                     float* out) {
    homographyErrors(model, m, b, e, out);
  }
  static bool fit(const NormalizedMatches& m, const std::vector<std::uint32_t>& rows, cv::Matx33d& model) {
    return fitHomography(m, rows, model);
  }
  static cv::Matx33d toPixels(const NormalizedMatches& m, const cv::Matx33d& h) {
    return m.homographyToPixels(h);
  }
  static double pixelError(const cv::Matx33d& h, double x, double y, double u, double v) {
    return homographyError(h, x, y, u, v);
  }
};

/// What the search must know about a fundamental matrix.
struct FundamentalProblem {
  static constexpr int kSampleSize = 7;
  static constexpr ModelKind kKind = ModelKind::kFundamental;
  static bool isValidSample(const NormalizedMatches& m, const std::uint32_t* s) {
    return isValidFundamentalSample(m, s);
  }
  static int solve(const NormalizedMatches& m, const std::uint32_t* s, cv::Matx33d* models) {
    return fundamentalFromSeven(m, s, models);
  }
  static void errors(const cv::Matx33d& model, const NormalizedMatches& m, std::size_t b, std::size_t e,
                     float* out) {
    sampsonErrors(model, m, b, e, out);
  }
  static bool fit(const NormalizedMatches& m, const std::vector<std::uint32_t>& rows, cv::Matx33d& model) {
    return fitFundamental(m, rows, model);
  }
  static cv::Matx33d toPixels(const NormalizedMatches& m, const cv::Matx33d& f) {
    return m.fundamentalToPixels(f);
  }
  static double pixelError(const cv::Matx33d& f, double x, double y, double u, double v) {
    return sampsonError(f, x, y, u, v);
  }
};

struct Support {
  double cost =
      std::numeric_limits<double>::infinity();  // lower is better: MSAC cost / t^2, or minus the inlier count
  std::size_t inliers = 0;
};

/// Scores a model block by block and gives up once it cannot beat `best` any more.
template <class Problem>
Support support(const cv::Matx33d& model, const NormalizedMatches& m, float squared_threshold, bool msac,
                const Support& best) {
  constexpr std::size_t kBlock = 256;
  float errors[kBlock];
  Support result;
  double cost = 0;
  const std::size_t n = m.size();
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, n);
    Problem::errors(model, m, begin, end, errors);
    std::uint32_t inliers = 0;
    float sum = 0;
    for (std::size_t i = 0; i < end - begin; ++i) {
      const bool inlier = errors[i] <= squared_threshold;
      inliers += inlier ? 1U : 0U;
      sum += inlier ? errors[i] : 0.0F;
    }
    result.inliers += inliers;
    cost += static_cast<double>(sum) / squared_threshold + static_cast<double>(end - begin - inliers);
    const double bound = msac ? cost : -static_cast<double>(result.inliers + (n - end));
    if (bound >= best.cost) return {};
  }
  result.cost = msac ? cost : -static_cast<double>(result.inliers);
  return result;
}

/// Hypotheses after which an all-inlier sample has been drawn with the given confidence: exact, without
/// replacement.
double hypothesesNeeded(std::size_t inliers, std::size_t n, int sample_size, double confidence) {
  double all_inliers = 1;
  for (int k = 0; k < sample_size; ++k) {
    const auto drawn = static_cast<double>(k);
    all_inliers *= std::max(0.0, (static_cast<double>(inliers) - drawn) / (static_cast<double>(n) - drawn));
  }
  if (all_inliers >= 1) return 0;
  if (all_inliers <= 0 || confidence >= 1) return std::numeric_limits<double>::infinity();
  return std::log1p(-confidence) / std::log1p(-all_inliers);
}

template <class Problem>
std::vector<std::uint32_t> inlierRows(const cv::Matx33d& model, const NormalizedMatches& m,
                                      float squared_threshold) {
  std::vector<float> errors(m.size());
  Problem::errors(model, m, 0, m.size(), errors.data());
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i] <= squared_threshold) rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

template <class Problem>
void search(const Correspondences& matches, const RansacOptions& options, Selection& result) {
  constexpr int kSampleSize = Problem::kSampleSize;
  constexpr int kRedraws = 10000;  // as OpenCV: then the data hold no valid sample
  const std::size_t n = matches.size();
  if (n < static_cast<std::size_t>(kSampleSize)) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, a " + toString(Problem::kKind) + " needs " +
                     std::to_string(kSampleSize);
    return;
  }
  const NormalizedMatches m = normalizeMatches(matches);
  const auto squared_threshold = static_cast<float>(std::pow(options.threshold * m.scale, 2));
  const bool msac = options.score == "msac";
  Random random(static_cast<std::uint64_t>(options.seed));
  Support best;
  cv::Matx33d best_model;
  double needed = options.max_iterations;
  std::uint32_t sample[kSampleSize];
  cv::Matx33d models[3];
  for (; result.iterations < options.max_iterations && result.iterations < needed; ++result.iterations) {
    int draws = 0;
    do {
      random.sample(static_cast<std::uint32_t>(n), kSampleSize, sample);
    } while (!Problem::isValidSample(m, sample) && ++draws < kRedraws);
    if (draws == kRedraws) break;
    const int count = Problem::solve(m, sample, models);
    for (int k = 0; k < count; ++k) {
      const Support candidate = support<Problem>(models[k], m, squared_threshold, msac, best);
      if (!(candidate.cost < best.cost)) continue;
      best = candidate;
      best_model = models[k];
      needed = hypothesesNeeded(best.inliers, n, kSampleSize, options.confidence);
    }
  }
  if (std::isinf(best.cost)) {
    result.status = result.iterations < options.max_iterations ? Status::kDegenerate : Status::kNoModel;
    result.message = result.iterations < options.max_iterations
                         ? "no valid sample: the matches are collinear, equal or differently oriented"
                         : "no hypothesis could be fitted";
    return;
  }
  for (int round = 0; options.refine && round < 4; ++round) {
    cv::Matx33d refined;
    if (!Problem::fit(m, inlierRows<Problem>(best_model, m, squared_threshold), refined)) break;
    const Support candidate = support<Problem>(refined, m, squared_threshold, msac, best);
    if (!(candidate.cost < best.cost)) break;
    best = candidate;
    best_model = refined;
  }

  result.model = Problem::toPixels(m, best_model);
  result.model_kind = Problem::kKind;
  result.score.resize(n);
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double error = Problem::pixelError(result.model, matches.left_x[i], matches.left_y[i],
                                             matches.right_x[i], matches.right_y[i]);
    result.score[i] = static_cast<float>(-error);
    result.mask[i] = error <= options.threshold * options.threshold ? 1 : 0;
    inliers += result.mask[i];
  }
  if (inliers <= static_cast<std::size_t>(kSampleSize)) {
    std::fill(result.mask.begin(), result.mask.end(), std::uint8_t{0});
    result.status = Status::kDegenerate;
    result.message = "no more than the sample itself agrees with the best model: unverified";
  }
}

}  // namespace

void RansacOptions::visit(OptionVisitor& visitor) {
  visitor.choice("model", {"homography", "fundamental"}, "Model to fit", model);
  visitor.number({"threshold", 0.01, 1000, "px",
                  "Inlier threshold: transfer error (homography), Sampson distance (fundamental)"},
                 threshold);
  visitor.integer({"max_iterations", 1, 10000000, "-", "Hypotheses at most"}, max_iterations);
  visitor.number(
      {"confidence", 0, 1, "-", "Probability of an all-inlier sample at which the search stops; 1 = never"},
      confidence);
  visitor.choice("score", {"msac", "inlier_count"},
                 "Sum of truncated squared errors (msac) or number of inliers", score);
  visitor.flag("refine", "Least squares on the inliers of the best hypothesis", refine);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the sampler"}, seed);
}

RansacSelector::RansacSelector(RansacOptions options) : options_(std::move(options)) { options_.check(); }

Presets RansacSelector::presets() {
  return {{"h", {{"model", "homography"}}}, {"f", {{"model", "fundamental"}}}};
}

void RansacSelector::run(const Correspondences& matches, Selection& result) const {
  if (options_.model == "homography") {
    search<HomographyProblem>(matches, options_, result);
  } else {
    search<FundamentalProblem>(matches, options_, result);
  }
}

}  // namespace corrsel::core
