#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"
#include "corrsel/image_pair.h"

namespace corrsel::core {

/// How many matches agree with the ground truth of a pair as it was given, and how many with another reading
/// of it, such as the inverse of its homography. One row of truth_check.csv.
struct TruthCheck {
  PairId id;
  std::string features;  ///< that the matches were made of
  TruthKind kind = TruthKind::kNone;
  std::string reading;                          ///< "inverse", "transpose"..., see docs/evaluation.md
  double tolerance = OtherReading().tolerance;  ///< px
  std::size_t n_putative = 0;
  std::size_t n_truth = 0, n_reading = 0;  ///< matches within the tolerance
  std::size_t n_truth_by_chance = 0,
              n_reading_by_chance = 0;  ///< the same after the right points are shuffled
};

/// Counts the matches that agree with the ground truth of a pair and with other readings of it:
/// - homography: its inverse, its transpose, the transpose of its inverse, the matrix of coordinates in the
///   order (row, column), and the matrix of coordinates divided by the sizes of the images;
/// - fundamental matrix: its transpose, (row, column), and divided coordinates;
/// - essential matrix: its transpose; rotation: its inverse;
/// - disparity: the opposite sign, the disparity of the right image, and the unit 1/16 or 1/256 px;
/// - the readings that the source of the pair adds (ImagePair::other_readings).
/// Labels, and pairs without ground truth, have no other reading. id and features of the rows are empty.
/// O(N * readings), and for disparities O(pixels * readings).
std::vector<TruthCheck> checkTruth(const GroundTruth& truth, const std::vector<OtherReading>& other_readings,
                                   const Correspondences& matches);

/// A sequence, or a pair of it, whose ground truth is probably not what it was given as.
struct TruthWarning {
  PairId id;              ///< without a pair: the sums over all pairs of the sequence
  std::size_t pairs = 0;  ///< that were counted
  TruthCheck counts;      ///< of the reading that explains the most matches

  /// A sentence with both counts and the probable mistake.
  std::string text() const;
};

/// Compares the readings, sequence by sequence. A reading is reported if it explains far more of the matches
/// of the sequence than the ground truth as given. Both counts are first reduced by what chance gives, which
/// is small for homographies, but not for fundamental matrices. With E the reduced count of the reading and T
/// that of the truth, the conditions are E >= 2 T and E - T >= 5 standard deviations, where the variance of
/// the difference is at most the sum of the four counts, as for independent Poisson counts. Hence, at least
/// 25 matches are necessary. Where the sequence as a whole is in order, its pairs are examined one by one.
/// @param checks  rows of checkTruth() with their ids, in any order
/// O(rows log rows).
std::vector<TruthWarning> truthWarnings(const std::vector<TruthCheck>& checks);

}  // namespace corrsel::core
