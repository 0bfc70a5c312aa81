#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace corrsel {

/// Functions with the names and arguments of OpenCV's, so that a program changes one line:
///
///     cv::Mat h = corrsel::opencv::findHomography(left, right, cv::RANSAC, 3, mask);
///
/// Call them with their namespace: C++ looks for a name without one in the namespace of its arguments, too,
/// and finds OpenCV's function.
///
/// What differs from OpenCV:
///  - Instead of a number, `method` may be the name of a selector (docs/selectors.md), with a preset and
///  options
///    where wanted: "auto", "usac:f", "usac[max_seconds=0.01]". A selector that finds no model of the wanted
///    kind, such as "lpm", chooses among the matches, and "usac" fits the model to those that it kept.
///  - Of OpenCV's numbers, LMEDS gives "acransac", which finds its threshold itself, too; RANSAC, RHO and all
///    USAC_* give "usac". Those that reject no match (0, FM_7POINT, FM_8POINT) are refused.
///  - Data never cause an exception. Too few points, NaN, a degenerate configuration, and a selector that is
///  not
///    sure of its result give an empty matrix and a mask of zeros.
///  - A threshold of 0 is the selector's own. `maxIters` and `confidence` have an effect where they ask for
///  more
///    than the selector's own.
///  - The same arguments give the same result, bit for bit.
///
/// Points are what OpenCV takes: N points with two channels or N x 2 matrices of int, float or double, or
/// vectors of points; they are kept in single precision. Masks are N x 1 of CV_8U, 1 = inlier. The time is
/// that of the selector. The functions may be called from any thread.
///
/// All of them throw std::invalid_argument naming the argument, its value and what is valid: points of
/// another type or shape, as many as the other image has not, a method that is unknown or needs more than
/// positions, a threshold or a confidence out of its range.
namespace opencv {

/// What an argument `method` stands for: one of OpenCV's numbers, or the name of a selector.
class Method {
 public:
  /// Throws std::invalid_argument for a number that is no robust method of OpenCV.
  Method(int number);            // NOLINT(google-explicit-constructor): arguments are given as in OpenCV
  Method(const char* selector);  // NOLINT(google-explicit-constructor)
  Method(std::string selector);  // NOLINT(google-explicit-constructor)

  const std::string& selector() const { return selector_; }
  /// Whether it was a number: errors are then measured as OpenCV does, and a result that chance explains is
  /// none.
  bool isNumber() const { return is_number_; }

 private:
  std::string selector_;
  bool is_number_ = false;
};

/// The homography H from srcPoints to dstPoints, x' ~ H x, as cv::findHomography(): 3 x 3, CV_64F, with H(2,
/// 2) = 1, or empty.
/// @param ransacReprojThreshold  largest error of an inlier, px: in the right image with a number of OpenCV,
///                               otherwise what the selector measures
cv::Mat findHomography(cv::InputArray srcPoints, cv::InputArray dstPoints, const Method& method = "auto",
                       double ransacReprojThreshold = 3, cv::OutputArray mask = cv::noArray(),
                       int maxIters = 2000, double confidence = 0.995);
cv::Mat findHomography(cv::InputArray srcPoints, cv::InputArray dstPoints, cv::OutputArray mask,
                       const Method& method = "auto", double ransacReprojThreshold = 3);

/// The fundamental matrix F, x'^T F x = 0, as cv::findFundamentalMat(): 3 x 3, CV_64F, with F(2, 2) = 1 where
/// it is not 0, or empty.
/// @param ransacReprojThreshold  largest Sampson distance of an inlier, px
cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, const Method& method,
                           double ransacReprojThreshold, double confidence, int maxIters,
                           cv::OutputArray mask = cv::noArray());
cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, const Method& method = "auto",
                           double ransacReprojThreshold = 3, double confidence = 0.99,
                           cv::OutputArray mask = cv::noArray());
cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, cv::OutputArray mask,
                           const Method& method = "auto", double ransacReprojThreshold = 3,
                           double confidence = 0.99);

/// The essential matrix E, d'^T E d = 0 for directions d, as cv::findEssentialMat(): 3 x 3, CV_64F, of norm
/// 1, or empty. cv::recoverPose() takes it and the mask. "pose", the default, and "auto" also find out that
/// the camera did not move, and then return an empty matrix.
/// @param cameraMatrix  3 x 3, of both images
/// @param threshold     largest error of an inlier, tangent Sampson, px; in units of the focal length where
/// the
///                      points are normalised
cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix,
                         const Method& method, double prob, double threshold, int maxIters,
                         cv::OutputArray mask = cv::noArray());
cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix,
                         const Method& method = "pose", double prob = 0.999, double threshold = 1.0,
                         cv::OutputArray mask = cv::noArray());
cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, double focal = 1.0,
                         const cv::Point2d& pp = {}, const Method& method = "pose", double prob = 0.999,
                         double threshold = 1.0, int maxIters = 1000, cv::OutputArray mask = cv::noArray());
cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, double focal, const cv::Point2d& pp,
                         const Method& method, double prob, double threshold, cv::OutputArray mask);
/// @param distCoeffs1  0, 4, 5, 8, 12 or 14 numbers, see cameraFromOpenCv()
cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix1,
                         cv::InputArray distCoeffs1, cv::InputArray cameraMatrix2, cv::InputArray distCoeffs2,
                         const Method& method = "pose", double prob = 0.999, double threshold = 1.0,
                         cv::OutputArray mask = cv::noArray());

/// The matches that the selector "gms" keeps, as cv::xfeatures2d::matchGMS(): those of matches1to2 that agree
/// with their neighbours, in their order. O(N).
/// Throws std::invalid_argument for a match of a keypoint that does not exist.
void matchGMS(const cv::Size& size1, const cv::Size& size2, const std::vector<cv::KeyPoint>& keypoints1,
              const std::vector<cv::KeyPoint>& keypoints2, const std::vector<cv::DMatch>& matches1to2,
              std::vector<cv::DMatch>& matchesGMS, bool withRotation = false, bool withScale = false,
              double thresholdFactor = 6.0);

}  // namespace opencv
}  // namespace corrsel
