#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"
#include "geometry/normalization.h"
#include "points/cell_grid.h"
#include "points/length_unit.h"
#include "points/place_index.h"

namespace corrsel::core {

/// Confidence from which a model is taken for real, where a search or a choice depends on it, decades. Of the
/// homographies of unrelated images none reaches it (docs/studies/confidence.md).
inline constexpr double kSignificantConfidence = 4;

inline bool isSignificant(double confidence) { return confidence >= kSignificantConfidence; }

/// The evidence for a model or for a set of selected matches.
struct Significance {
  double confidence = 0;  ///< -log10 of the probability of such an agreement by chance, at least 0, decades
  double threshold = 0;   ///< error at which the agreement is the most significant, px
  std::size_t agreements = 0;  ///< matches at distinct places whose error is at most the threshold
};

/// log10 of the probability that a binomial variable with n trials of probability p is at least k.
/// The largest term is multiplied by the sum of the geometric series that bounds the others, so the result is
/// at most some hundredths too large; it is 0 where k is at most the mean. O(1).
/// @pre 0 <= p <= 1
double log10BinomialTail(std::size_t n, std::size_t k, double p);

/// Tests whether the matches agree with a model, or with each other, more often than chance explains.
///
/// Idea: Suppose that the right points have nothing to do with the left ones. How many of the hypotheses that
/// were tried would then find so many matches that agree with them so closely? This expected number of false
/// alarms (NFA) is computed in the same way for homographies, fundamental matrices and masks, so the
/// confidences of all selectors can be compared.
///
/// Algorithm: Matches count by rising error. A match counts if no match that counts already lies within
/// 8 units of the image (length_unit.h; fundamental matrix: 2) of it, neither in the left nor in the right.
/// k(t) is the number of these with an error of at most t = 1, 1.5, 2, 3, 4, 5, 7 or 10 px, and
///   NFA = 8 m T * min over t of P(Bin(n - s, a(t)) >= k(t) - s),   confidence = -log10(1 - exp(-NFA))
/// for n matches, samples of s matches that give at most m models each, and T = max(10^4, hypotheses). The
/// confidence is -log10 NFA where this is more than 1. a(t) is the mean over the matches of the probability
/// that a match agrees by chance:
/// - homography (s = 4, m = 1): The error is the smaller one of the two transfer errors. Its probability is
///   pi t^2 d max(1, |det J|) with the Jacobian J of the homography. d is the share of right points per px^2
///   in the square of 40 units around the predicted point, or that of evenly spread points if this is larger.
///   The match's own right point is left out.
/// - fundamental matrix (s = 7, m = 3): The error is the Sampson distance. Its probability is the share of
///   re-paired matches (the left point of one match, the right point of another) with an error of at most t,
///   or the share within a larger threshold, scaled by the ratio of the thresholds, or 2 t / sqrt(area of the
///   right image), whichever is largest.
/// - essential matrix (s = 5, m = 10): as a fundamental matrix, with the tangent Sampson error of rays.
/// - rotation (s = 2, m = 1): as a homography. The error is the angle between the rotated left ray and the
/// right
///   one over the root mean square of their pixel angles; |det J| is the squared ratio of these angles.
/// - mask (s = 0, m T = 1): The places of the selected matches in the left image are divided into two
///   halves at random. Each match of one half is predicted by the affine map that fits the 6 nearest places
///   of the other half best. The error is the distance from the prediction, and its probability is that of a
///   homography with |det J| = 1. Matches that are not selected agree with nothing; half of them count among
///   the n. The worse one of the two directions decides.
///
/// Input: The coordinates of the matches. The image sizes are used where they are known, otherwise the
/// extents of the points.
///
/// Failure: The confidence is 0 if no more matches agree than a sample has, if a model is degenerate, and if
/// fewer than 6 places are selected in one of the halves.
///
/// Cost: For 2000 matches 0.02 ms for assign(), 0.06 to 0.16 ms for homography(), 0.07 to 0.11 ms for
/// fundamental() and 0.02 to 0.3 ms for local(), with 10 to 90 % inliers (AMD EPYC of family 26). All are O(N
/// log N). The memory is kept.
///
/// Source: Moisan and Stival, IJCV 2004, with the number of hypotheses that were tried in place of that of
/// all samples, and a background that is not uniform.
class SignificanceTest {
 public:
  /// Copies the matches, in the order of their coordinates, so that no result depends on the order of the
  /// input.
  /// @pre coordinates of at most 10^6 px
  void assign(const Correspondences& matches);

  /// @param left_to_right  in pixels
  /// @param hypotheses     number of models that were tried before this one was chosen
  Significance homography(const cv::Matx33d& left_to_right, std::uint64_t hypotheses);

  /// @param fundamental  x'^T F x = 0, in pixels
  /// @param hypotheses   number of samples from which models were computed before this one was chosen
  Significance fundamental(const cv::Matx33d& fundamental, std::uint64_t hypotheses);

  /// @param essential    d'^T E d = 0, of rays
  /// @param hypotheses   as for fundamental()
  /// @pre the matches have both cameras; those without a ray agree with nothing
  Significance essential(const cv::Matx33d& essential, std::uint64_t hypotheses);

  /// @param rotation     d' = R d, of rays
  /// @param hypotheses   as for homography()
  /// @pre as for essential()
  Significance rotation(const cv::Matx33d& rotation, std::uint64_t hypotheses);

  /// Evidence for selected matches without a model.
  /// @param mask  as long as the matches given to assign(), not 0 for selected ones
  Significance local(const std::vector<std::uint8_t>& mask);

 private:
  /// Number of right points in squares of the image, from a summed-area table.
  class Density {
   public:
    /// @param area  of the image, px
    /// @param unit  of its lengths, px
    void build(const std::vector<float>& x, const std::vector<float>& y, const cv::Rect2d& area, double unit);
    /// Points per px^2 in the square around (x, y), without the point (own_x, own_y) itself.
    double others(double x, double y, double own_x, double own_y) const;

   private:
    double radius_ = 0;  // px
    CellGrid grid_;
    std::vector<std::uint32_t> sums_;
  };

  void gatherSelected(const std::vector<std::uint8_t>& mask);
  void drawHalves();
  bool predict(std::uint32_t match, const std::uint32_t* predictors, double& x, double& y) const;
  void addCandidate(double squared_error, std::size_t match);
  void addChance(double x, double y, std::uint32_t match, double area, double* chance) const;
  void countDistinct(double place_radius);
  const RayMatches& rays();
  Significance evaluateLines(double (&repaired)[8], std::size_t drawn, std::size_t sample_size,
                             std::size_t max_models, std::uint64_t hypotheses);
  Significance evaluate(std::size_t trials, std::size_t sample_size, double log10_tests,
                        const double* chance) const;

  double right_area_ = 1;  // px^2
  LengthUnits units_;
  std::vector<KeyedRow> order_, scratch_;                   // rows by coordinates
  std::vector<float> left_x_, left_y_, right_x_, right_y_;  // in this order
  std::vector<KeyedRow> candidates_;                        // matches by squared error, at most 10 px
  std::size_t counts_[8] = {};                              // distinct agreements by threshold
  Density density_;
  std::optional<Camera> left_camera_, right_camera_;
  RayMatches rays_;
  RayColumns shuffled_;  // the rays in random order
  std::vector<std::uint32_t> rows_;
  std::vector<float> errors_;
  std::vector<double> squared_errors_;
  std::vector<float> repaired_x_, repaired_y_;  // right points of other matches
  PlaceIndex left_places_, right_places_;
  std::vector<std::uint32_t> selected_;  // selected matches, and their left points
  std::vector<float> selected_x_, selected_y_;
  std::vector<std::uint32_t> predictors_[2], predicted_, nearest_;  // positions in selected_
  std::vector<std::uint8_t> half_, half_of_place_;
  PlanarNeighbours neighbours_;
};

/// Returns the confidence of a selection, by the same definition for every selector: that of the model if
/// there is one, otherwise that of the mask, and 0 if nothing is selected.
///
/// A selector calls this once, when the mask, model_kind and model of the selection are final.
/// @param matches     all matches that the selector was given, not only the selected ones. Their coordinates
///                    are finite.
/// @param hypotheses  number of samples among whose models the model was chosen. Searches on parts of the
///                    matches and models that were given up early count, too. Ignored without a model.
double confidenceOf(const Correspondences& matches, const Selection& selection, std::uint64_t hypotheses,
                    Workspace& workspace);

}  // namespace corrsel::core
