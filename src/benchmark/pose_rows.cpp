#include "benchmark/pose_rows.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/pose/estimator.h"

namespace corrsel::core {

bool estimatesHomographies(const BenchmarkConfig& config) {
  return std::any_of(config.sections.begin(), config.sections.end(),
                     [](const std::string& section) { return section == "pose" || section == "budget"; });
}

bool estimatesPoses(const BenchmarkConfig& config) {
  return config.sections != std::vector<std::string>{"curves"};
}

bool hasPoseRows(const GroundTruth& truth, const BenchmarkConfig& config) {
  return (truth.pose && estimatesPoses(config)) ||
         (truth.kind == TruthKind::kHomography && estimatesHomographies(config));
}

PoseRow measurePose(const GroundTruth& truth, const cv::Size& left_size, const Correspondences& putative,
                    const Selection& selection) {
  PoseRow row;
  row.status = selection.status;
  if (!row.evaluated()) return row;
  const Correspondences selected = putative.subset(selectedRows(selection.mask));
  row.n_selected = selected.size();
  row.seconds = 0;
  if (truth.pose) {
    std::optional<cv::Matx33d> homography;
    if (selection.model_kind == ModelKind::kHomography) homography = selection.model;
    const Stopwatch watch;
    const PoseEstimate estimate = estimatePose(selected, *truth.pose, homography);
    row.seconds += watch.seconds();
    row.model = estimate.model;
    row.n_inliers = estimate.n_inliers;
    row.pose_error = kFailedPose;
    if (estimate.model != PoseModel::kNone) {
      const PoseErrors errors = poseErrors(estimate.rotation, estimate.translation, *truth.pose);
      row.rotation_error = errors.rotation;
      row.translation_error = errors.translation;
      row.pose_error = errors.pose;
    }
    if (cv::norm(truth.pose->translation) > 0) {
      row.epipolar_precision = epipolarPrecision(epipolarErrors(*truth.pose, selected),
                                                 std::vector<std::uint8_t>(selected.size(), 1));
    }
  }
  if (truth.kind == TruthKind::kHomography && !left_size.empty()) {
    const Stopwatch watch;
    const std::optional<HomographyEstimate> estimate = estimateHomography(selected);
    row.seconds += watch.seconds();
    row.corner_error = estimate ? cornerError(estimate->homography, truth.matrix, left_size)
                                : std::numeric_limits<double>::infinity();
  }
  return row;
}

}  // namespace corrsel::core
