#include "motion/camera_motion.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "geometry/essential.h"
#include "geometry/fundamental.h"
#include "geometry/known_motion.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinBase = 8;
constexpr double kNearRest = 4, kMaxRest = 1;         // px
constexpr double kPointLimit = 3, kLineLimit = 2;     // px, at least
constexpr double kDeviations = 4;                     // within the noise
constexpr double kRestAccuracy = 0.3, kClearly = 10;  // px; times that
constexpr double kMaxUnexplained = 0.1;               // share of the static matches
constexpr int kPoseSteps = 10, kFundamentalSteps = 3, kReplacingPasses = 3;

/// Median of squared errors; infinity where there is none.
double medianOf(const std::vector<double>& errors, const std::vector<std::uint32_t>& rows) {
  std::vector<double> known;
  for (const std::uint32_t row : rows)
    if (!std::isnan(errors[row])) known.push_back(errors[row]);
  if (known.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

/// The affine map from left points to displacements that fits the given matches best.
bool fitDisplacement(const Correspondences& m, const std::vector<std::uint32_t>& rows, cv::Vec3d& x,
                     cv::Vec3d& y) {
  cv::Matx33d sums = cv::Matx33d::zeros();
  cv::Vec3d of_x, of_y;
  for (const std::uint32_t i : rows) {
    const cv::Vec3d p(m.left_x[i], m.left_y[i], 1);
    sums += p * p.t();
    of_x += (static_cast<double>(m.right_x[i]) - m.left_x[i]) * p;
    of_y += (static_cast<double>(m.right_y[i]) - m.left_y[i]) * p;
  }
  bool solved = false;
  const cv::Matx33d inverse = sums.inv(cv::DECOMP_CHOLESKY, &solved);
  x = inverse * of_x;
  y = inverse * of_y;
  return solved;
}

/// The fundamental matrix with the smallest algebraic error (the eight-point algorithm: Hartley, PAMI 1997),
/// of rank 2 and Frobenius norm 1, in normalised coordinates.
cv::Matx33d eightPoint(const NormalizedMatches& m) {
  Eigen::Matrix<double, 9, 9> sums = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < m.size(); ++i) {
    const double x = m.left_x[i], y = m.left_y[i], u = m.right_x[i], v = m.right_y[i];
    Eigen::Matrix<double, 9, 1> row;
    row << u * x, u * y, u, v * x, v * y, v, x, y, 1;
    sums.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(sums);
  cv::Matx33d f;
  for (int i = 0; i < 9; ++i) f.val[i] = solver.eigenvectors()(i, 0);
  cv::Matx31d w;
  cv::Matx33d u, vt;
  cv::SVD::compute(f, w, u, vt);
  f = u * cv::Matx33d(w(0), 0, 0, 0, w(1), 0, 0, 0, 0) * vt;
  return f * (1 / cv::norm(f));
}

}  // namespace

bool CameraMotion::assign(const Correspondences& matches, const Selection& selection,
                          const std::vector<std::uint8_t>& base) {
  matches_ = &matches;
  pose_.reset();
  base_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i)
    if (base[i] != 0) base_.push_back(i);
  kind_ = base_.size() < kMinBase ? Kind::kNone : findErrors(selection);
  if (kind_ != Kind::kNone) judge();
  return kind_ != Kind::kNone;
}

CameraMotion::Kind CameraMotion::findErrors(const Selection& selection) {
  const bool calibrated = matches_->left_camera && matches_->right_camera;
  const Motion motion = selection.pose && calibrated ? selection.pose->motion : Motion::kNone;
  const bool at_rest = atRest();
  if (at_rest || motion == Motion::kRest) {
    if (!at_rest) still_ = kMaxRest;
    errors_.resize(matches_->size());
    pixelErrors(Residual::kTransfer, cv::Matx33d::eye(), *matches_, errors_.data());
    return Kind::kPoints;
  }
  still_ = kRestAccuracy;
  if (motion == Motion::kRotation) {
    selectionErrors(ModelKind::kRotation, selection.pose->pose.rotation, *matches_, rays_, errors_);
    return Kind::kPoints;
  }
  if (motion != Motion::kNone) {
    pose_ = selection.pose->pose;
    selectionErrors(ModelKind::kEssential, essentialOf(*pose_), *matches_, rays_, errors_);
    poseErrors(*pose_, rays_, errors_);
    if (selection.pose->second) {
      poseErrors(*selection.pose->second, rays_, others_);
      for (std::size_t i = 0; i < errors_.size(); ++i) errors_[i] = std::min(errors_[i], others_[i]);
    }
    return Kind::kEpipolar;
  }
  const bool is_of_rays =
      selection.model_kind == ModelKind::kEssential || selection.model_kind == ModelKind::kRotation;
  if (selection.model_kind == ModelKind::kNone || (is_of_rays && !calibrated)) return Kind::kNone;
  selectionErrors(selection.model_kind, selection.model, *matches_, rays_, errors_);
  if (selection.model_kind == ModelKind::kRotation) return Kind::kPoints;
  if (selection.model_kind != ModelKind::kHomography) return Kind::kEpipolar;
  return selection.scene == SceneKind::kUnknown || selection.scene == SceneKind::kNothing ? Kind::kNone
                                                                                          : Kind::kPlane;
}

bool CameraMotion::atRest() {
  const Correspondences& m = *matches_;
  std::vector<std::uint32_t> near;
  float low_x = std::numeric_limits<float>::max(), low_y = low_x, high_x = -low_x, high_y = -low_x;
  for (const std::uint32_t i : base_) {
    if (std::hypot(m.right_x[i] - m.left_x[i], m.right_y[i] - m.left_y[i]) > kNearRest) continue;
    near.push_back(i);
    low_x = std::min(low_x, m.left_x[i]);
    high_x = std::max(high_x, m.left_x[i]);
    low_y = std::min(low_y, m.left_y[i]);
    high_y = std::max(high_y, m.left_y[i]);
  }
  cv::Vec3d x, y;
  if (2 * near.size() < base_.size() || !fitDisplacement(m, near, x, y)) return false;
  still_ = kRestAccuracy;
  for (const double u : {low_x, high_x}) {
    for (const double v : {low_y, high_y})
      still_ = std::max(still_, std::hypot(x.dot({u, v, 1}), y.dot({u, v, 1})));
  }
  return still_ <= kMaxRest;
}

/// Errors under the essential matrix of a pose, or if it is larger, the distance by which a point lies on the
/// wrong side of that of an infinitely far point.
void CameraMotion::poseErrors(const Pose& pose, const RayMatches& rays, std::vector<double>& errors) const {
  rayErrors(ModelKind::kEssential, essentialOf(pose), rays, errors);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const cv::Vec3d far = pose.rotation * rays.left.direction(i);
    const cv::Vec3d towards = pose.translation - pose.translation.dot(far) * far;
    const double side = towards.dot(rays.right.direction(i) - far) / cv::norm(towards);
    if (!(side < 0)) continue;
    const double distance = side / (rays.left.pixelAngle(i) + rays.right.pixelAngle(i));
    errors[i] = std::max(errors[i], distance * distance);
  }
}

void CameraMotion::judge() {
  // Of a normal variable, and of the length of a vector of two.
  const double deviation = kind_ == Kind::kEpipolar ? 0.6745 : 1.1774;
  const double least = kind_ == Kind::kEpipolar ? kLineLimit : kPointLimit;
  limit_ = std::max(least, kDeviations * std::sqrt(medianOf(errors_, base_)) / deviation);
  beyond_.resize(errors_.size());
  for (std::size_t i = 0; i < errors_.size(); ++i) beyond_[i] = errors_[i] > limit_ * limit_ ? 1 : 0;
}

bool CameraMotion::contradicts(const std::vector<std::uint32_t>& group) {
  if (kind_ == Kind::kPoints && std::sqrt(medianOf(errors_, group)) > std::max(limit_, kClearly * still_))
    return true;
  return !explainedTogether(group);
}

/// Whether a motion of the camera that is fitted to the group and the static matches together explains both.
bool CameraMotion::explainedTogether(const std::vector<std::uint32_t>& group) {
  joint_.clear();
  for (const std::uint32_t i : base_)
    if (beyond_[i] == 0 && !std::binary_search(group.begin(), group.end(), i)) joint_.push_back(i);
  const std::size_t statics = joint_.size();
  joint_.insert(joint_.end(), group.begin(), group.end());
  cv::Matx33d f;
  if (!(pose_ ? jointPoseErrors() : jointFundamental(f))) return true;
  if (!pose_) writeSampson(f, joint_, others_);
  const double limit = std::max(kLineLimit, limit_);
  std::size_t static_beyond = 0, group_beyond = 0;
  for (std::size_t i = 0; i < joint_.size(); ++i)
    (i < statics ? static_beyond : group_beyond) += others_[i] > limit * limit ? 1 : 0;
  return 2 * group_beyond < group.size() &&
         static_cast<double>(static_beyond) < kMaxUnexplained * static_cast<double>(statics);
}

/// Writes the errors of the joint matches under a pose that is fitted to them.
bool CameraMotion::jointPoseErrors() {
  gatherRays(rays_, joint_, joint_rays_);
  Pose pose = *pose_;
  const PoseFreedom freedom = freedomOf(matches_->prior);
  if (freedom.size > 0 && std::isnan(fitPose(joint_rays_, limit_, kPoseSteps, pose, freedom))) return false;
  poseErrors(pose, joint_rays_, others_);
  return true;
}

/// Fits a fundamental matrix to the joint matches.
bool CameraMotion::jointFundamental(cv::Matx33d& f) {
  normalizeMatches(*matches_, joint_, normalized_);
  f = eightPoint(normalized_);
  if (!cv::checkRange(f)) return false;
  for (int step = 0; step < kFundamentalSteps; ++step)
    refineFundamental(normalized_, std::numeric_limits<float>::max(), f);
  f = normalized_.fundamentalToPixels(f);
  return true;
}

void CameraMotion::writeSampson(const cv::Matx33d& f, const std::vector<std::uint32_t>& rows,
                                std::vector<double>& errors) const {
  const Correspondences& m = *matches_;
  errors.clear();
  for (const std::uint32_t i : rows)
    errors.push_back(sampsonError(f, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]));
}

bool CameraMotion::replaceBy(const std::vector<std::uint32_t>& others) {
  if (pose_ || kind_ == Kind::kPoints || others.size() < kMinBase) return false;
  joint_ = others;
  const double squared = limit_ * limit_;
  cv::Matx33d f;
  for (int pass = 0; pass < kReplacingPasses; ++pass) {
    if (!jointFundamental(f)) return false;
    writeSampson(f, others, others_);
    joint_.clear();
    for (std::size_t k = 0; k < others.size(); ++k)
      if (others_[k] <= squared) joint_.push_back(others[k]);
    if (joint_.size() < kMinBase) return false;
  }
  const auto before =
      std::count_if(base_.begin(), base_.end(), [&](std::uint32_t i) { return beyond_[i] == 0; });
  writeSampson(f, base_, others_);
  for (std::size_t k = 0; k < base_.size(); ++k)
    if (others_[k] <= squared) joint_.push_back(base_[k]);
  std::sort(joint_.begin(), joint_.end());
  joint_.erase(std::unique(joint_.begin(), joint_.end()), joint_.end());
  if (joint_.size() <= static_cast<std::size_t>(before)) return false;
  base_ = joint_;
  kind_ = Kind::kEpipolar;
  pixelErrors(Residual::kSampson, f, *matches_, errors_.data());
  judge();
  return true;
}

}  // namespace corrsel::core
