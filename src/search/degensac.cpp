#include "search/degensac.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/cross_matrix.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr int kSample = 7, kOnPlane = 5;
constexpr float kPlaneWidth = 3.0F;     // of the squared threshold: sqrt(3) times the threshold
constexpr float kOffPlaneWidth = 9.0F;  // the same for matches that are surely off the plane
constexpr int kRefinements = 3, kMaxPairs = 500;
constexpr double kConfidence = 0.99;

cv::Vec3d leftPoint(const NormalizedMatches& m, std::uint32_t i) { return {m.left_x[i], m.left_y[i], 1}; }
cv::Vec3d rightPoint(const NormalizedMatches& m, std::uint32_t i) { return {m.right_x[i], m.right_y[i], 1}; }

/// The homography of the plane through three matches that is compatible with F: H = A - e' (M^-1 b)^T,
/// A = [e']_x F, rows of M = x_i, b_i = (x'_i x A x_i) . (x'_i x e') / |x'_i x e'|^2 (Hartley and
/// Zisserman, 13.6).
std::optional<cv::Matx33d> planeThrough(const cv::Matx33d& f, const cv::Vec3d& epipole,
                                        const NormalizedMatches& m, const std::uint32_t (&rows)[3]) {
  const cv::Matx33d a = crossMatrix(epipole) * f;
  cv::Matx33d points;
  cv::Vec3d b;
  for (int i = 0; i < 3; ++i) {
    const cv::Vec3d x = leftPoint(m, rows[i]), u = rightPoint(m, rows[i]), across = u.cross(epipole);
    const double squared = across.dot(across);
    if (!(squared > 0)) return std::nullopt;
    b[i] = u.cross(a * x).dot(across) / squared;
    for (int c = 0; c < 3; ++c) points(i, c) = x[c];
  }
  const cv::Matx33d adjugate = adjugateOf(points);
  const double determinant =
      points(0, 0) * adjugate(0, 0) + points(0, 1) * adjugate(1, 0) + points(0, 2) * adjugate(2, 0);
  if (determinant == 0) return std::nullopt;
  const cv::Vec3d plane = adjugate * b * (1.0 / determinant);
  cv::Matx33d h = a - cv::Matx33d(epipole[0] * plane[0], epipole[0] * plane[1], epipole[0] * plane[2],
                                  epipole[1] * plane[0], epipole[1] * plane[1], epipole[1] * plane[2],
                                  epipole[2] * plane[0], epipole[2] * plane[1], epipole[2] * plane[2]);
  const double norm = cv::norm(h);
  if (!std::isfinite(norm) || !(norm > 0)) return std::nullopt;
  h = h * (1.0 / norm);
  // In front of the cameras the third coordinate is positive.
  const cv::Vec3d image = h * leftPoint(m, rows[0]);
  return image[2] < 0 ? h * -1.0 : h;
}

/// The homography that at least five matches of the sample agree with, if there is one.
std::optional<cv::Matx33d> planeOfSample(const cv::Matx33d& f, const NormalizedMatches& m,
                                         const std::uint32_t* sample, float squared_threshold) {
  constexpr int kTriplets[5][3] = {{0, 1, 2}, {3, 4, 5}, {0, 1, 6}, {3, 4, 6}, {2, 5, 6}};
  const cv::Vec3d epipole = leftNullVector(f);
  for (const auto& triplet : kTriplets) {
    const auto h = planeThrough(f, epipole, m, {sample[triplet[0]], sample[triplet[1]], sample[triplet[2]]});
    if (!h) continue;
    int agreeing = 0;
    for (int k = 0; k < kSample; ++k) {
      const std::uint32_t i = sample[k];
      agreeing += homographyError(*h, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]) <=
                          kPlaneWidth * squared_threshold
                      ? 1
                      : 0;
    }
    if (agreeing >= kOnPlane) return h;
  }
  return std::nullopt;
}

}  // namespace

bool improveByParallax(const Verifier& verifier, const cv::Matx33d& plane,
                       const std::vector<std::uint32_t>& off_plane, int max_pairs, Random& random,
                       Candidate& best) {
  const NormalizedMatches& m = verifier.matches();
  const std::size_t elsewhere = m.size() - off_plane.size();
  bool improved = false;
  double pairs = max_pairs;
  for (int drawn = 0; drawn < pairs; ++drawn) {
    std::uint32_t pair[2];
    random.sample(static_cast<std::uint32_t>(off_plane.size()), 2, pair);
    const std::uint32_t a = off_plane[pair[0]], b = off_plane[pair[1]];
    const cv::Vec3d first = cv::Vec3d(plane * leftPoint(m, a)).cross(rightPoint(m, a));
    const cv::Vec3d second = cv::Vec3d(plane * leftPoint(m, b)).cross(rightPoint(m, b));
    const cv::Matx33d candidate = crossMatrix(first.cross(second)) * plane;
    const double norm = cv::norm(candidate);
    if (!std::isfinite(norm) || !(norm > 0) || !verifier.improve(candidate * (1.0 / norm), best)) continue;
    improved = true;
    // At least this many of the inliers are off the plane.
    const double off_inliers =
        static_cast<double>(best.inliers) - static_cast<double>(std::min(elsewhere, best.inliers));
    const double share = off_inliers / static_cast<double>(off_plane.size());
    if (share >= 1) break;
    if (share > 0) pairs = std::min(pairs, std::log1p(-kConfidence) / std::log1p(-share * share));
  }
  return improved;
}

bool escapeDominantPlane(const Verifier& verifier, const std::uint32_t* sample, DegeneracyMemory& memory,
                         Candidate& best) {
  const NormalizedMatches& m = verifier.matches();
  const float squared_threshold = verifier.squaredThreshold();
  const auto plane = planeOfSample(best.model, m, sample, squared_threshold);
  if (!plane) return false;
  auto& [random, errors, off_plane] = memory;
  cv::Matx33d h = *plane;
  for (int step = 0; step < kRefinements; ++step) {
    if (!refineHomography(m, Residual::kTransfer, kPlaneWidth * squared_threshold, h)) break;
  }
  errors.resize(m.size());
  modelErrors(Residual::kTransfer, h, m, 0, m.size(), errors.data());
  off_plane.clear();
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (errors[i] > kOffPlaneWidth * squared_threshold) off_plane.push_back(static_cast<std::uint32_t>(i));
  }
  if (off_plane.size() < 2) return false;
  return improveByParallax(verifier, h, off_plane, kMaxPairs, random, best);
}

}  // namespace corrsel::core
