#pragma once

#include <opencv2/core/matx.hpp>

#include "corrsel/pose_result.h"

namespace corrsel::core {

/// A covariance that refers to the translationBasis() of one translation, in the basis of a near one.
cv::Matx<double, 5, 5> inBasisOf(const cv::Vec3d& to, const cv::Vec3d& from,
                                 const cv::Matx<double, 5, 5>& covariance);

/// The part of a deviation along those principal axes of its covariance on which it exceeds 5 standard
/// deviations; NaN where the covariance is not finite.
cv::Vec<double, 5> significantPart(const cv::Vec<double, 5>& deviation,
                                   const cv::Matx<double, 5, 5>& covariance);

/// The size of a deviation, degrees: the larger one of the angles of its rotation and of its direction.
double angleOf(const cv::Vec<double, 5>& deviation);

}  // namespace corrsel::core
