#include "consensus/support.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "geometry/residual.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr std::uint32_t kEmpty = 0xFFFFFFFFU;

/// The multiple of the cell that is nearest to a coordinate; never -0.
double rounded(float value, double inverse_cell) { return std::floor(value * inverse_cell + 0.5) + 0.0; }

std::uint64_t bitsOf(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// Mixes the bits of a point (the finalizer of splitmix64).
std::uint64_t hashOf(double x, double y) {
  std::uint64_t hash = bitsOf(x) * 0x9E3779B97F4A7C15U + bitsOf(y);
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9U;
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBU;
  return hash ^ (hash >> 31);
}

/// Numbers the points, equal ones alike, in the order of their first appearance, by a hash table with open
/// addressing.
/// @param sizes  receives the number of points in each group
void numberPoints(const std::vector<float>& x, const std::vector<float>& y, double cell,
                  std::vector<std::uint32_t>& slots, std::vector<std::uint32_t>& groups,
                  std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& sizes) {
  const std::size_t n = x.size();
  const double inverse = 1.0 / cell;
  std::size_t size = 16;
  while (size < 2 * n) size *= 2;
  slots.assign(size, kEmpty);
  groups.resize(n);
  firsts.clear();
  sizes.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const double px = rounded(x[i], inverse), py = rounded(y[i], inverse);
    std::size_t slot = hashOf(px, py) & (size - 1);
    while (slots[slot] != kEmpty) {
      const std::uint32_t first = firsts[slots[slot]];
      if (rounded(x[first], inverse) == px && rounded(y[first], inverse) == py) break;
      slot = (slot + 1) & (size - 1);
    }
    if (slots[slot] == kEmpty) {
      slots[slot] = static_cast<std::uint32_t>(sizes.size());
      firsts.push_back(static_cast<std::uint32_t>(i));
      sizes.push_back(0);
    }
    groups[i] = slots[slot];
    ++sizes[groups[i]];
  }
}

}  // namespace

void DistinctSupport::group(const NormalizedMatches& m, double cell) {
  matches_ = m.size();
  numberPoints(m.left_x, m.left_y, cell, slots_, all_left_, firsts_, left_size_);
  numberPoints(m.right_x, m.right_y, cell, slots_, all_right_, firsts_, right_size_);
  left_points_ = left_size_.size();
  right_points_ = right_size_.size();
  shared_.clear();
  for (auto* column : {&left_x_, &left_y_, &right_x_, &right_y_}) column->clear();
  for (auto* groups : {&left_group_, &right_group_}) groups->clear();
  for (std::uint32_t i = 0; i < matches_; ++i) {
    if (left_size_[all_left_[i]] == 1 && right_size_[all_right_[i]] == 1) continue;
    shared_.push_back(i);
    left_x_.push_back(m.left_x[i]);
    left_y_.push_back(m.left_y[i]);
    right_x_.push_back(m.right_x[i]);
    right_y_.push_back(m.right_y[i]);
    left_group_.push_back(all_left_[i]);
    right_group_.push_back(all_right_[i]);
  }
  errors_.resize(shared_.size());
  best_left_.assign(left_points_, {0, 0});
  best_right_.assign(right_points_, {0, 0});
  stamp_ = 0;
}

const std::vector<float>& DistinctSupport::surplus(Residual residual, const cv::Matx33d& model,
                                                   float squared_threshold) {
  const MatchColumns columns = {left_x_.data(), left_y_.data(), right_x_.data(), right_y_.data(),
                                shared_.size()};
  kernels().residuals.errors[static_cast<std::size_t>(residual)](residualModel(residual, model), columns, 0,
                                                                 columns.size, errors_.data());
  findSurplus(squared_threshold);
  return surplus_;
}

std::size_t DistinctSupport::countInliers(const float* errors, float squared_threshold) {
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < matches_; ++i) inliers += errors[i] <= squared_threshold ? 1 : 0;
  for (std::size_t k = 0; k < shared_.size(); ++k) errors_[k] = errors[shared_[k]];
  findSurplus(squared_threshold);
  return inliers - surplus_.size();
}

void DistinctSupport::findSurplus(float squared_threshold) {
  if (++stamp_ == 0) {  // after 2^32 models
    for (auto* bests : {&best_left_, &best_right_}) std::fill(bests->begin(), bests->end(), Best{0, 0});
    stamp_ = 1;
  }
  surplus_.clear();
  touched_.clear();
  // Keeps the better one of the matches of a group. Returns whether this is the first one.
  const auto enter = [this](Best& best, std::uint32_t k) {
    if (best.stamp != stamp_) {
      best = {stamp_, k};
      return true;
    }
    if (errors_[k] < errors_[best.position]) std::swap(best.position, k);
    surplus_.push_back(errors_[k]);
    return false;
  };
  for (std::uint32_t k = 0; k < shared_.size(); ++k) {
    if (errors_[k] <= squared_threshold && enter(best_right_[right_group_[k]], k))
      touched_.push_back(right_group_[k]);
  }
  for (const std::uint32_t group : touched_) {
    const std::uint32_t k = best_right_[group].position;
    enter(best_left_[left_group_[k]], k);
  }
}

}  // namespace corrsel::core
