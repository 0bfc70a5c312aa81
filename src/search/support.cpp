#include "search/support.h"

#include <algorithm>

#include "geometry/residual.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr std::uint32_t kEmpty = 0xFFFFFFFFU;

}  // namespace

void DistinctSupport::group(const NormalizedMatches& m, double cell) {
  matches_ = m.size();
  left_.number(m.left_x, m.left_y, cell);
  right_.number(m.right_x, m.right_y, cell);
  // The shared matches in the order of their right points: a counting sort.
  begins_.assign(right_.sizes.size() + 1, 0);
  unsorted_.clear();
  for (std::uint32_t i = 0; i < matches_; ++i) {
    if (left_.sizes[left_.of[i]] == 1 && right_.sizes[right_.of[i]] == 1) continue;
    ++begins_[right_.of[i] + 1];
    unsorted_.push_back(i);
  }
  for (std::size_t g = 1; g < begins_.size(); ++g) begins_[g] += begins_[g - 1];
  const auto shared = static_cast<std::uint32_t>(unsorted_.size());
  shared_.resize(shared);
  for (const std::uint32_t i : unsorted_) shared_[begins_[right_.of[i]]++] = i;
  for (auto* column : {&left_x_, &left_y_, &right_x_, &right_y_, &errors_}) column->resize(shared);
  left_group_.resize(shared);
  values_.resize(shared);
  ends_.clear();
  // Left points get numbers of their own, since only some of them occur.
  std::fill(left_.sizes.begin(), left_.sizes.end(), kEmpty);
  std::uint32_t left_points = 0;
  for (std::uint32_t k = 0; k < shared; ++k) {
    const std::uint32_t i = shared_[k];
    left_x_[k] = m.left_x[i];
    left_y_[k] = m.left_y[i];
    right_x_[k] = m.right_x[i];
    right_y_[k] = m.right_y[i];
    std::uint32_t& number = left_.sizes[left_.of[i]];
    if (number == kEmpty) number = left_points++;
    left_group_[k] = number;
    if (k + 1 == shared || right_.of[shared_[k + 1]] != right_.of[i]) ends_.push_back(k + 1);
  }
  best_.resize(left_points);
  std::fill(errors_.begin(), errors_.end(), 0.0F);
  distinct_ = matches_ - findSurplus(1.0F).inliers;
}

void DistinctSupport::markFirst(const std::vector<std::uint32_t>& order, std::vector<std::uint8_t>& first) {
  constexpr std::uint8_t kLeft = 1, kRight = 2, kUndecided = 2;
  first.assign(matches_, 1);
  for (const std::uint32_t i : shared_) first[i] = kUndecided;
  seen_.assign(matches_, 0);  // by group; there are at most as many groups as matches
  for (const std::uint32_t i : order) {
    if (first[i] != kUndecided) continue;
    first[i] = 0;
    std::uint8_t &left = seen_[left_.of[i]], &right = seen_[right_.of[i]];
    if ((left & kLeft) != 0 || (right & kRight) != 0) continue;
    left |= kLeft;
    right |= kRight;
    first[i] = 1;
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
