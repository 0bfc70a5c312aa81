#include "database/competing_models.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/text.h"
#include "corrsel/selectors/factory.h"
#include "geometry/essential.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

// A homography gives way to an epipolar relation that keeps this share and this number of matches more,
// because the latter holds for a random match far more often.
constexpr double kMoreShare = 1.05;
constexpr std::size_t kMoreMatches = 8;
// Of the threshold: that of the pose, which is more accurate than the relation that keeps many matches.
constexpr double kPoseThreshold = 0.5;
// Focal lengths hold if the essential matrix keeps this share of the inliers of the fundamental matrix. Under
// true cameras, the latter also fits matches of repeated structure, up to a third of its inliers.
constexpr double kCalibratedShare = 0.5;
// `auto` keeps matches with local support up to this many times the threshold.
constexpr double kSupported = 2;
// Several motions are one relation with a few moving objects where the relation explains this share.
constexpr double kMainMotion = 0.8;

bool keepsMore(std::size_t epipolar, std::size_t homography) {
  return static_cast<double>(epipolar) >= kMoreShare * static_cast<double>(homography) &&
         epipolar >= homography + kMoreMatches;
}

bool arePlain(const Correspondences& matches) {
  return matches.left_camera->isPlainPinhole() && matches.right_camera->isPlainPinhole();
}

/// F = K2^-T E K1^-1, px, with Frobenius norm 1.
cv::Matx33d fundamentalOf(const cv::Matx33d& essential, const Correspondences& matches) {
  const cv::Matx33d f =
      matches.right_camera->matrix.inv().t() * essential * matches.left_camera->matrix.inv();
  return f * (1 / cv::norm(f));
}

void keepRows(const std::vector<std::uint32_t>& rows, Selection& selection) {
  std::fill(selection.mask.begin(), selection.mask.end(), std::uint8_t{0});
  for (const std::uint32_t row : rows) selection.mask[row] = 1;
  selection.n_selected = rows.size();
}

/// Keeps the matches of the main motion only, if they are most. @return whether one motion is left
bool keepMainMotion(Selection& selection) {
  if (selection.model_kind == ModelKind::kNone) return false;
  std::vector<std::uint32_t> main;
  for (std::uint32_t i = 0; i < selection.group.size(); ++i)
    if (selection.group[i] == 0) main.push_back(i);
  if (static_cast<double>(main.size()) < kMainMotion * static_cast<double>(selection.n_selected))
    return false;
  keepRows(main, selection);
  return true;
}

}  // namespace

CompetingModels::CompetingModels(const std::string& selector, const OptionMap& common, double threshold)
    : selector_(createSelector(selector, {}, common)),
      automatic_(createSelector("auto:fast", {}, common)),
      fundamental_(createSelector("auto:fast[model=fundamental]", {}, common)),
      pose_(createSelector("pose[covariance=false;min_confidence=0;max_iterations=300]",
                           {{"threshold", formatNumber(kPoseThreshold * threshold)}}, common)),
      threshold_(threshold) {}

Selection CompetingModels::select(const Correspondences& matches, Workspace& workspace) const {
  Selection selection = selector_->select(matches, workspace);
  addConfidence(matches, selection);
  if (selection.status != Status::kOk || selection.model_kind != ModelKind::kNone ||
      selection.scene == SceneKind::kSeveralMotions)
    return selection;
  const std::vector<std::uint32_t> rows = selectedRows(selection.mask);
  Selection found = automatic_->select(matches.subset(rows), workspace);
  std::vector<std::uint8_t> mask(matches.size(), 0);
  std::vector<float> probability(matches.size(), 0);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    mask[rows[k]] = found.mask[k];
    probability[rows[k]] = found.probability[k];
  }
  found.mask = std::move(mask);
  found.probability = std::move(probability);
  found.score.clear();
  found.group.clear();
  return found;
}

TwoViewGeometry CompetingModels::geometryOf(const Correspondences& matches, const PairCameras* cameras,
                                            Workspace& workspace, Selection& selection) const {
  TwoViewGeometry geometry;
  if ((selection.scene == SceneKind::kSeveralMotions && !keepMainMotion(selection)) ||
      selection.model_kind == ModelKind::kNone) {
    geometry.config = TwoViewConfig::kMultiple;
    return geometry;
  }
  if (selection.model_kind == ModelKind::kHomography) {
    geometry.config = TwoViewConfig::kPlanarOrPanoramic;
    geometry.homography = selection.model;
    Selection found = fundamental_->select(matches, workspace);
    if (found.status == Status::kOk && found.model_kind == ModelKind::kFundamental &&
        keepsMore(found.n_selected, selection.n_selected))
      selection = std::move(found);
  }
  if (selection.model_kind == ModelKind::kFundamental) {
    geometry.config = TwoViewConfig::kUncalibrated;
    geometry.fundamental = selection.model;
  }
  if (cameras != nullptr) addPose(matches, *cameras, workspace, selection, geometry);
  return geometry;
}

/// Finds the pose of the kept matches, and what it tells about the relation.
void CompetingModels::addPose(const Correspondences& matches, const PairCameras& cameras,
                              Workspace& workspace, Selection& selection, TwoViewGeometry& geometry) const {
  Correspondences kept = matches.subset(selectedRows(selection.mask));
  kept.left_camera = cameras.first;
  kept.right_camera = cameras.second;
  const Selection posed = pose_->select(kept, workspace);
  if (posed.status != Status::kOk || !posed.pose) return;
  const PoseResult& found = *posed.pose;
  const bool turned = found.motion == Motion::kRest || found.motion == Motion::kRotation;
  if (!turned && selection.model_kind == ModelKind::kFundamental)
    return takeEssential(kept, found, selection, geometry);
  if (static_cast<double>(posed.n_selected) < kCalibratedShare * static_cast<double>(selection.n_selected))
    return;
  geometry.config = turned ? TwoViewConfig::kPanoramic : TwoViewConfig::kPlanar;
  geometry.fundamental.reset();
  if (!found.second) geometry.pose = found.pose;
}

/// Replaces a fundamental matrix by the essential matrix of the pose, unless the latter keeps too few of its
/// inliers.
/// @param kept  those inliers, in the order of the selection's mask, with cameras
void CompetingModels::takeEssential(const Correspondences& kept, const PoseResult& found,
                                    Selection& selection, TwoViewGeometry& geometry) const {
  const cv::Matx33d essential = essentialOf(found.pose);
  const std::vector<std::uint32_t> rows = selectedRows(selection.mask);
  RayMatches rays;
  std::vector<double> errors, uncalibrated_errors;
  selectionErrors(ModelKind::kEssential, essential, kept, rays, errors);
  selectionErrors(selection.model_kind, selection.model, kept, rays, uncalibrated_errors);
  const double squared = threshold_ * threshold_;
  std::size_t calibrated = 0, uncalibrated = 0;
  std::vector<std::uint32_t> agreeing;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    uncalibrated += uncalibrated_errors[i] <= squared ? 1 : 0;
    if (!isInFront(found.pose, rays, i, threshold_)) continue;
    calibrated += errors[i] <= squared ? 1 : 0;
    if (errors[i] <= kSupported * kSupported * squared) agreeing.push_back(rows[i]);
  }
  if (static_cast<double>(calibrated) < kCalibratedShare * static_cast<double>(uncalibrated)) return;
  keepRows(agreeing, selection);
  geometry.config = TwoViewConfig::kCalibrated;
  geometry.essential = essential;
  geometry.fundamental.reset();
  if (arePlain(kept)) geometry.fundamental = fundamentalOf(essential, kept);
  if (!found.second) geometry.pose = found.pose;
}

}  // namespace corrsel::core
