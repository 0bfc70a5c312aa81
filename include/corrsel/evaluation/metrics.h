#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"

namespace corrsel::core {

inline constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

/// Precision, recall and F of one selection at one tolerance, as defined by Zhao et al., arXiv:1904.13383.
/// The two readings of the paper's recall are explained in docs/evaluation.md.
struct Metrics {
  double tau = kUndefined;              ///< tolerance, px; NaN for labelled truth
  std::size_t n_correct = 0;            ///< selected matches with error <= tau
  std::size_t n_inliers = 0;            ///< all matches with error <= tau
  double precision = kUndefined;        ///< correct / selected; NaN: nothing selected
  double recall_paper = kUndefined;     ///< correct(tau) / inliers(t_gt); NaN: no inlier
  double recall_same_tau = kUndefined;  ///< correct(tau) / inliers(tau); NaN: no inlier
  double f_paper = kUndefined;          ///< 0 if nothing correct was selected; NaN: recall undefined
  double f_same_tau = kUndefined;
};

/// The evaluation of one selection on one pair. Matches whose truth is unknown (NaN error) are not counted.
/// Where nothing is known about the pair (TruthKind::kNone), n_putative and n_selected count all matches, and
/// precision, recall and F are undefined.
struct Evaluation {
  std::size_t n_putative = 0;
  std::size_t n_ground_truth = 0;  ///< matches with error <= ground_truth_tolerance
  std::size_t n_selected = 0;
  std::vector<Metrics> metrics;  ///< one per tolerance; a single one for labelled truth
};

/// Precision, recall and F of counts; every field but tau and the counts follows from these.
/// @param n_ground_truth  inliers at the tolerance of the ground truth, Evaluation::n_ground_truth
Metrics metricsOf(double tau, std::size_t n_correct, std::size_t n_inliers, std::size_t n_selected,
                  std::size_t n_ground_truth);

struct EvaluationOptions {
  std::vector<double> tolerances = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};  ///< tau, px
  double ground_truth_tolerance = 10.0;                              ///< t_gt, px
};

/// Evaluates a selection at every tolerance.
/// @param errors  ground-truth errors as returned by groundTruthErrors(), px
/// @param mask    same length as errors; throws std::invalid_argument otherwise
/// O(N * tolerances).
Evaluation evaluate(TruthKind kind, const std::vector<double>& errors, const std::vector<std::uint8_t>& mask,
                    const EvaluationOptions& options = {});

}  // namespace corrsel::core
