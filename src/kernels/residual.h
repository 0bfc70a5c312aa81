#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// How a match is compared with a model; the number of the kernel in ResidualKernels.
enum class Residual : std::uint8_t {
  kTransfer,           ///< |x' - Hx|^2
  kSymmetricTransfer,  ///< |x' - Hx|^2 + |x - H^-1 x'|^2
  kSampson,            ///< squared Sampson distance of x'^T F x
  kSmallerTransfer,    ///< min(|x' - Hx|^2, |x - H^-1 x'|^2), which exists if both errors exist
  kTangentSampson      ///< squared tangent Sampson error of d'^T E d, px^2, of rays
};
constexpr std::size_t kResiduals = 5;

/// Numbers of a ray: its direction (3) and the derivative by the pixel (3x2, row-major, 1/px).
constexpr std::size_t kRayNumbers = 9;

/// Four columns of equal length: left x, y, right x, y. Residual::kTangentSampson reads the rays instead.
struct MatchColumns {
  const float *left_x, *left_y, *right_x, *right_y;
  std::size_t size;
  /// Number k of the ray of match i is left_rays[k * ray_stride + i]; nullptr = no cameras.
  const float *left_rays = nullptr, *right_rays = nullptr;
  std::size_t ray_stride = 0;
};

/// A 3x3 matrix, row-major, and for Residual::kSymmetricTransfer and kSmallerTransfer its inverse, scaled so
/// that the third coordinate of both mappings is positive in front of the cameras.
struct ResidualModel {
  float forward[9];
  float backward[9];
};

/// Definition of the score of a model and of the condition for giving up.
struct ScoreRule {
  float squared_threshold;  ///< a match with error <= this is an inlier
  float cost_per_error;  ///< cost of an inlier = error * this: kOutlierCost / threshold^2 is MSAC, 0 counts
                         ///< outliers
  std::int64_t limit;    ///< give up once the cost reaches this
  double squared_margin = 1e300;  ///< bail-out: give up once cost - limit * seen / matches is positive and
                                  ///< its square above this times `seen`
  std::size_t start = 0;          ///< first match; a multiple of kBlock. Matches are visited cyclically
  double log_consistent = 0;      ///< SPRT: ln(delta / epsilon), added per inlier; both 0 = no SPRT
  double log_inconsistent = 0;    ///< SPRT: ln((1 - delta) / (1 - epsilon)), added per outlier
  double log_decision = 0;        ///< SPRT: ln(A): reject above this

  static constexpr std::int32_t kOutlierCost = 65536;  ///< whole numbers add up alike in any order
  static constexpr std::size_t kBlock = 16;            ///< the SPRT decides after every block
};

struct ModelScore {
  std::int64_t cost = 0;    ///< sum over the matches seen
  std::size_t inliers = 0;  ///< among the matches seen
  std::size_t surplus = 0;  ///< inliers that do not count, because another match of their point does; the
                            ///< kernels leave it at 0
  std::size_t seen = 0;     ///< matches seen before giving up; all of them unless rejected
  bool rejected = false;    ///< by the limit or by the SPRT
  bool rejected_by_sprt = false;
};

/// Sums that ResidualKernels::normal writes for a homography H, p = (x, y, 1) / w, (u, v) = H(x, y), w the
/// third coordinate, over the inliers: p_i p_j (6, i <= j), the same times u, times v, times u^2 + v^2; then
/// p (x' - u), p (y' - v), p (u (x' - u) + v (y' - v)) (3 each).
constexpr std::size_t kHomographySums = 33;

/// Sums that ResidualKernels::normal writes for a fundamental matrix F, p = (x, y, 1), q = (x', y', 1), g =
/// the squared gradient of q^T F p, over the inliers: q_i q_j p_k p_l / g (36, i <= j outer, k <= l inner).
constexpr std::size_t kFundamentalSums = 36;

/// Errors and scores of two-view models.
struct ResidualKernels {
  /// Squared errors of matches [begin, end), written to out[0 .. end - begin). An error that does not exist
  /// (point behind the camera) is +Inf.
  void (*errors[kResiduals])(const ResidualModel& model, const MatchColumns& matches, std::size_t begin,
                             std::size_t end, float* out);

  /// Truncated cost and inliers of a model. O(matches seen).
  ModelScore (*score[kResiduals])(const ResidualModel& model, const MatchColumns& matches,
                                  const ScoreRule& rule);

  /// Parts of the normal equations over the matches with error <= squared_threshold; which sums, see above.
  void (*normal[kResiduals])(const ResidualModel& model, const MatchColumns& matches, float squared_threshold,
                             double* sums);

  /// Squared errors of matches [begin, end) in double precision, written to out[0 .. end - begin).
  /// @param model  3x3, row-major
  using PixelErrors = void (*)(const double* model, const MatchColumns& matches, std::size_t begin,
                               std::size_t end, double* out);

  PixelErrors pixel_transfer;  ///< of a homography from left to right, as homographyError()
  PixelErrors pixel_sampson;   ///< of a fundamental matrix, as sampsonError()
};

}  // namespace corrsel::core
