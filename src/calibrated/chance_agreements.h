#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/pose_result.h"
#include "geometry/normalization.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// Finds out which matches may agree with a pose by chance.
///
/// Idea: the right points of outliers are anywhere, so an outlier that agrees by chance mostly has a large
/// displacement, and with it 5 to 20 times the leverage of an inlier. Few of them spoil the pose, and its
/// covariance even more.
///
/// Algorithm: the displacement of a match is the angle between R d and d'. Matches are re-paired: the left
/// ray of one with the right ray of another, 16 N times, but at most 20000 times. For a match that agrees,
///   e = (outliers / re-paired matches) * (re-paired ones that agree, lie in front and have a
///       displacement within a factor of 1.5 of the match's),
///   o = agreeing matches with such a displacement.
/// e outliers are expected among the o, so that the match is right with a probability of about 1 - e / o. It
/// does not count if e >= 0.02 and o - 1 < 3 e. The number of outliers that count is that of the re-paired
/// matches that would, times the first factor of e.
///
/// Cost: O(N), 0.1 ms for 2000 matches. Nothing depends on the order of the input, if the matches are in
/// random order.
///
/// Source: own work.
class ChanceAgreements {
 public:
  /// Re-pairs the matches.
  /// @param matches    in random order, and the same in single precision
  /// @param agreeing   rows of the matches that agree and lie in front
  /// @param outliers   number of matches that could have been among them and do not agree
  /// @param threshold  within which a match agrees, px
  void measure(const Pose& pose, const RayMatches& matches, const RayColumns& columns,
               const std::vector<std::uint32_t>& agreeing, std::size_t outliers, double threshold);

  /// Forgets the measurement: all matches count, and none is expected to agree by chance.
  void clear();

  /// Whether the match agrees not merely by chance. @param match  a row
  bool counts(const Pose& pose, const RayMatches& matches, std::uint32_t match) const;

  /// Number of outliers that are expected among the agreeing matches that count.
  double expectedAmongCounting() const { return expected_; }

  /// Share of the re-paired matches that agree and lie in front.
  double share() const { return share_; }

 private:
  struct Expected {
    double outliers, agreeing;
    bool counts() const;
  };
  Expected expectedAt(double squared_displacement) const;

  std::vector<float> errors_;
  std::vector<double> repaired_, agreeing_;  // squared displacements, ascending
  double per_repaired_ = 0, share_ = 0, expected_ = 0;
};

}  // namespace corrsel::core
