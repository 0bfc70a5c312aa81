#pragma once

#include <opencv2/core/version.hpp>

/// What the comparisons use of OpenCV that its oldest supported version, 4.2, does not have.
#define CORRSEL_OPENCV_AT_LEAST(major, minor) \
  (CV_VERSION_MAJOR > (major) || (CV_VERSION_MAJOR == (major) && CV_VERSION_MINOR >= (minor)))

/// CORRSEL_USAC(FAST) is cv::USAC_FAST, or a number for which openCv() reports that OpenCV 4.5 is needed.
#if CORRSEL_OPENCV_AT_LEAST(4, 5)
#define CORRSEL_USAC(method) cv::USAC_##method
#else
#define CORRSEL_USAC(method) (-1)
#endif
