#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/image_pair.h"
#include "corrsel/pose/estimator.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The folder of a run cannot be used. The text names the file (and the line), the reason and the remedy.
class RunFolderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One row of pairs.csv: one selection. The file has the counts at every tolerance, and the measures are
/// computed from them. An undefined number is NaN here and empty in the file.
struct ResultRow {
  PairId id;
  std::string features, preselection, selector;
  TruthKind truth = TruthKind::kNone;
  std::size_t n_left = 0, n_right = 0;
  std::size_t n_putative = 0, n_ground_truth = 0, n_selected = 0;
  std::vector<Metrics> metrics;  ///< one per tolerance; a single one for labelled truth
  Status status = Status::kOk;
  SceneKind scene = SceneKind::kUnknown;  ///< Selection::scene
  double confidence = kUndefined;         ///< Selection::confidence
  int seed = 0;
  double detect_seconds = kUndefined, describe_seconds = kUndefined, match_seconds = kUndefined;
  double select_seconds = kUndefined;

  /// Returns whether the selector returned a selection that can be evaluated.
  bool evaluated() const { return status != Status::kUnsupportedInput && status != Status::kFailed; }

  /// The metrics at a tolerance, those of labelled truth at any; nullptr: there are none at this one.
  const Metrics* metricsAt(double tau) const;
};

/// Name of the row of poses.csv whose selection is all ground-truth inliers.
inline constexpr char kGroundTruthSelection[] = "ground_truth";

/// The pose that a calibrated selector gave with its selection, compared with the true one.
struct OwnPose {
  Motion motion = Motion::kNone;                                       ///< the verdict
  Motion true_motion = Motion::kNone;                                  ///< see trueMotion()
  double rotation_error = kUndefined, translation_error = kUndefined;  ///< degrees, see PoseErrors
  double pose_error = kUndefined;    ///< degrees; kFailedPose where the verdict is kNone
  double second_error = kUndefined;  ///< pose error of PoseResult::second, degrees
  NormalizedError normalized;        ///< see normalizedError()
  bool uncertain = false;            ///< PoseResult::uncertain
};

/// One row of poses.csv: what the selected matches of a pair are good for. Undefined numbers are NaN here and
/// empty in the file.
struct PoseRow {
  PairId id;
  std::string features, preselection, selector;  ///< selector: a specification, or kGroundTruthSelection
  int seed = 0;
  Status status = Status::kOk;  ///< of the selection
  std::size_t n_selected = 0;
  PoseModel model = PoseModel::kNone;                                  ///< that the pose was computed from
  std::size_t n_inliers = 0;                                           ///< of the pose
  double rotation_error = kUndefined, translation_error = kUndefined;  ///< degrees, see PoseErrors
  double pose_error = kUndefined;          ///< degrees; kFailedPose without a pose; NaN: the truth is unknown
  double epipolar_precision = kUndefined;  ///< NaN: no true translation
  double corner_error = kUndefined;        ///< px; +Inf without a homography; NaN: the truth is none
  double seconds = kUndefined;             ///< time of the estimators, s
  std::optional<OwnPose> own;              ///< of selectors that give a pose, where the true one is known

  /// Returns whether there is a selection to estimate from, see ResultRow::evaluated().
  bool evaluated() const { return status != Status::kUnsupportedInput && status != Status::kFailed; }
};

/// The normalised errors of some poses, see NormalizedError.
struct ConsistencySummary {
  std::size_t poses = 0;
  double mean = kUndefined, median = kUndefined;  ///< of NormalizedError::squared
  double inside = kUndefined;                     ///< share of NormalizedError::inside()
};

/// Measures of the poses that a selector gives itself.
struct OwnPoseSummary {
  std::size_t poses = 0, no_pose = 0;  ///< pairs with a verdict; selections with the verdict kNone
  double auc_5 = kUndefined, auc_10 = kUndefined, auc_20 = kUndefined;
  double auc_10_low = kUndefined, auc_10_high = kUndefined;
  double rotation_median = kUndefined, translation_median = kUndefined, pose_median = kUndefined;
  std::size_t uncertain = 0;  ///< poses without a covariance, because none would hold
  /// Poses with a translation; those of planes with a second pose are left out, because their covariance is
  /// that of the pose that was named first.
  ConsistencySummary with_translation;
  ConsistencySummary rotations;  ///< of cameras that only turned
};

/// One row of pose_summary.csv: measures over the pairs with a known pose or homography.
struct PoseSummaryRow {
  std::string dataset, features, preselection, selector;
  std::size_t poses = 0, no_pose = 0;  ///< pairs with a known pose; estimates without a result
  double auc_5 = kUndefined, auc_10 = kUndefined, auc_20 = kUndefined;  ///< errorAuc() of the pose errors
  double auc_10_low = kUndefined, auc_10_high = kUndefined;             ///< 95 % interval, see bootstrapAuc()
  double accuracy = kUndefined;                                         ///< mean of thresholdAccuracy()
  double rotation_median = kUndefined, translation_median = kUndefined;  ///< degrees, of the poses found
  double pose_median = kUndefined;                                       ///< degrees
  double epipolar_precision = kUndefined;                                ///< mean
  std::size_t homographies = 0, no_homography = 0;                       ///< pairs with a known homography
  double corner_auc_1 = kUndefined, corner_auc_3 = kUndefined, corner_auc_5 = kUndefined;
  double corner_auc_3_low = kUndefined, corner_auc_3_high = kUndefined;
  double corner_median = kUndefined;   ///< px
  double seconds_median = kUndefined;  ///< of the estimators, s
  OwnPoseSummary own;
};

/// One row of summary.csv: means over pairs of the per-pair values.
struct SummaryRow {
  std::string dataset, features, preselection, selector;
  double tau = kUndefined;  ///< px; NaN for labelled truth
  std::size_t pairs = 0;    ///< pairs in the means: evaluated pairs that have a ground-truth inlier
  double precision = kUndefined, recall_paper = kUndefined, f_paper = kUndefined;
  double f_low = kUndefined, f_high = kUndefined;  ///< 95 % interval of the mean F, see bootstrapMean()
  double recall_same_tau = kUndefined, f_same_tau = kUndefined;
  double confidence_median = kUndefined;
  double select_median = kUndefined, select_p95 = kUndefined;  ///< s
};

/// Reads the rows of a run folder that is not being written to. Every row is checked: it is complete and
/// appears once, its numbers are in their ranges, and no part exceeds its whole. Throws RunFolderError naming
/// the file, the line, the fault and the remedy; also for a folder that another version wrote in another
/// format. O(rows log rows).
std::vector<ResultRow> readResults(const std::string& folder);

/// The same of poses.csv; none where the folder has no such file, as those of versions without poses.
std::vector<PoseRow> readPoses(const std::string& folder);

/// Groups rows by dataset, features, preselection, selector and tolerance, in the order of first appearance.
/// The repetitions of a pair are averaged before the mean over pairs. O(rows log rows + groups * 2000 *
/// pairs).
std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows);

/// Groups rows by dataset, features, preselection and selector, in the order of first appearance. Rows that
/// are not evaluated are left out. The repetitions of a pair count like further pairs; the intervals are
/// resampled over pairs. O(rows log rows + groups * 2000 * pairs).
std::vector<PoseSummaryRow> summarizePoses(const std::vector<PoseRow>& rows);

}  // namespace corrsel::core
