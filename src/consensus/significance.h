#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/neighbours.h"

namespace corrsel::core {

/// The evidence for a model or for a set of selected matches.
struct Significance {
  double confidence = 0;  ///< -log10 of the expected number of such agreements by chance, at least 0, decades
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
/// Idea: If the right points had nothing to do with the left ones, how many hypotheses among those that were
/// tried would find at least so many matches that agree with them so closely? The confidence is the negated
/// decimal logarithm of this expected number of false alarms. All models are compared with the same
/// background, so the confidences of different models and selectors can be compared.
///
/// Algorithm: For every threshold t of 1, 1.5, 2, 3, 4, 5, 7 and 10 px, k(t) is the number of agreeing
/// matches at distinct places, and
///   log10 NFA = log10(8 m T) + min over t of log10 P(Bin(n - s, alpha(t)) >= k(t) - s)
/// with n matches, samples of s matches that give at most m models each, T = max(10^4, hypotheses), and
/// alpha(t), the probability that a match agrees by chance. Only one match counts at each place of either
/// image, the one with the smallest error.
///
/// Input: The coordinates of the matches. The image sizes are used where they are known, otherwise the
/// extents of the points.
///
/// Failure: The confidence is 0 if nothing agrees, if a model is degenerate, and if there are fewer matches
/// than a sample needs.
///
/// Cost: assign() O(N); homography() and fundamental() O(N + k log k), local() O(N log N). The memory is
/// kept.
///
/// Source: Moisan and Stival, IJCV 2004, with the number of hypotheses that were tried in place of that of
/// all samples.
class SignificanceTest {
 public:
  /// Copies the matches, in the order of their coordinates, so that no result depends on the order of the
  /// input.
  /// @pre finite coordinates
  void assign(const Correspondences& matches);

  /// @param left_to_right  in pixels
  /// @param hypotheses     number of models that were tried before this one was chosen
  Significance homography(const cv::Matx33d& left_to_right, std::uint64_t hypotheses);

  /// @param fundamental  x'^T F x = 0, in pixels
  /// @param hypotheses   number of samples from which models were computed before this one was chosen
  Significance fundamental(const cv::Matx33d& fundamental, std::uint64_t hypotheses);

  /// Evidence for selected matches without a model: each half of the matches is predicted from the selected
  /// ones of the other half.
  /// @param mask  as long as the matches given to assign(), not 0 for selected ones
  Significance local(const std::vector<std::uint8_t>& mask);

 private:
  struct Candidate {
    std::uint32_t key;  // sort key of the squared error
    std::uint32_t match;
  };

  /// Accepted points of one image, found by their cell.
  class Places {
   public:
    static constexpr std::uint32_t kNone = 0xffffffffU;

    /// Removes all points and makes room for `most`.
    void clear(std::size_t most);
    /// The number of an accepted point nearer than the radius of a place, or kNone.
    std::uint32_t find(float x, float y) const;
    bool isTaken(float x, float y) const { return find(x, y) != kNone; }
    void add(float x, float y);

   private:
    struct Point {
      float x, y;
      std::int32_t cell_x, cell_y;
      std::uint32_t next;
    };
    std::size_t slot(std::int32_t cell_x, std::int32_t cell_y) const;
    std::vector<std::uint32_t> first_;  // by hashed cell: first point, counted from 1
    std::vector<Point> points_;
  };

  /// Number of right points in squares of the image, from a summed-area table.
  class Density {
   public:
    void build(const std::vector<float>& x, const std::vector<float>& y, double left, double top,
               double width, double height);
    /// Points per px^2 in the square around (x, y), without the point (own_x, own_y) itself.
    double others(double x, double y, double own_x, double own_y) const;

   private:
    double left_ = 0, top_ = 0, cell_ = 1;
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> sums_;
  };

  void addCandidate(double squared_error, std::size_t match);
  void countDistinct();
  Significance judge(std::size_t trials, std::size_t sample_size, double log10_tests,
                     const double* chance) const;

  double right_area_ = 1;                                   // px^2
  std::vector<KeyedRow> order_, scratch_;                   // rows by coordinates
  std::vector<float> left_x_, left_y_, right_x_, right_y_;  // in this order
  std::vector<Candidate> candidates_;                       // matches with an error of at most 10 px
  std::size_t counts_[8] = {};                              // distinct agreements by threshold
  Density density_;
  Places left_places_, right_places_;
  std::vector<std::uint32_t> members_, nearest_;
  std::vector<std::uint8_t> half_, half_of_place_;
  PlanarNeighbours neighbours_;
};

/// The confidence of a selection, by the same definition for every selector: that of its model if it has one,
/// otherwise that of the mask; 0 if nothing is selected.
/// A selector passes the matches that it was given (finite coordinates only), the selection with mask,
/// model_kind and model filled in, and the number of hypotheses among which it chose its model; selectors
/// without a model pass 0. The memory belongs to the calling thread's workspace.
double confidenceOf(const Correspondences& matches, const Selection& selection, std::uint64_t hypotheses);

}  // namespace corrsel::core
