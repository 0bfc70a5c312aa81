#include "corrsel/selectors/selector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "base/spread_selection.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/usable_rows.h"
#include "posterior/posterior.h"
#include "search/significance.h"

namespace corrsel::core {
namespace {

bool allUsable(const std::vector<float>& column) {
  // No early exit: the loop is vectorised.
  unsigned unusable = 0;
  for (const float value : column) unusable |= isUsable(value) ? 0U : 1U;
  return unusable == 0;
}

bool allUsable(const Correspondences& matches) {
  return allUsable(matches.left_x) && allUsable(matches.left_y) && allUsable(matches.right_x) &&
         allUsable(matches.right_y);
}

void fail(Selection& result, std::size_t n, Status status, const std::string& message) {
  result.mask.assign(n, 0);
  result.score.clear();
  result.group.clear();
  result.model_kind = ModelKind::kNone;
  result.scene = SceneKind::kUnknown;
  result.confidence = std::numeric_limits<double>::quiet_NaN();
  result.sigma = std::numeric_limits<double>::quiet_NaN();
  result.probability.clear();
  result.pose.reset();
  result.n_ignored = 0;
  result.status = status;
  result.message = message;
}

/// Throws where the result makes no sense. The algorithm may come from another package, and an invalid result
/// must not crash the caller.
void requireSense(const Selection& result, std::size_t n) {
  if (result.mask.size() != n || (!result.score.empty() && result.score.size() != n)) {
    throw std::length_error("the selector returned a mask of " + std::to_string(result.mask.size()) +
                            " and " + std::to_string(result.score.size()) + " scores for " +
                            std::to_string(n) + " matches");
  }
  if (result.n_ignored > n) {
    throw std::length_error("the selector ignored " + std::to_string(result.n_ignored) + " of " +
                            std::to_string(n) + " matches");
  }
  if (!result.group.empty() && result.group.size() != n) {
    throw std::length_error("the selector returned " + std::to_string(result.group.size()) +
                            " group numbers for " + std::to_string(n) + " matches");
  }
  for (std::size_t i = 0; i < result.group.size(); ++i) {
    if (result.group[i] < -1 || (result.group[i] >= 0 && result.mask[i] == 0)) {
      throw std::domain_error("the selector returned the group number " + std::to_string(result.group[i]) +
                              " for a match with mask " + std::to_string(result.mask[i]) +
                              "; allowed are numbers from 0 for selected matches, and -1");
    }
  }
  const auto wrong = std::find_if(result.mask.begin(), result.mask.end(),
                                  [](std::uint8_t selected) { return selected > 1; });
  if (wrong != result.mask.end()) {
    throw std::domain_error("the selector returned a mask that holds " + std::to_string(*wrong) +
                            "; allowed are 0 and 1");
  }
  if (result.status > Status::kUncertain || result.model_kind > ModelKind::kRotation) {
    throw std::domain_error("the selector returned a status or a kind of model that does not exist: " +
                            std::to_string(static_cast<int>(result.status)) + ", " +
                            std::to_string(static_cast<int>(result.model_kind)));
  }
  if (result.model_kind != ModelKind::kNone && !cv::checkRange(result.model)) {
    throw std::domain_error("the selector returned a model that is not finite");
  }
  if (result.scene > SceneKind::kSeveralMotions) {
    throw std::domain_error("the selector returned a scene that does not exist: " +
                            std::to_string(static_cast<int>(result.scene)));
  }
  if (result.confidence < 0 || std::isinf(result.confidence)) {
    throw std::domain_error("the selector returned a confidence of " + formatNumber(result.confidence) +
                            "; allowed are finite numbers from 0, and NaN where it is not computed");
  }
  if (result.sigma < 0 || std::isinf(result.sigma)) {
    throw std::domain_error("the selector returned a sigma of " + formatNumber(result.sigma) +
                            "; allowed are finite numbers from 0, and NaN where it is not computed");
  }
  if (!result.probability.empty() && result.probability.size() != n) {
    throw std::length_error("the selector returned " + std::to_string(result.probability.size()) +
                            " probabilities for " + std::to_string(n) + " matches");
  }
  for (const float probability : result.probability) {
    if (!(probability >= 0 && probability <= 1)) {
      throw std::domain_error("the selector returned the probability " + std::to_string(probability) +
                              "; allowed are 0 to 1");
    }
  }
}

/// Whether the selection is a result for these matches.
bool isResultOf(const Correspondences& matches, const Selection& selection) {
  const bool fits = selection.mask.size() == matches.size() && matches.inconsistency().empty();
  return fits && selection.status != Status::kFailed && selection.status != Status::kUnsupportedInput;
}

/// What confidence and probability depend on, for some of the matches.
Selection restricted(const Selection& selection, const std::vector<std::uint32_t>& rows) {
  Selection result;
  for (const std::uint32_t row : rows) result.mask.push_back(selection.mask[row]);
  result.model_kind = selection.model_kind;
  result.model = selection.model;
  result.iterations = selection.iterations;
  result.confidence = selection.confidence;
  return result;
}

/// @pre finite coordinates
double confidenceIn(const Correspondences& matches, const Selection& selection, Workspace& workspace) {
  const bool modelled = selection.model_kind != ModelKind::kNone && selection.iterations > 0;
  return confidenceOf(matches, selection, modelled ? static_cast<std::uint64_t>(selection.iterations) : 0,
                      workspace);
}

/// Replaces the status `ok` of an answer with less confidence than the user asks for.
/// @pre finite coordinates
void requireConfidence(const Correspondences& matches, Selection& result, double min_confidence,
                       Workspace& workspace) {
  if (result.status != Status::kOk || min_confidence <= 0) return;
  if (std::isnan(result.confidence)) result.confidence = confidenceIn(matches, result, workspace);
  if (result.confidence >= min_confidence) return;
  result.status = Status::kUncertain;
  const std::string reason = "the confidence is " + formatNumber(std::floor(result.confidence * 10) / 10) +
                             ", below min_confidence = " + formatNumber(min_confidence);
  result.message = result.message.empty() ? reason : reason + "; " + result.message;
}

}  // namespace

void addConfidence(const Correspondences& matches, Selection& selection) {
  if (!std::isnan(selection.confidence) || !isResultOf(matches, selection)) return;
  if (allUsable(matches)) {
    selection.confidence = confidenceIn(matches, selection, Workspace::ofThread());
    return;
  }
  const std::vector<std::uint32_t> rows = usableRows(matches);
  selection.confidence =
      confidenceIn(matches.subset(rows), restricted(selection, rows), Workspace::ofThread());
}

void addProbability(const Correspondences& matches, Selection& selection) {
  if (!selection.probability.empty() || !isResultOf(matches, selection)) return;
  addConfidence(matches, selection);
  if (allUsable(matches)) {
    computePosterior(matches, selection, Workspace::ofThread());
    return;
  }
  const std::vector<std::uint32_t> rows = usableRows(matches);
  Selection inner = restricted(selection, rows);
  computePosterior(matches.subset(rows), inner, Workspace::ofThread());
  selection.sigma = inner.sigma;
  selection.probability = spread(inner.probability, rows, matches.size(), 0.0F);
}

void Selector::configure(const OptionMap& options) {
  if (options.empty()) return;
  throw std::invalid_argument("takes no options, but was given " + options.begin()->first +
                              "; a selector with options overrides configure()");
}

std::string Selector::missingInput(const Correspondences&) const { return ""; }

Selection Selector::select(const Correspondences& matches) const {
  return select(matches, Workspace::ofThread());
}

Selection Selector::select(const Correspondences& matches, Workspace& workspace) const {
  const Stopwatch watch;
  const std::size_t n = matches.size();
  Selection result;
  result.mask.assign(n, 0);
  std::size_t n_ignored = 0;
  try {
    const std::string inconsistency = matches.inconsistency();
    const std::string missing = inconsistency.empty() ? missingInput(matches) : inconsistency;
    if (!missing.empty()) {
      fail(result, n, Status::kUnsupportedInput, missing);
    } else if (allUsable(matches)) {
      run(matches, workspace, result);
      requireSense(result, n);
      requireConfidence(matches, result, minConfidence(), workspace);
    } else {
      const std::vector<std::uint32_t> rows = usableRows(matches);
      n_ignored = n - rows.size();
      Selection inner;
      inner.mask.assign(rows.size(), 0);
      const Correspondences kept = matches.subset(rows);
      run(kept, workspace, inner);
      requireSense(inner, rows.size());
      requireConfidence(kept, inner, minConfidence(), workspace);
      result = spreadSelection(std::move(inner), rows, n);
    }
  } catch (const std::bad_alloc&) {
    fail(result, n, Status::kTooLarge, "out of memory with " + std::to_string(n) + " matches");
  } catch (const std::exception& error) {
    fail(result, n, Status::kFailed, error.what());
  } catch (...) {
    fail(result, n, Status::kFailed, "the selector threw something that is not a std::exception");
  }
  result.n_input = n;
  result.n_ignored += n_ignored;  // run() counts those without a ray
  result.n_selected = static_cast<std::size_t>(std::count(result.mask.begin(), result.mask.end(), 1));
  result.seconds = watch.seconds();
  return result;
}

}  // namespace corrsel::core
