#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "corrsel/database/pair_store.h"

// How COLMAP's databases write numbers of pairs, positions, matrices and poses
// (https://colmap.github.io/database.html).

namespace corrsel::core {

/// One more than the largest number of an image.
constexpr std::int64_t kColmapImageLimit = 2147483647;

/// px, the coordinates of the centre of the first pixel.
constexpr float kColmapPixelCentre = 0.5F;

/// 2147483647 * first + second.
std::int64_t colmapPairNumber(const ImagePairKey& pair);

/// The images of a pair's number, in the order in which the number has them.
ImagePairKey colmapPairImages(std::int64_t number);

/// A matrix in row-major order.
using ColmapMatrix = std::array<double, 9>;

ColmapMatrix colmapEssential(const cv::Matx33d& essential);
cv::Matx33d essentialFromColmap(const ColmapMatrix& matrix);

/// S^-T F S^-1, where S moves the origin from the first pixel's centre to its corner.
ColmapMatrix colmapFundamental(const cv::Matx33d& fundamental);
cv::Matx33d fundamentalFromColmap(const ColmapMatrix& matrix);

/// S H S^-1.
ColmapMatrix colmapHomography(const cv::Matx33d& homography);
cv::Matx33d homographyFromColmap(const ColmapMatrix& matrix);

/// w x y z of a rotation, with w >= 0.
std::array<double, 4> colmapQuaternion(const cv::Matx33d& rotation);

}  // namespace corrsel::core
