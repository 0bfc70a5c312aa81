#include "corrsel/selectors/selector.h"

#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

#include "corrsel/stopwatch.h"

namespace corrsel::core {
namespace {

// Beyond this, squared distances lose their pixels in single precision.
constexpr float kLargestCoordinate = 1e6F;

bool usable(float value) { return std::abs(value) <= kLargestCoordinate; }

std::vector<std::uint32_t> usableRows(const Correspondences& matches) {
  std::vector<std::uint32_t> rows;
  rows.reserve(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (usable(matches.left_x[i]) && usable(matches.left_y[i]) && usable(matches.right_x[i]) &&
        usable(matches.right_y[i])) {
      rows.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return rows;
}

bool allUsable(const std::vector<float>& column) {
  // No early exit: the loop is vectorised.
  unsigned unusable = 0;
  for (const float value : column) unusable |= usable(value) ? 0U : 1U;
  return unusable == 0;
}

bool allUsable(const Correspondences& matches) {
  return allUsable(matches.left_x) && allUsable(matches.left_y) && allUsable(matches.right_x) &&
         allUsable(matches.right_y);
}

void fail(Selection& result, std::size_t n, Status status, const std::string& message) {
  result.mask.assign(n, 0);
  result.score.clear();
  result.model_kind = ModelKind::kNone;
  result.status = status;
  result.message = message;
}

/// A plug-in that returns a mask of another length must not take the caller down.
void requireLengths(const Selection& result, std::size_t n) {
  if (result.mask.size() == n && (result.score.empty() || result.score.size() == n)) return;
  throw std::length_error("the selector returned a mask of " + std::to_string(result.mask.size()) + " and " +
                          std::to_string(result.score.size()) + " scores for " + std::to_string(n) +
                          " matches");
}

}  // namespace

std::string Selector::missingInput(const Correspondences&) const { return ""; }

Selection Selector::select(const Correspondences& matches) const {
  const Stopwatch watch;
  const std::size_t n = matches.size();
  Selection result;
  result.mask.assign(n, 0);
  result.n_input = n;
  try {
    const std::string inconsistency = matches.inconsistency();
    const std::string missing = inconsistency.empty() ? missingInput(matches) : inconsistency;
    if (!missing.empty()) {
      fail(result, n, Status::kUnsupportedInput, missing);
    } else if (allUsable(matches)) {
      run(matches, result);
      requireLengths(result, n);
    } else {
      const std::vector<std::uint32_t> rows = usableRows(matches);
      result.n_ignored = n - rows.size();
      Selection inner;
      inner.mask.assign(rows.size(), 0);
      run(matches.subset(rows), inner);
      requireLengths(inner, rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i) result.mask[rows[i]] = inner.mask[i];
      if (!inner.score.empty()) {
        result.score.assign(n, std::numeric_limits<float>::quiet_NaN());
        for (std::size_t i = 0; i < rows.size(); ++i) result.score[rows[i]] = inner.score[i];
      }
      result.model_kind = inner.model_kind;
      result.model = inner.model;
      result.status = inner.status;
      result.message = inner.message;
      result.iterations = inner.iterations;
    }
  } catch (const std::bad_alloc&) {
    fail(result, n, Status::kTooLarge, "out of memory with " + std::to_string(n) + " matches");
  } catch (const std::exception& error) {
    fail(result, n, Status::kFailed, error.what());
  }
  for (const std::uint8_t selected : result.mask) result.n_selected += selected;
  result.seconds = watch.seconds();
  return result;
}

}  // namespace corrsel::core
