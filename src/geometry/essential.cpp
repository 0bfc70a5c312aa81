#include "geometry/essential.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/cross_matrix.h"
#include "geometry/known_motion.h"
#include "geometry/match_rays.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kVotes = 100;  // agreeing matches that choose among the four poses
constexpr std::size_t kBlock = 64;
constexpr double kPriorTolerance = 1e-3;  // of the rotation of a pose that satisfies a prior
constexpr double kMinGradient = 1e-30;    // keeps r finite where its gradient vanishes, as at an epipole

/// The nearest rotation to a matrix that is one but for rounding: a step of Newton's iteration.
cv::Matx33d orthonormal(const cv::Matx33d& r) { return r * (cv::Matx33d::eye() * 1.5 - r.t() * r * 0.5); }

/// t t^T = trace(E E^T) / 2 I - E E^T, of which the largest column gives t.
cv::Vec3d translationOf(const cv::Matx33d& e) {
  const cv::Matx33d squared = e * e.t();
  const cv::Matx33d tt = cv::Matx33d::eye() * (0.5 * cv::trace(squared)) - squared;
  int largest = 0;
  for (int k = 1; k < 3; ++k) {
    if (tt(k, k) > tt(largest, largest)) largest = k;
  }
  return cv::Vec3d(tt(0, largest), tt(1, largest), tt(2, largest)) / std::sqrt(tt(largest, largest));
}

cv::Matx33d cofactors(const cv::Matx33d& e) {
  const cv::Vec3d e0(e(0, 0), e(1, 0), e(2, 0)), e1(e(0, 1), e(1, 1), e(2, 1)), e2(e(0, 2), e(1, 2), e(2, 2));
  const cv::Vec3d c0 = e1.cross(e2), c1 = e2.cross(e0), c2 = e0.cross(e1);
  return {c0[0], c1[0], c2[0], c0[1], c1[1], c2[1], c0[2], c1[2], c2[2]};
}

/// Makes two poses with the same rotation satisfy the prior. @return whether they did but for rounding
bool keepTo(const std::optional<PosePrior>& prior, Pose& pose, Pose& opposite) {
  const cv::Matx33d rotation = constrained(prior, pose.rotation);
  const double difference = cv::norm(rotation - pose.rotation);
  pose.rotation = opposite.rotation = rotation;
  return difference <= kPriorTolerance;
}

/// How many of the matches lie strictly in front of both cameras: with t, and with -t.
struct SideVotes {
  std::size_t positive = 0, negative = 0;

  void add(const ScaledDepths& depths) {
    positive += depths.left > 0 && depths.right > 0 ? 1 : 0;
    negative += depths.left < 0 && depths.right < 0 ? 1 : 0;
  }
};

}  // namespace

cv::Matx33d essentialOf(const Pose& pose) { return crossMatrix(pose.translation) * pose.rotation; }

bool posesOf(const cv::Matx33d& essential, Pose (&poses)[4]) {
  const double length = cv::norm(essential);
  if (!(length > 0 && std::isfinite(length))) return false;
  const cv::Matx33d e = essential * (1 / length);
  const cv::Vec3d t = translationOf(e);
  const cv::Matx33d cof = cofactors(e), te = crossMatrix(t) * e;
  const double squared = t.dot(t);
  if (!(squared > 0 && std::isfinite(squared))) return false;
  const cv::Vec3d unit = t / std::sqrt(squared);
  for (int k = 0; k < 4; ++k) {
    poses[k].rotation =
        k < 2 ? orthonormal((cof - te) * (1 / squared)) : orthonormal((cof + te) * (1 / squared));
    poses[k].translation = k % 2 == 0 ? unit : -unit;
  }
  return true;
}

ScaledDepths scaledDepths(const Pose& pose, const cv::Vec3d& left, const cv::Vec3d& right) {
  const cv::Vec3d a = pose.rotation * left;
  const double at = a.dot(pose.translation), bt = right.dot(pose.translation), cosine = a.dot(right);
  return {cosine * bt - at, bt - cosine * at};
}

bool isInFront(const Pose& pose, const RayMatches& matches, std::size_t i, double threshold) {
  const ScaledDepths depths = scaledDepths(pose, matches.left.direction(i), matches.right.direction(i));
  const double tolerance = threshold * (matches.left.pixelAngle(i) + matches.right.pixelAngle(i));
  return depths.left > -tolerance && depths.right > -tolerance;
}

double tangentSampson(const cv::Matx33d& essential, const RayMatches& matches, std::size_t i) {
  const cv::Vec3d right = matches.right.direction(i);
  const cv::Vec3d l = essential * matches.left.direction(i), m = essential.t() * right;
  const cv::Vec2d p = matches.left.jacobian(i).t() * m, q = matches.right.jacobian(i).t() * l;
  return right.dot(l) / std::sqrt(p.dot(p) + q.dot(q) + kMinGradient);
}

void squaredTangentSampson(const cv::Matx33d& essential, const RayMatches& matches, double* out) {
  kernels().pose.errors(essential.val, matchRaysOf(matches), 0, matches.size(), out);
}

bool choosePose(const cv::Matx33d& essential, const RayMatches& matches, double threshold, Pose& pose,
                const std::optional<PosePrior>& prior) {
  Pose poses[4];
  if (!posesOf(essential, poses)) return false;
  bool satisfies[2];
  for (int k = 0; k < 2; ++k) satisfies[k] = keepTo(prior, poses[2 * k], poses[2 * k + 1]);
  std::size_t agreeing = 0;
  SideVotes votes[2];
  for (std::size_t begin = 0; begin < matches.size() && agreeing < kVotes; begin += kBlock) {
    double squared[kBlock];
    const std::size_t end = std::min(matches.size(), begin + kBlock);
    kernels().pose.errors(essential.val, matchRaysOf(matches), begin, end, squared);
    for (std::size_t i = begin; i < end && agreeing < kVotes; ++i) {
      if (!(squared[i - begin] <= threshold * threshold)) continue;
      ++agreeing;
      const cv::Vec3d left = matches.left.direction(i), right = matches.right.direction(i);
      for (int k = 0; k < 2; ++k) votes[k].add(scaledDepths(poses[2 * k], left, right));
    }
  }
  for (int k = 0; k < 2; ++k) votes[k] = satisfies[k] ? votes[k] : SideVotes();
  const std::size_t counts[4] = {votes[0].positive, votes[0].negative, votes[1].positive, votes[1].negative};
  const std::size_t* const best = std::max_element(counts, counts + 4);
  if (agreeing == 0 || 2 * *best < agreeing) return false;
  pose = poses[best - counts];
  return true;
}

}  // namespace corrsel::core
