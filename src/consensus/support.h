#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/normalization.h"

namespace corrsel::core {

/// Counts every image point at most once in the support of a model.
///
/// Idea: a wrong model can gather many matches by sending many left points to a few right ones, for example a
/// homography that squeezes the image into a point. Such a model has few distinct inliers: at most one match
/// per left point and one per right point counts, the one with the smallest error.
///
/// Algorithm: points are equal if they are equal after rounding to multiples of `cell`. Of all matches within
/// the threshold that share a right point, the one with the smallest error remains; of the remaining ones
/// that share a left point, again the one with the smallest error. The first of equal errors wins. The
/// matches that remain are one-to-one; their number is a lower bound of the largest one-to-one subset.
/// Only matches that share a point with another match are visited.
///
/// Cost: O(N) time and memory for group(), O(shared matches) for each model, without allocation.
///
/// Source: the distinctness of inliers in VSAC (Ivashechkin, Barath and Matas, ICCV 2021) is the same idea
/// with a distance in place of the rounding.
class DistinctSupport {
 public:
  /// Finds the matches that share a point. Forgets the matches of the previous call and keeps the memory.
  /// @param cell  in the unit of the coordinates; positive
  void group(const NormalizedMatches& matches, double cell);

  /// The matches that share their left or right point with another match, ascending.
  const std::vector<std::uint32_t>& shared() const { return shared_; }

  /// Number of different left and right points.
  std::size_t leftPoints() const { return left_points_; }
  std::size_t rightPoints() const { return right_points_; }

  /// Finds the matches within the threshold of a model that do not count, because a match with the same left
  /// or right point counts in their place.
  /// @param model  in the coordinates that were given to group()
  /// @return their squared errors, in no particular order; valid until the next call
  const std::vector<float>& surplus(Residual residual, const cv::Matx33d& model, float squared_threshold);

  /// Number of distinct matches within the threshold. O(N).
  /// @param errors  squared errors of all matches
  std::size_t countInliers(const float* errors, float squared_threshold);

 private:
  /// The match with the smallest error among those of a group seen since the stamp, as position in shared_.
  struct Best {
    std::uint32_t stamp, position;
  };

  void findSurplus(float squared_threshold);

  std::vector<std::uint32_t> shared_;
  std::vector<float> left_x_, left_y_, right_x_, right_y_, errors_;  // of the matches in shared_
  std::vector<std::uint32_t> left_group_, right_group_;              // the same
  std::vector<Best> best_left_, best_right_;                         // by group
  std::vector<std::uint32_t> touched_;  // right groups with a match within the threshold
  std::vector<float> surplus_;
  // Memory of group().
  std::vector<std::uint32_t> slots_, firsts_, all_left_, all_right_, left_size_, right_size_;
  std::size_t matches_ = 0, left_points_ = 0, right_points_ = 0;
  std::uint32_t stamp_ = 0;
};

}  // namespace corrsel::core
