#include "database/colmap_conventions.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace corrsel::core {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Moves the origin by `shift` px in both directions: x -> x + shift.
cv::Matx33d shifted(double shift) { return {1, 0, shift, 0, 1, shift, 0, 0, 1}; }

ColmapMatrix arrayOf(const cv::Matx33d& matrix) {
  ColmapMatrix values;
  std::copy(matrix.val, matrix.val + values.size(), values.begin());
  return values;
}

cv::Matx33d matrixOf(const ColmapMatrix& values) { return cv::Matx33d(values.data()); }

/// F for positions that were moved by `shift` in both images.
cv::Matx33d fundamentalAfterShift(const cv::Matx33d& fundamental, double shift) {
  const cv::Matx33d back = shifted(-shift);
  return back.t() * fundamental * back;
}

cv::Matx33d homographyAfterShift(const cv::Matx33d& homography, double shift) {
  return shifted(shift) * homography * shifted(-shift);
}

}  // namespace

std::int64_t colmapPairNumber(const ImagePairKey& pair) {
  return kColmapImageLimit * pair.first + pair.second;
}

ImagePairKey colmapPairImages(std::int64_t number) {
  return {static_cast<std::uint32_t>(number / kColmapImageLimit),
          static_cast<std::uint32_t>(number % kColmapImageLimit)};
}

ColmapMatrix colmapEssential(const cv::Matx33d& essential) { return arrayOf(essential); }

cv::Matx33d essentialFromColmap(const ColmapMatrix& matrix) { return matrixOf(matrix); }

ColmapMatrix colmapFundamental(const cv::Matx33d& fundamental) {
  return arrayOf(fundamentalAfterShift(fundamental, kColmapPixelCentre));
}

cv::Matx33d fundamentalFromColmap(const ColmapMatrix& matrix) {
  return fundamentalAfterShift(matrixOf(matrix), -kColmapPixelCentre);
}

ColmapMatrix colmapHomography(const cv::Matx33d& homography) {
  return arrayOf(homographyAfterShift(homography, kColmapPixelCentre));
}

cv::Matx33d homographyFromColmap(const ColmapMatrix& matrix) {
  return homographyAfterShift(matrixOf(matrix), -kColmapPixelCentre);
}

std::array<double, 4> colmapQuaternion(const cv::Matx33d& rotation) {
  Eigen::Quaterniond q(RowMajor(Eigen::Map<const RowMajor>(rotation.val)));
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  return {q.w(), q.x(), q.y(), q.z()};
}

}  // namespace corrsel::core
