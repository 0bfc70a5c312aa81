#include "corrsel/evaluation/metrics.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace corrsel::core {
namespace {

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? kUndefined : static_cast<double>(part) / static_cast<double>(whole);
}

/// Harmonic mean. Nothing selected (precision undefined) counts as 0; no inlier (recall undefined) stays
/// undefined.
double harmonicMean(double precision, double recall) {
  if (std::isnan(recall)) return kUndefined;
  if (std::isnan(precision) || precision + recall == 0) return 0.0;
  return 2 * precision * recall / (precision + recall);
}

}  // namespace

Metrics metricsOf(double tau, std::size_t n_correct, std::size_t n_inliers, std::size_t n_selected,
                  std::size_t n_ground_truth) {
  Metrics metrics;
  metrics.tau = tau;
  metrics.n_correct = n_correct;
  metrics.n_inliers = n_inliers;
  metrics.precision = ratio(n_correct, n_selected);
  metrics.recall_paper = ratio(n_correct, n_ground_truth);
  metrics.recall_same_tau = ratio(n_correct, n_inliers);
  metrics.f_paper = harmonicMean(metrics.precision, metrics.recall_paper);
  metrics.f_same_tau = harmonicMean(metrics.precision, metrics.recall_same_tau);
  return metrics;
}

Evaluation evaluate(TruthKind kind, const std::vector<double>& errors, const std::vector<std::uint8_t>& mask,
                    const EvaluationOptions& options) {
  if (errors.size() != mask.size()) {
    throw std::invalid_argument("mask has " + std::to_string(mask.size()) + " elements for " +
                                std::to_string(errors.size()) + " matches");
  }
  Evaluation result;
  const bool labelled = kind == TruthKind::kLabels, evaluated = kind != TruthKind::kNone;
  const double ground_truth_tolerance = labelled ? 0.0 : options.ground_truth_tolerance;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (evaluated && std::isnan(errors[i])) continue;
    ++result.n_putative;
    result.n_ground_truth += errors[i] <= ground_truth_tolerance ? 1 : 0;
    result.n_selected += mask[i] ? 1 : 0;
  }
  const std::vector<double> tolerances = labelled ? std::vector<double>{kUndefined} : options.tolerances;
  for (const double tau : tolerances) {
    if (!evaluated) {
      result.metrics.emplace_back().tau = tau;
      continue;
    }
    const double tolerance = labelled ? 0.0 : tau;
    std::size_t inliers = 0, correct = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (!(errors[i] <= tolerance)) continue;
      ++inliers;
      correct += mask[i] ? 1 : 0;
    }
    result.metrics.push_back(metricsOf(tau, correct, inliers, result.n_selected, result.n_ground_truth));
  }
  return result;
}

}  // namespace corrsel::core
