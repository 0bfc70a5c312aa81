#include "corrsel/pose/estimator.h"

#include <Eigen/Core>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>
#include <vector>

#include "geometry/cross_matrix.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

constexpr int kMaxRefinements = 10;
constexpr double kClearlyBetter = 0.99;  // the same optimum, found from two sides, differs by rounding

/// A match in normalised coordinates, (x, y, 1).
struct RayPair {
  cv::Vec3d left, right;
};

struct CountedPose {
  cv::Matx33d rotation = cv::Matx33d::eye();
  cv::Vec3d translation;
  std::size_t n_inliers = 0;
};

std::vector<RayPair> normalised(const Correspondences& matches, const RelativePose& cameras) {
  const cv::Matx33d left = cameras.left_camera.inv(), right = cameras.right_camera.inv();
  std::vector<RayPair> rays;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const RayPair match = {left * cv::Vec3d(matches.left_x[i], matches.left_y[i], 1),
                           right * cv::Vec3d(matches.right_x[i], matches.right_y[i], 1)};
    if (std::isfinite(cv::norm(match.left)) && std::isfinite(cv::norm(match.right))) rays.push_back(match);
  }
  return rays;
}

/// Signed Sampson distance; 0 where all lines vanish.
double sampsonDistance(const cv::Matx33d& essential, const RayPair& match) {
  const cv::Vec3d right_line = essential * match.left, left_line = essential.t() * match.right;
  const double square = right_line[0] * right_line[0] + right_line[1] * right_line[1] +
                        left_line[0] * left_line[0] + left_line[1] * left_line[1];
  return square > 0 ? match.right.dot(right_line) / std::sqrt(square) : 0.0;
}

/// Whether the rays meet in front of both cameras. The depths z, z' are those for which z R x + t is nearest
/// to z' x'; both are multiplied by their determinant here, which is positive.
bool inFrontOfBoth(const CountedPose& pose, const RayPair& match) {
  const cv::Vec3d a = pose.rotation * match.left, &b = match.right, &t = pose.translation;
  return a.dot(b) * b.dot(t) > a.dot(t) * b.dot(b) && a.dot(a) * b.dot(t) > a.dot(b) * a.dot(t);
}

/// The distance of the right point from where a camera that only turned would have it; +Inf behind the
/// camera.
double turnedDistance(const cv::Matx33d& rotation, const RayPair& match) {
  return std::sqrt(homographyError(rotation, match.left[0], match.left[1], match.right[0], match.right[1]));
}

std::vector<std::uint8_t> inliersOf(const CountedPose& pose, const std::vector<RayPair>& matches,
                                    double threshold) {
  const bool turned = cv::norm(pose.translation) == 0;
  const cv::Matx33d essential = crossMatrix(pose.translation) * pose.rotation;
  std::vector<std::uint8_t> mask;
  for (const RayPair& match : matches) {
    mask.push_back(turned ? turnedDistance(pose.rotation, match) <= threshold
                          : std::abs(sampsonDistance(essential, match)) <= threshold &&
                                inFrontOfBoth(pose, match));
  }
  return mask;
}

void countInliers(const std::vector<RayPair>& matches, double threshold, CountedPose& pose) {
  pose.n_inliers = selectedRows(inliersOf(pose, matches, threshold)).size();
}

/// Rotations about a fixed axis of the length of their angle, and two directions across the translation.
class Deviation {
 public:
  explicit Deviation(const CountedPose& pose) : pose_(pose) {
    // The coordinate axis that is farthest from the translation.
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (std::abs(pose.translation[i]) < std::abs(pose.translation[axis])) axis = i;
    }
    cv::Vec3d other;
    other[axis] = 1;
    first_ = cv::normalize(pose.translation.cross(other));
    second_ = pose.translation.cross(first_);
  }

  CountedPose at(const Eigen::VectorXd& x) const {
    CountedPose moved;
    cv::Matx33d turn;
    cv::Rodrigues(cv::Vec3d(x[0], x[1], x[2]), turn);
    moved.rotation = turn * pose_.rotation;
    moved.translation = cv::normalize(pose_.translation + x[3] * first_ + x[4] * second_);
    return moved;
  }

 private:
  CountedPose pose_;
  cv::Vec3d first_, second_;
};

/// The residuals of Eigen's Levenberg-Marquardt method, which asks for these names.
struct SampsonResiduals {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Deviation& deviation;
  const std::vector<RayPair>& matches;

  int inputs() const { return 5; }
  int values() const { return static_cast<int>(matches.size()); }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& distances) const {
    const CountedPose pose = deviation.at(x);
    const cv::Matx33d essential = crossMatrix(pose.translation) * pose.rotation;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      distances[static_cast<Eigen::Index>(i)] = sampsonDistance(essential, matches[i]);
    }
    return 0;
  }
};

std::vector<RayPair> inlierRays(const CountedPose& pose, const std::vector<RayPair>& matches,
                                double threshold) {
  std::vector<RayPair> inliers;
  for (const std::uint32_t row : selectedRows(inliersOf(pose, matches, threshold))) {
    inliers.push_back(matches[row]);
  }
  return inliers;
}

/// Sum of the squared Sampson distances of the inliers.
double inlierCost(const CountedPose& pose, const std::vector<RayPair>& matches, double threshold) {
  const cv::Matx33d essential = crossMatrix(pose.translation) * pose.rotation;
  double cost = 0;
  for (const RayPair& match : inlierRays(pose, matches, threshold)) {
    const double distance = sampsonDistance(essential, match);
    cost += distance * distance;
  }
  return cost;
}

/// Minimises the Sampson distances of the inliers, and counts the inliers again.
/// @return whether the pose has more inliers now; it stays where it would lose some
bool refineOnce(const std::vector<RayPair>& matches, double threshold, CountedPose& pose) {
  const std::vector<RayPair> inliers = inlierRays(pose, matches, threshold);
  const Deviation deviation(pose);
  const SampsonResiduals residuals{deviation, inliers};
  Eigen::NumericalDiff<SampsonResiduals> differences(residuals);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<SampsonResiduals>> method(differences);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(residuals.inputs());
  method.minimize(x);
  if (!x.allFinite()) return false;
  CountedPose refined = deviation.at(x);
  countInliers(matches, threshold, refined);
  const bool more = refined.n_inliers > pose.n_inliers;
  if (refined.n_inliers >= pose.n_inliers) pose = refined;
  return more;
}

/// Repeats the refinement while it finds more inliers: those of five matches fit these five too well.
void refine(const std::vector<RayPair>& matches, double threshold, CountedPose& pose) {
  if (pose.n_inliers < kPoseMatches || cv::norm(pose.translation) == 0) return;
  for (int round = 0; round < kMaxRefinements; ++round) {
    if (!refineOnce(matches, threshold, pose)) return;
  }
}

/// Whether a pose of as many inliers as the best one explains them clearly better.
bool explainsBetter(const CountedPose& pose, const CountedPose& best, const std::vector<RayPair>& matches,
                    double threshold) {
  // Where a rotation explains the matches as well, they do not tell a direction of translation.
  if (cv::norm(best.translation) == 0) return false;
  return inlierCost(pose, matches, threshold) < kClearlyBetter * inlierCost(best, matches, threshold);
}

/// Replaces the best pose where the candidate has more inliers. Candidates that are not numbers have none.
void keepBetter(const std::vector<RayPair>& matches, double threshold, CountedPose candidate,
                CountedPose& best) {
  countInliers(matches, threshold, candidate);
  if (candidate.n_inliers > best.n_inliers) best = candidate;
}

CountedPose poseOfEssential(const std::vector<RayPair>& matches, double threshold) {
  cv::Mat left(static_cast<int>(matches.size()), 2, CV_64F), right = left.clone();
  for (int i = 0; i < left.rows; ++i) {
    const RayPair& match = matches[static_cast<std::size_t>(i)];
    for (int k = 0; k < 2; ++k) {
      left.at<double>(i, k) = match.left[k];
      right.at<double>(i, k) = match.right[k];
    }
  }
  const cv::Mat found =
      cv::findEssentialMat(left, right, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, kPoseConfidence, threshold);
  CountedPose best;
  // Five matches have up to ten solutions, one below the other.
  for (int row = 0; row + 3 <= found.rows; row += 3) {
    const cv::Matx33d essential = found.rowRange(row, row + 3);
    cv::Matx33d first, second;
    cv::Vec3d t;
    cv::decomposeEssentialMat(essential, first, second, t);
    for (const cv::Matx33d& rotation : {first, second}) {
      for (const double sign : {1.0, -1.0}) {
        keepBetter(matches, threshold, {rotation, t * sign, 0}, best);
      }
    }
  }
  return best;
}

/// @param homography  in normalised coordinates
CountedPose poseOfHomography(const cv::Matx33d& homography, const std::vector<RayPair>& matches,
                             double threshold) {
  // The decomposition needs the sign for which the points lie in front of the cameras.
  std::size_t behind = 0;
  for (const RayPair& match : matches) {
    if (match.right.dot(homography * match.left) < 0) ++behind;
  }
  const double sign = 2 * behind > matches.size() ? -1 : 1;
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(homography * sign, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  CountedPose best;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const cv::Vec3d t(translations[i].ptr<double>());
    const double length = cv::norm(t);
    keepBetter(matches, threshold, {cv::Matx33d(rotations[i].ptr<double>()), length > 0 ? t / length : t, 0},
               best);
  }
  return best;
}

}  // namespace

std::string toString(PoseModel model) {
  switch (model) {
    case PoseModel::kEssential:
      return "essential";
    case PoseModel::kHomography:
      return "homography";
    case PoseModel::kNone:
      break;
  }
  return "none";
}

PoseModel poseModelFromString(const std::string& text) {
  for (const PoseModel model : {PoseModel::kNone, PoseModel::kEssential, PoseModel::kHomography}) {
    if (toString(model) == text) return model;
  }
  throw std::invalid_argument("'" + text + "' is no model of a pose; valid: none, essential, homography");
}

PoseEstimate estimatePose(const Correspondences& matches, const RelativePose& cameras,
                          const std::optional<cv::Matx33d>& homography) {
  const std::vector<RayPair> rays = normalised(matches, cameras);
  if (rays.size() < kPoseMatches) return {};
  const cv::Matx33d &left = cameras.left_camera, &right = cameras.right_camera;
  const double threshold = kPoseThreshold * 4 / (left(0, 0) + left(1, 1) + right(0, 0) + right(1, 1));
  CountedPose best;
  PoseModel model = PoseModel::kNone;
  const auto consider = [&](PoseModel kind, const auto& poseOf) {
    try {
      CountedPose pose = poseOf();
      refine(rays, threshold, pose);
      if (pose.n_inliers < kPoseMatches || pose.n_inliers < best.n_inliers) return;
      if (pose.n_inliers == best.n_inliers && !explainsBetter(pose, best, rays, threshold)) return;
      best = pose;
      model = kind;
    } catch (const cv::Exception&) {
      // Degenerate matches: this model gives no pose.
    }
  };
  if (homography) {
    consider(PoseModel::kHomography,
             [&] { return poseOfHomography(right.inv() * *homography * left, rays, threshold); });
  }
  consider(PoseModel::kEssential, [&] { return poseOfEssential(rays, threshold); });
  return {model, best.rotation, best.translation, best.n_inliers};
}

std::optional<HomographyEstimate> estimateHomography(const Correspondences& matches) {
  std::vector<cv::Point2f> left, right;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::Point2f a(matches.left_x[i], matches.left_y[i]), b(matches.right_x[i], matches.right_y[i]);
    if (!std::isfinite(a.x + a.y + b.x + b.y)) continue;
    left.push_back(a);
    right.push_back(b);
  }
  if (left.size() < kHomographyMatches) return {};
  try {
    cv::Mat mask;
    const cv::Mat found = cv::findHomography(left, right, cv::RANSAC, kHomographyThreshold, mask,
                                             kHomographyIterations, kHomographyConfidence);
    if (found.rows != 3 || found.cols != 3 || !cv::checkRange(found)) return {};
    return HomographyEstimate{found, static_cast<std::size_t>(cv::countNonZero(mask))};
  } catch (const cv::Exception&) {
    return {};  // degenerate matches
  }
}

}  // namespace corrsel::core
