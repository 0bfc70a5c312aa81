#include "search/support.h"

#include <algorithm>

#include "base/gather.h"
#include "geometry/residual.h"
#include "kernels/kernels.h"

namespace corrsel::core {

void DistinctSupport::group(const NormalizedMatches& m, double cell) {
  matches_ = m.size();
  left_.find(m.left_x, m.left_y, cell);
  right_.find(m.right_x, m.right_y, cell);
  sortShared();
  gather(m.left_x, shared_, left_x_);
  gather(m.left_y, shared_, left_y_);
  gather(m.right_x, shared_, right_x_);
  gather(m.right_y, shared_, right_y_);
  const auto shared = static_cast<std::uint32_t>(shared_.size());
  left_group_.resize(shared);
  values_.resize(shared);
  ends_.clear();
  std::uint32_t left_points = left_.numbers();
  for (std::uint32_t k = 0; k < shared; ++k) {
    const std::uint32_t left = left_.of[shared_[k]], right = right_.of[shared_[k]];
    left_group_[k] = left != 0 ? left : left_points++;
    if (right == 0 || k + 1 == shared || right_.of[shared_[k + 1]] != right) ends_.push_back(k + 1);
  }
  best_.resize(left_points);
  errors_.assign(shared, 0.0F);
  distinct_ = matches_ - findSurplus(1.0F).inliers;
}

void DistinctSupport::sortShared() {
  unsorted_.resize(matches_);
  std::size_t shared = 0;
  for (std::uint32_t i = 0; i < matches_; ++i) {
    unsorted_[shared] = i;
    shared += (left_.of[i] | right_.of[i]) != 0 ? 1 : 0;
  }
  unsorted_.resize(shared);
  // A counting sort.
  begins_.assign(right_.numbers() + 1, 0);
  for (const std::uint32_t i : unsorted_) ++begins_[right_.of[i] + 1];
  for (std::size_t g = 1; g < begins_.size(); ++g) begins_[g] += begins_[g - 1];
  shared_.resize(shared);
  for (const std::uint32_t i : unsorted_) shared_[begins_[right_.of[i]]++] = i;
}

void DistinctSupport::markFirst(const std::vector<std::uint32_t>& order, std::vector<std::uint8_t>& first) {
  constexpr std::uint8_t kUndecided = 2;
  first.assign(matches_, 1);
  for (const std::uint32_t i : shared_) first[i] = kUndecided;
  ordered_.resize(matches_);
  std::size_t undecided = 0;
  for (const std::uint32_t i : order) {
    ordered_[undecided] = i;
    undecided += first[i] == kUndecided ? 1 : 0;
  }
  left_seen_.assign(left_.numbers(), 0);
  right_seen_.assign(right_.numbers(), 0);
  for (std::size_t k = 0; k < undecided; ++k) {
    const std::uint32_t i = ordered_[k], left = left_.of[i], right = right_.of[i];
    first[i] = (left_seen_[left] | right_seen_[right]) == 0 ? 1 : 0;
    // Points that are alone have the number 0, which is never seen.
    if (first[i] != 0) {
      left_seen_[left] = left != 0 ? 1 : 0;
      right_seen_[right] = right != 0 ? 1 : 0;
    }
  }
}

DistinctSupport::Surplus DistinctSupport::surplus(Residual residual, const cv::Matx33d& model,
                                                  float squared_threshold) {
  const MatchColumns columns = {left_x_.data(), left_y_.data(), right_x_.data(), right_y_.data(),
                                shared_.size()};
  kernels().residuals.errors[static_cast<std::size_t>(residual)](residualModel(residual, model), columns, 0,
                                                                 columns.size, errors_.data());
  return findSurplus(squared_threshold);
}

std::size_t DistinctSupport::countInliers(const float* errors, float squared_threshold) {
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < matches_; ++i) inliers += errors[i] <= squared_threshold ? 1 : 0;
  for (std::size_t k = 0; k < shared_.size(); ++k) errors_[k] = errors[shared_[k]];
  return inliers - findSurplus(squared_threshold).inliers;
}

DistinctSupport::Surplus DistinctSupport::findSurplus(float squared_threshold) {
  // An inlier's value is what it saves in MSAC, plus one to tell the worst inlier from an outlier. There are
  // no branches on it, since nobody can predict which matches are inliers.
  const float scale = static_cast<float>(ScoreRule::kOutlierCost) / squared_threshold;
  const std::size_t n = values_.size();
  const float* const errors = errors_.data();
  std::int32_t* const values = values_.data();
  for (std::size_t k = 0; k < n; ++k) {
    const float error = errors[k] < squared_threshold ? errors[k] : squared_threshold;
    const std::int32_t value = ScoreRule::kOutlierCost + 1 - static_cast<std::int32_t>(error * scale);
    values[k] = value & -static_cast<std::int32_t>(errors[k] <= squared_threshold);
  }
  std::int64_t saved = 0;
  std::int32_t inliers = 0;
  for (std::size_t k = 0; k < n; ++k) {
    saved += values[k];
    inliers += static_cast<std::int32_t>(values[k] > 0);
  }
  std::fill(best_.begin(), best_.end(), 0);
  std::int32_t* const best = best_.data();
  const std::uint32_t* const left = left_group_.data();
  std::uint32_t k = 0;
  for (const std::uint32_t end : ends_) {
    std::int32_t value = values[k];
    std::uint32_t group = left[k];
    for (++k; k < end; ++k) {
      group = values[k] > value ? left[k] : group;
      value = std::max(value, values[k]);
    }
    best[group] = std::max(best[group], value);
  }
  for (const std::int32_t value : best_) {
    saved -= value;
    inliers -= static_cast<std::int32_t>(value > 0);
  }
  return {static_cast<std::size_t>(inliers), saved - inliers};
}

}  // namespace corrsel::core
