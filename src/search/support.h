#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/normalization.h"
#include "points/shared_points.h"

namespace corrsel::core {

/// Counts every image point at most once in the support of a model.
///
/// Idea: a bad model can gather many matches by sending many left points to a few right ones, for example a
/// homography that squeezes the image into a point. Such a model has few distinct inliers: at most one match
/// per left point and one per right point counts, the one with the smallest error.
///
/// Algorithm: points are equal if they are equal after rounding to multiples of `cell`. Of all matches within
/// the threshold that share a right point, the one with the smallest error remains; of the remaining ones
/// that share a left point, again the one with the smallest error. The matches that remain are one-to-one;
/// their number is a lower bound of the largest one-to-one subset. Errors are compared with the resolution of
/// the MSAC score. Only matches that share a point with another match are visited.
///
/// Cost: O(N) time and memory for group(), O(shared matches) for each model, without allocation.
///
/// Source: the independent inliers of VSAC (Ivashechkin, Barath and Matas, ICCV 2021) are the same idea with
/// a distance in place of the rounding.
class DistinctSupport {
 public:
  /// Inliers that do not count, because a match with the same left or right point counts in their place.
  struct Surplus {
    std::size_t inliers;  ///< their number
    std::int64_t saved;   ///< what they would save in the MSAC score, in units of ScoreRule::kOutlierCost
  };

  /// Finds the matches that share a point. Forgets the matches of the previous call and keeps the memory.
  /// @param cell  in the unit of the coordinates; positive
  void group(const NormalizedMatches& matches, double cell);

  /// The matches that share their left or right point with another match, in the order of their right points.
  const std::vector<std::uint32_t>& shared() const { return shared_; }

  /// Number of distinct matches if all matches were inliers.
  std::size_t distinctMatches() const { return distinct_; }

  /// Marks the matches both of whose points occur for the first time among the marked ones. O(N).
  /// @param order  all matches
  /// @param first  receives 1 or 0 for each match
  void markFirst(const std::vector<std::uint32_t>& order, std::vector<std::uint8_t>& first);

  /// The inliers of a model that do not count.
  /// @param model  in the coordinates that were given to group()
  Surplus surplus(Residual residual, const cv::Matx33d& model, float squared_threshold);

  /// Number of distinct matches within the threshold. O(N).
  /// @param errors  squared errors of all matches
  std::size_t countInliers(const float* errors, float squared_threshold);

 private:
  /// Writes shared_.
  void sortShared();

  Surplus findSurplus(float squared_threshold);

  std::vector<std::uint32_t> shared_;
  std::vector<float> left_x_, left_y_, right_x_, right_y_, errors_;  // of the matches in shared_
  std::vector<std::uint32_t> left_group_;                            // the same
  std::vector<std::int32_t> values_;                                 // the same
  std::vector<std::uint32_t> ends_;                                  // of each right point in shared_
  std::vector<std::int32_t> best_;                                   // by left_group_: the largest value
  std::size_t matches_ = 0, distinct_ = 0;
  SharedPoints left_, right_;
  // Memory of group().
  std::vector<std::uint32_t> begins_, unsorted_;
  // Memory of markFirst().
  std::vector<std::uint32_t> ordered_;
  std::vector<std::uint8_t> left_seen_, right_seen_;
};

}  // namespace corrsel::core
