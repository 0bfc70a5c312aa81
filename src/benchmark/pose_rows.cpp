#include "benchmark/pose_rows.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/evaluation/pinhole_view.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/pose/estimator.h"

namespace corrsel::core {
namespace {

bool isPixelModel(const Correspondences& matches) {
  return (!matches.left_camera || matches.left_camera->isPlainPinhole()) &&
         (!matches.right_camera || matches.right_camera->isPlainPinhole());
}

/// The pose that the common estimator finds from the selected matches.
void estimateFrom(const Correspondences& selected, const Selection& selection, const RelativePose& truth,
                  PoseRow& row) {
  std::optional<cv::Matx33d> homography;
  if (selection.model_kind == ModelKind::kHomography && isPixelModel(selected)) homography = selection.model;
  const Stopwatch watch;
  const Correspondences seen = throughPinholes(selected, truth);
  const PoseEstimate estimate = estimatePose(seen, truth, homography);
  row.seconds += watch.seconds();
  row.model = estimate.model;
  row.n_inliers = estimate.n_inliers;
  row.pose_error = kFailedPose;
  if (estimate.model != PoseModel::kNone) {
    const PoseErrors errors = poseErrors(estimate.rotation, estimate.translation, truth);
    row.rotation_error = errors.rotation;
    row.translation_error = errors.translation;
    row.pose_error = errors.pose;
  }
  if (cv::norm(truth.translation) > 0) {
    row.epipolar_precision =
        epipolarPrecision(epipolarErrors(truth, seen), std::vector<std::uint8_t>(seen.size(), 1));
  }
}

OwnPose compared(const PoseResult& result, const RelativePose& truth) {
  OwnPose own;
  own.motion = result.motion;
  own.true_motion = trueMotion(truth);
  own.pose_error = kFailedPose;
  own.uncertain = result.uncertain;
  if (result.motion == Motion::kNone) return own;
  const PoseErrors errors = poseErrors(result.pose.rotation, result.pose.translation, truth);
  own.rotation_error = errors.rotation;
  own.translation_error = errors.translation;
  own.pose_error = errors.pose;
  if (result.second) {
    own.second_error = poseErrors(result.second->rotation, result.second->translation, truth).pose;
  }
  own.normalized = normalizedError(result, truth);
  return own;
}

}  // namespace

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
    estimateFrom(selected, selection, *truth.pose, row);
    if (selection.pose) row.own = compared(*selection.pose, *truth.pose);
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
