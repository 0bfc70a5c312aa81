#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace corrsel::core {

inline constexpr std::size_t kFreakFields = 43;
inline constexpr std::size_t kFreakOrientationPairs = 45;
inline constexpr std::size_t kFreakTests = 512;
inline constexpr double kFreakUnitSize = 7;  ///< keypoint size at which the pattern has its nominal scale, px

/// Two receptive fields, by their numbers.
using FreakPair = std::pair<std::uint8_t, std::uint8_t>;

/// A receptive field of the pattern at scale 1, relative to the keypoint.
struct FreakField {
  double x, y;
  double sigma;
};

/// The retinal pattern: seven rings of six fields, the outermost ring first, and the centre. Every second
/// ring is rotated by 30 degrees. The ring radii are 2/3 - k u with k = 0, 6, 11, 15, 18 and 20 and u = (2/3
/// - 1/12) / 21, and 1/12 for the innermost ring. The sigma of a field is half the radius of its ring; that
/// of the centre is the sigma of the innermost ring. Fields of neighbouring rings overlap.
///
/// Source: Alahi, Ortiz and Vandergheynst, "FREAK: Fast Retina Keypoint", CVPR 2012, section 4.1 and figure
/// 4.
std::array<FreakField, kFreakFields> freakPattern();

/// The pairs from which the orientation is computed (section 4.4 and figure 6), symmetric about the centre:
/// three diameters of every ring, and the two triangles of each of the four outer rings.
std::array<FreakPair, kFreakOrientationPairs> freakOrientationPairs();

/// All 903 pairs of fields, (a, b) with a < b, in lexicographic order. The 512 tests are chosen from them.
std::vector<FreakPair> freakCandidatePairs();

/// The 512 tests, those of the largest fields first. scripts/maintenance/train_freak.sh generates them by the
/// procedure of section 4.2, which prefers tests whose results on the blobs of the sample images are evenly
/// distributed and little correlated.
extern const std::array<FreakPair, kFreakTests> kFreakPairs;

/// Mean grey levels of the fields around any place of an image. Sums come from an integral image of 32 bits,
/// which may overflow: differences are exact as long as the sum over a box is below 2^32, which kMaxBox
/// ensures. A box may begin and end within pixels, which then count in proportion to the covered part. The
/// constructor takes O(pixels) time and 4 bytes per pixel.
class FreakSampler {
 public:
  using Means = std::array<float, kFreakFields>;

  /// @param grey          8-bit, one channel
  /// @param pattern_scale  of the pattern around a keypoint of kFreakUnitSize, px
  FreakSampler(const cv::Mat& grey, double pattern_scale);

  /// Whether the pattern lies within the image for every rotation.
  /// @param size  diameter of the keypoint, px
  bool fits(const cv::Point2f& position, double size) const;

  /// Means of the fields of the pattern rotated by `angle`, grey levels. They are rounded to 1/16, so fields
  /// of the same level compare as equal. @pre fits(position, size)
  /// @param angle  radians, from x to y
  Means means(const cv::Point2f& position, double size, double angle) const;

  /// Direction of the mean gradient over the orientation pairs (equation 3), radians in [-pi, pi]; 0 where
  /// the gradient is zero. @pre fits(position, size)
  double orientation(const cv::Point2f& position, double size) const;

 private:
  static constexpr double kMaxBox = 4096;  ///< side, px

  double scaleOf(double size) const { return pattern_scale_ * size / kFreakUnitSize; }
  float boxMean(double x, double y, double half_side) const;

  std::array<FreakField, kFreakFields> fields_ = freakPattern();
  std::array<FreakPair, kFreakOrientationPairs> orientation_pairs_ = freakOrientationPairs();
  double pattern_scale_;
  int width_, height_;
  std::vector<std::uint32_t>
      integral_;  ///< (height + 1) x (width + 1): sums over the pixels above and to the left
};

}  // namespace corrsel::core
