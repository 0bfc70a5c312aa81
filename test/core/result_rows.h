#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "corrsel/benchmark/results.h"

namespace corrsel::core::testing {

/// The rows of a pair: two selections (gms, keep_all), evaluated at 5 and 10 px. Precision, recall and F are
/// all `f`, to a sixtieth.
inline std::vector<ResultRow> rowsOf(const std::string& pair, double f = 0.5) {
  std::vector<ResultRow> rows;
  for (const char* selector : {"gms", "keep_all"}) {
    ResultRow row;
    row.id = {"set", "scene, \"one\"", pair};
    row.features = "orb+orb";
    row.preselection = "none";
    row.selector = selector;
    row.truth = TruthKind::kHomography;
    row.n_putative = 100;
    row.n_ground_truth = row.n_selected = 60;
    const auto correct = static_cast<std::size_t>(std::lround(60 * f));
    for (const double tau : {5.0, 10.0}) row.metrics.push_back(metricsOf(tau, correct, 60, 60, 60));
    row.confidence = 0;
    row.select_seconds = 0.001;
    rows.push_back(row);
  }
  return rows;
}

/// The rows of the same pair in poses.csv: the two selections and the ground-truth inliers.
inline std::vector<PoseRow> posesOf(const std::string& pair, double rotation_error = 2) {
  std::vector<PoseRow> rows;
  for (const char* selector : {"gms", "keep_all", kGroundTruthSelection}) {
    PoseRow row;
    row.id = {"set", "scene, \"one\"", pair};
    row.features = "orb+orb";
    row.preselection = "none";
    row.selector = selector;
    row.n_selected = 40;
    row.model = PoseModel::kEssential;
    row.n_inliers = 30;
    row.rotation_error = rotation_error;
    row.translation_error = rotation_error / 2;
    row.pose_error = rotation_error;
    row.epipolar_precision = 0.5;
    row.seconds = 0.01;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace corrsel::core::testing
