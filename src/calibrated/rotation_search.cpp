#include "calibrated/rotation_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kSample = 256, kBlock = 64;  // matches that score candidates, and how many at a time
constexpr std::int32_t kOutlierCost = 1024;        // whole numbers add up alike in any order
// Two inliers among the first 64 are the least with which a candidate is scored on.
constexpr std::int64_t kHopeless = (static_cast<std::int64_t>(kBlock) - 1) * kOutlierCost;
constexpr int kMaxDrawn = 2000, kMaxScored = 100;
constexpr double kPrefix = 10, kPrefixGrowth = 1.02;  // matches among which pairs are drawn
constexpr double kSearchWidth = 2, kFitWidth = 3;     // of the threshold
constexpr double kMinSpread = 10;                     // angle of a pair over that of the threshold
constexpr double kDrawsPerSquaredShare = 20;          // an inlier pair was missed with probability e^-20

struct FloatMatrix {
  float m[9];
  explicit FloatMatrix(const cv::Matx33d& matrix) {
    for (int k = 0; k < 9; ++k) m[k] = static_cast<float>(matrix.val[k]);
  }
};

/// Squared distance of M (x, y, z) from (u, v, w).
inline float squaredDistance(const FloatMatrix& r, float x, float y, float z, float u, float v, float w) {
  const float a = r.m[0] * x + r.m[1] * y + r.m[2] * z - u;
  const float b = r.m[3] * x + r.m[4] * y + r.m[5] * z - v;
  const float c = r.m[6] * x + r.m[7] * y + r.m[8] * z - w;
  return a * a + b * b + c * c;
}

/// Errors of a range of left rays with a range of right rays.
/// @param left, right  the x of the first ray; y and z lie n and 2 n further
void squaredErrors(const FloatMatrix& rotation, const float* left, const float* right, std::size_t n,
                   const float* weight, std::size_t count, float* __restrict out) {
  const float *const y = left + n, *const z = y + n, *const v = right + n, *const w = v + n;
  for (std::size_t i = 0; i < count; ++i)
    out[i] = weight[i] * squaredDistance(rotation, left[i], y[i], z[i], right[i], v[i], w[i]);
}

/// Errors under a homography H. @param q  H H^T
void squaredErrors(const FloatMatrix& h, const FloatMatrix& q, const RayColumns& columns,
                   const float* left_angle, const float* right_angle, float* __restrict out) {
  const std::size_t n = columns.size;
  const float *const left = columns.left.data(), *const right = columns.right.data();
  for (std::size_t i = 0; i < n; ++i) {
    const float x = left[i], y = left[n + i], z = left[2 * n + i];
    float a = h.m[0] * x + h.m[1] * y + h.m[2] * z;
    float b = h.m[3] * x + h.m[4] * y + h.m[5] * z;
    float c = h.m[6] * x + h.m[7] * y + h.m[8] * z;
    const float scale = 1 / std::sqrt(a * a + b * b + c * c + 1e-30F);
    a *= scale, b *= scale, c *= scale;
    const float u = a - right[i], v = b - right[n + i], w = c - right[2 * n + i];
    // The covariance of the error in units of s'^2, K = I + g P H H^T P with the projection P across the ray.
    const float s = left_angle[i] * scale / right_angle[i], g = s * s;
    const float qa = q.m[0] * a + q.m[1] * b + q.m[2] * c, qb = q.m[3] * a + q.m[4] * b + q.m[5] * c,
                qc = q.m[6] * a + q.m[7] * b + q.m[8] * c, along = a * qa + b * qb + c * qc;
    const float xx = 1 + g * (q.m[0] - 2 * a * qa + along * a * a);
    const float yy = 1 + g * (q.m[4] - 2 * b * qb + along * b * b);
    const float zz = 1 + g * (q.m[8] - 2 * c * qc + along * c * c);
    const float xy = g * (q.m[1] - a * qb - b * qa + along * a * b);
    const float xz = g * (q.m[2] - a * qc - c * qa + along * a * c);
    const float yz = g * (q.m[5] - b * qc - c * qb + along * b * c);
    const float ax = yy * zz - yz * yz, ay = xz * yz - xy * zz, az = xy * yz - xz * yy;
    const float by = xx * zz - xz * xz, bz = xy * xz - xx * yz, cz = xx * yy - xy * xy;
    const float determinant = xx * ax + xy * ay + xz * az;
    const float form = u * u * ax + v * v * by + w * w * cz + 2 * (u * v * ay + u * w * az + v * w * bz);
    out[i] = form / (determinant * right_angle[i] * right_angle[i]);
  }
}

/// Root mean square of a ray's derivatives, as rad per px.
void pixelAngles(const std::vector<float>& rays, std::size_t n, std::vector<float>& angles) {
  angles.resize(n);
  const float* const j = rays.data() + 3 * n;
  for (std::size_t i = 0; i < n; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < 6; ++k) sum += j[k * n + i] * j[k * n + i];
    angles[i] = std::sqrt(0.5F * sum);
  }
}

cv::Vec3d direction(const std::vector<float>& rays, std::size_t n, std::size_t i) {
  return {rays[i], rays[n + i], rays[2 * n + i]};
}

/// The orthonormal triad of two rays.
cv::Matx33d triad(const cv::Vec3d& a, const cv::Vec3d& b) {
  const cv::Vec3d sum = cv::normalize(a + b), across = cv::normalize(a.cross(b)), third = sum.cross(across);
  return {sum[0], across[0], third[0], sum[1], across[1], third[1], sum[2], across[2], third[2]};
}

/// The rotation R that maximises trace(R^T B), B = sum w d' d^T.
cv::Matx33d nearestRotation(const double (&b)[9]) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> matrix(b);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  cv::Matx33d rotation;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> result(rotation.val);
  result = u * svd.matrixV().transpose();
  return rotation;
}

}  // namespace

void RayTransfer::assign(const RayColumns& columns) {
  columns_ = &columns;
  const std::size_t n = columns.size;
  pixelAngles(columns.left, n, left_angle_);
  pixelAngles(columns.right, n, right_angle_);
  weight_.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    weight_[i] = 1 / (left_angle_[i] * left_angle_[i] + right_angle_[i] * right_angle_[i]);
}

void RayTransfer::rotationErrors(const cv::Matx33d& rotation, std::size_t n, float* out) const {
  squaredErrors(FloatMatrix(rotation), columns_->left.data(), columns_->right.data(), size(), weight_.data(),
                n, out);
}

void RayTransfer::repairedErrors(const cv::Matx33d& rotation, std::size_t shift, float* out) const {
  const FloatMatrix r(rotation);
  const std::size_t n = size(), rest = n - shift;
  const float *const left = columns_->left.data(), *const right = columns_->right.data();
  squaredErrors(r, left, right + shift, n, weight_.data(), rest, out);
  squaredErrors(r, left + rest, right, n, weight_.data() + rest, shift, out + rest);
}

void RayTransfer::homographyErrors(const cv::Matx33d& homography, float* out) const {
  squaredErrors(FloatMatrix(homography), FloatMatrix(homography * homography.t()), *columns_,
                left_angle_.data(), right_angle_.data(), out);
}

cv::Matx33d RotationSearch::find(const RayTransfer& transfer, const std::vector<std::uint32_t>* best_first,
                                 const cv::Matx33d* given, double threshold, std::uint64_t seed) {
  transfer_ = &transfer;
  takeSample(transfer);
  const auto limit = static_cast<float>(kSearchWidth * kSearchWidth * threshold * threshold);
  for (std::size_t i = 0; i < sample_size_; ++i) sample_[6 * sample_size_ + i] /= limit;
  best_ = cv::Matx33d::eye();
  best_cost_ = std::numeric_limits<std::int64_t>::max();
  consider(best_);
  if (given) consider(*given);
  drawPairs(best_first, threshold, seed);
  refine(std::min(transfer.size(), kSample), 4, threshold);
  refine(transfer.size(), 3, threshold);
  return best_;
}

/// Copies the first matches. Those that are missing in the last block get the weight 0, so that they agree
/// with everything.
void RotationSearch::takeSample(const RayTransfer& transfer) {
  const std::size_t n = transfer.size(), taken = std::min(n, kSample);
  sample_size_ = (taken + kBlock - 1) / kBlock * kBlock;
  sample_.assign(7 * sample_size_, 0);
  for (std::size_t k = 0; k < 3; ++k) {
    std::copy_n(transfer.columns().left.data() + k * n, taken, sample_.data() + k * sample_size_);
    std::copy_n(transfer.columns().right.data() + k * n, taken, sample_.data() + (3 + k) * sample_size_);
  }
  for (std::size_t i = 0; i < taken; ++i) sample_[6 * sample_size_ + i] = transfer.weight(i);
}

/// The truncated sum of errors over the sample, or a sum above the best one.
std::int64_t RotationSearch::cost(const cv::Matx33d& rotation) const {
  const FloatMatrix r(rotation);
  const std::size_t n = sample_size_;
  const float* const s = sample_.data();
  std::int64_t sum = 0;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    std::int32_t block = 0;
    for (std::size_t i = begin; i < begin + kBlock; ++i) {
      const float error = s[6 * n + i] * squaredDistance(r, s[i], s[n + i], s[2 * n + i], s[3 * n + i],
                                                         s[4 * n + i], s[5 * n + i]);
      block += static_cast<std::int32_t>((error < 1.0F ? error : 1.0F) * static_cast<float>(kOutlierCost));
    }
    sum += block;
    if (sum >= best_cost_ || (begin == 0 && sum > kHopeless && best_cost_ < kHopeless)) return best_cost_;
  }
  return sum;
}

void RotationSearch::consider(const cv::Matx33d& rotation) {
  const std::int64_t sum = cost(rotation);
  if (!(sum < best_cost_)) return;
  best_ = rotation;
  best_cost_ = sum;
}

void RotationSearch::drawPairs(const std::vector<std::uint32_t>* best_first, double threshold,
                               std::uint64_t seed) {
  const RayColumns& rays = transfer_->columns();
  const std::size_t n = rays.size;
  Random random(seed);
  double prefix = kPrefix;
  for (int drawn = 0, scored = 0; drawn < kMaxDrawn && scored < kMaxScored; ++drawn) {
    std::uint32_t pair[2];
    if (best_first && drawn % 2 == 0) {
      random.sample(static_cast<std::uint32_t>(std::min(prefix, static_cast<double>(n))), 2, pair);
      for (std::uint32_t& row : pair) row = (*best_first)[row];
      prefix *= kPrefixGrowth;
    } else {
      random.sample(static_cast<std::uint32_t>(n), 2, pair);
    }
    const cv::Vec3d a = direction(rays.left, n, pair[0]), b = direction(rays.left, n, pair[1]);
    const cv::Vec3d c = direction(rays.right, n, pair[0]), d = direction(rays.right, n, pair[1]);
    const double tolerance = threshold * (1 / std::sqrt(static_cast<double>(transfer_->weight(pair[0]))) +
                                          1 / std::sqrt(static_cast<double>(transfer_->weight(pair[1]))));
    const double left = a.dot(b), right = c.dot(d);
    const double squared_sine = 1 - std::max(left * left, right * right);
    if (!(squared_sine > kMinSpread * kMinSpread * tolerance * tolerance)) continue;
    if (std::abs(left - right) > tolerance * std::sqrt(squared_sine)) continue;
    ++scored;
    consider(triad(c, d) * triad(a, b).t());
    const double share =
        1 - static_cast<double>(best_cost_) / static_cast<double>(kOutlierCost * std::min(n, kSample));
    if (share > 0 && drawn * share * share > kDrawsPerSquaredShare) break;
  }
}

/// Fits the best rotation to the first n matches.
void RotationSearch::refine(std::size_t n, int rounds, double threshold) {
  const RayColumns& rays = transfer_->columns();
  const auto squared = static_cast<float>(threshold * threshold);
  errors_.resize(transfer_->size());
  for (int round = 0; round < rounds; ++round) {
    transfer_->rotationErrors(best_, n, errors_.data());
    double sums[9] = {};
    for (std::size_t i = 0; i < n; ++i) {
      if (!(errors_[i] <= static_cast<float>(kFitWidth * kFitWidth) * squared)) continue;
      const double x = 1 + static_cast<double>(errors_[i] / squared);
      const cv::Vec3d d = direction(rays.left, rays.size, i) * (transfer_->weight(i) / (x * x));
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c)
          sums[3 * r + c] += static_cast<double>(rays.right[r * rays.size + i]) * d[static_cast<int>(c)];
      }
    }
    const cv::Matx33d fitted = nearestRotation(sums);
    const double change = cv::norm(fitted - best_);
    best_ = fitted;
    if (change < 1e-7) break;
  }
}

}  // namespace corrsel::core
