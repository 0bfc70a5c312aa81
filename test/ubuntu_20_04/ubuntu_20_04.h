// Makes the installed libraries look like those of Ubuntu 20.04, where that cannot be had: OpenCV 4.2.0 and
// nlohmann-json 3.7.3. The platform bullseye-as-focal of scripts/maintenance/test_platforms.sh includes this
// header before everything else. The libraries report these versions, and a name that they got later is a
// compile error. What the old libraries compute differently is not seen.
//
// The names of OpenCV are those of its list of changes from 4.3 to 4.12, of the modules that corrsel uses.
#pragma once

#if __has_include(<opencv2/core.hpp>)
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#undef CV_VERSION_MAJOR
#undef CV_VERSION_MINOR
#undef CV_VERSION_REVISION
#define CV_VERSION_MAJOR 4
#define CV_VERSION_MINOR 2
#define CV_VERSION_REVISION 0

namespace cv {
// Overloads that came later have the names of older ones: the old one gets another name.
inline Mat findFundamentalMatOf42(InputArray left, InputArray right, int method = FM_RANSAC,
                                  double threshold = 3, double confidence = 0.99,
                                  OutputArray mask = noArray()) {
  return findFundamentalMat(left, right, method, threshold, confidence, mask);
}
}  // namespace cv
#define findFundamentalMat findFundamentalMatOf42

// features2d: SIFT came to the main modules in 4.4, AffineFeature in 4.5.
#pragma GCC poison SIFT SiftFeatureDetector SiftDescriptorExtractor AffineFeature
// calib3d
#pragma GCC poison UsacParams USAC_DEFAULT USAC_PARALLEL USAC_FM_8PTS USAC_FAST USAC_ACCURATE USAC_PROSAC \
    USAC_MAGSAC
#pragma GCC poison solvePnPRefineLM undistortImagePoints SOLVEPNP_SQPNP recoverPose3D \
    estimateChessboardSharpness
// core
#pragma GCC poison reduceArgMax reduceArgMin hasNonZero flipND transposeND copyAt REDUCE_SUM2 AlgorithmHint
// imgcodecs
#pragma GCC poison imcount ImageCollection imdecodemulti imencodemulti IMREAD_COLOR_RGB \
    IMWRITE_JPEG_SAMPLING_FACTOR
#pragma GCC poison imreadWithMetadata imreadanimation
// imgproc
#pragma GCC poison INTER_NEAREST_EXACT stackBlur COLORMAP_DEEPGREEN THRESH_DRYRUN approxPolyN \
    findContoursLinkRuns
#endif

#if __has_include(<nlohmann/json.hpp>)
#include <nlohmann/json.hpp>

#undef NLOHMANN_JSON_VERSION_MINOR
#undef NLOHMANN_JSON_VERSION_PATCH
#define NLOHMANN_JSON_VERSION_MINOR 7
#define NLOHMANN_JSON_VERSION_PATCH 3
#pragma GCC poison ordered_json ordered_map
#endif
