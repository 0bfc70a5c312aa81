#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "corrsel/opencv.h"
#include "corrsel/selectors/factory.h"
#include "geometry/essential.h"

namespace corrsel::opencv {
namespace {

using core::ModelKind;

/// OpenCV's numbers, as whole numbers so that its module calib3d is not needed.
constexpr int kLmeds = 4, kRansac = 8, kRho = 16, kFirstUsac = 32, kLastUsac = 38;
/// Of normalised points; longer focal lengths are those of pixels.
constexpr double kLongestNormalisedFocalLength = 10;
/// The focal length that such cameras get instead, so that the selectors' lengths in px make sense.
constexpr double kUsualFocalLength = 1000;
constexpr char kFitting[] = "usac";
/// Of a result for a number of OpenCV. Random matches have 0; six exact ones of a plane have 4.
constexpr double kLeastConfidence = 1;

struct Limits {
  double threshold;  ///< px; 0 = the selector's own
  int iterations;
  double confidence;
};

/// The hypotheses for which the option max_iterations = 0 stands.
int ownIterations(ModelKind kind) {
  return kind == ModelKind::kHomography ? 60000 : kind == ModelKind::kFundamental ? 40000 : 20000;
}

void requirePositionsOnly(const core::Selector& selector, const std::string& name, ModelKind kind) {
  std::vector<std::string> missing;
  for (const std::string& need : core::neededInput(selector)) {
    const bool given = kind == ModelKind::kEssential && need.find("camera") != std::string::npos;
    if (!given) missing.push_back(need);
  }
  if (!missing.empty()) {
    throw std::invalid_argument(
        "method '" + name + "' needs " + core::joinList(missing, " and ") +
        ", which the functions of OpenCV do not get; use corrsel::core::createSelector(), "
        "whose matches have them");
  }
}

bool hasChoice(const core::OptionField& field, const std::string& name) {
  return std::any_of(field.choices.begin(), field.choices.end(),
                     [&name](const core::OptionField::Named& choice) { return choice.name == name; });
}

/// The options with which a selector keeps to the kind of model and to the limits of a call.
/// @param as_opencv  whether errors of a homography are measured as OpenCV does, and a result that chance
/// explains is none
core::OptionMap restrictions(const core::Selector& selector, ModelKind kind, bool as_opencv,
                             const Limits& limits) {
  std::map<std::string, core::OptionField> fields;
  for (core::OptionField& field : core::optionFields(selector.options())) fields.emplace(field.name, field);
  core::OptionMap values;
  const auto model = fields.find("model");
  // Others fit no model, or find their thresholds themselves.
  if (model == fields.end() && selector.name() != "pose") return values;
  if (model != fields.end() && hasChoice(model->second, core::toString(kind)))
    values["model"] = core::toString(kind);
  const bool second_threshold = kind != ModelKind::kHomography && fields.count("fundamental_threshold") != 0;
  const std::string threshold = second_threshold ? "fundamental_threshold" : "threshold";
  if (limits.threshold > 0 && fields.count(threshold) != 0)
    values[threshold] = core::formatNumber(limits.threshold);
  const auto more = [&fields, &selector](const char* name, double value, double own) {
    const auto field = fields.find(name);
    if (field == fields.end()) return false;
    const double set = core::parseNumber(field->second.text(selector.options()), name);
    return value > (set > 0 ? set : own);
  };
  if (more("max_iterations", limits.iterations, ownIterations(kind)))
    values["max_iterations"] = std::to_string(limits.iterations);
  if (more("confidence", limits.confidence, 0)) values["confidence"] = core::formatNumber(limits.confidence);
  if (as_opencv) {
    values["min_confidence"] = core::formatNumber(kLeastConfidence);
    if (fields.count("error") != 0) values["error"] = "transfer";
  }
  return values;
}

std::unique_ptr<core::Selector> selectorFor(const std::string& name, ModelKind kind, bool as_opencv,
                                            const Limits& limits) {
  const auto plain = core::createSelector(name);
  requirePositionsOnly(*plain, name, kind);
  return core::createSelector(name, restrictions(*plain, kind, as_opencv, limits));
}

/// A model with the inliers among the matches; without a model they are all 0.
struct Found {
  std::optional<cv::Matx33d> model;
  std::vector<std::uint8_t> mask;
};

bool isResult(const core::Selection& selection) {
  return selection.status == core::Status::kOk || selection.status == core::Status::kTimeLimit;
}

std::optional<cv::Matx33d> modelOf(const core::Selection& selection, ModelKind kind) {
  if (kind == ModelKind::kEssential && selection.pose) {
    if (selection.pose->pose.translation == cv::Vec3d()) return std::nullopt;
    return core::essentialOf(selection.pose->pose);
  }
  if (selection.model_kind != kind) return std::nullopt;
  return selection.model;
}

/// Whether there are more different matches than a sample has. Otherwise any model of a sample would agree
/// with all.
bool canVerify(const core::Correspondences& matches, ModelKind kind) {
  const std::size_t sample = kind == ModelKind::kHomography ? 4 : kind == ModelKind::kFundamental ? 7 : 5;
  std::set<std::array<float, 4>> distinct;
  for (std::size_t i = 0; i < matches.size() && distinct.size() <= sample; ++i) {
    const std::array<float, 4> match = {matches.left_x[i], matches.left_y[i], matches.right_x[i],
                                        matches.right_y[i]};
    if (std::all_of(match.begin(), match.end(), [](float value) { return std::isfinite(value); }))
      distinct.insert(match);
  }
  return distinct.size() > sample;
}

/// The model of the wanted kind that a selection has, or one that is fitted to the matches that it kept.
Found find(const core::Correspondences& matches, const Method& method, ModelKind kind, const Limits& limits) {
  const auto selector = selectorFor(method.selector(), kind, method.isNumber(), limits);
  Found found{std::nullopt, std::vector<std::uint8_t>(matches.size(), 0)};
  if (!canVerify(matches, kind)) return found;
  const core::Selection selection = selector->select(matches);
  if (!isResult(selection)) return found;
  found.model = modelOf(selection, kind);
  if (found.model) {
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const bool other_group = !selection.group.empty() && selection.group[i] != 0;
      found.mask[i] = selection.mask[i] != 0 && !other_group ? 1 : 0;
    }
    return found;
  }
  if (selection.pose) return found;  // no translation, and so no essential matrix
  const std::vector<std::uint32_t> rows = core::selectedRows(selection.mask);
  const core::Selection fitted = selectorFor(kFitting, kind, true, limits)->select(matches.subset(rows));
  if (!isResult(fitted)) return found;
  found.model = modelOf(fitted, kind);
  for (std::size_t k = 0; found.model && k < rows.size(); ++k) found.mask[rows[k]] = fitted.mask[k];
  return found;
}

/// N x 2 of CV_32F.
cv::Mat pointsOf(cv::InputArray array, const std::string& name) {
  const cv::Mat given = array.getMat();
  if (given.empty()) return {};
  const int count = given.checkVector(2, -1, false);
  const bool number = given.depth() == CV_32S || given.depth() == CV_32F || given.depth() == CV_64F;
  if (count < 0 || !number) {
    throw std::invalid_argument(
        name + " has " + std::to_string(given.rows) + " x " + std::to_string(given.cols) + " elements of " +
        cv::typeToString(given.type()) + "; valid: N points (x, y) of int, float or double");
  }
  cv::Mat points;
  given.convertTo(points, CV_32F);
  return points.reshape(1, count);
}

core::Correspondences matchesOf(cv::InputArray left, cv::InputArray right, const std::string& left_name,
                                const std::string& right_name, double scale = 1) {
  const cv::Mat a = pointsOf(left, left_name), b = pointsOf(right, right_name);
  if (a.rows != b.rows) {
    throw std::invalid_argument(left_name + " has " + std::to_string(a.rows) + " points and " + right_name +
                                " has " + std::to_string(b.rows) +
                                "; valid: as many, one pair for each match");
  }
  core::Correspondences matches;
  const auto factor = static_cast<float>(scale);
  for (int i = 0; i < a.rows; ++i) {
    matches.add(cv::Point2f(a.at<float>(i, 0), a.at<float>(i, 1)) * factor,
                cv::Point2f(b.at<float>(i, 0), b.at<float>(i, 1)) * factor);
  }
  return matches;
}

cv::Mat answer(const Found& found, ModelKind kind, cv::OutputArray mask) {
  if (mask.needed()) cv::Mat(found.mask, true).copyTo(mask);
  if (!found.model) return {};
  const cv::Matx33d& model = *found.model;
  double scale = kind == ModelKind::kEssential ? cv::norm(model) : model(2, 2);
  if (scale == 0) scale = 1;
  return cv::Mat(model * (1 / scale), true);
}

cv::Matx33d cameraMatrix(cv::InputArray array, const std::string& name) {
  const cv::Mat given = array.getMat();
  if (given.size() != cv::Size(3, 3) || given.channels() != 1) {
    throw std::invalid_argument(name + " has " + std::to_string(given.rows) + " x " +
                                std::to_string(given.cols) + " elements; valid: a camera matrix of 3 x 3");
  }
  cv::Matx33d matrix;
  given.convertTo(cv::Mat(matrix, false), CV_64F);
  return matrix;
}

struct Calibration {
  cv::Matx33d matrix;
  std::vector<double> distortion;
};

Calibration calibration(cv::InputArray matrix, cv::InputArray distortion, const std::string& number) {
  Calibration result{cameraMatrix(matrix, "cameraMatrix" + number), {}};
  const cv::Mat given = distortion.getMat();
  if (!given.empty()) given.reshape(1, 1).convertTo(result.distortion, CV_64F);
  return result;
}

cv::Mat essential(cv::InputArray points1, cv::InputArray points2, const Calibration& left,
                  const Calibration& right, const Method& method, Limits limits, cv::OutputArray mask) {
  const double focal = left.matrix(0, 0);
  const bool normalised = focal > 0 && focal < kLongestNormalisedFocalLength;
  const double scale = normalised ? kUsualFocalLength / focal : 1;
  const cv::Matx33d zoom = cv::Matx33d::diag({scale, scale, 1});
  core::Correspondences matches = matchesOf(points1, points2, "points1", "points2", scale);
  matches.left_camera = core::cameraFromOpenCv(zoom * left.matrix, left.distortion);
  matches.right_camera = core::cameraFromOpenCv(zoom * right.matrix, right.distortion);
  limits.threshold *= scale;
  return answer(find(matches, method, ModelKind::kEssential, limits), ModelKind::kEssential, mask);
}

std::string selectorOf(int number) {
  if (number == kLmeds) return "acransac";
  if (number == kRansac || number == kRho || (number >= kFirstUsac && number <= kLastUsac)) return "usac";
  throw std::invalid_argument(
      "method is " + std::to_string(number) +
      "; valid: a robust method of OpenCV (LMEDS, RANSAC, RHO, USAC_*) or the name of a "
      "selector, e.g. \"auto\"; call OpenCV itself for the others, which reject no match");
}

}  // namespace

Method::Method(int number) : selector_(selectorOf(number)), is_number_(true) {}
Method::Method(const char* selector) : selector_(selector) {}
Method::Method(std::string selector) : selector_(std::move(selector)) {}

cv::Mat findHomography(cv::InputArray srcPoints, cv::InputArray dstPoints, const Method& method,
                       double ransacReprojThreshold, cv::OutputArray mask, int maxIters, double confidence) {
  const core::Correspondences matches = matchesOf(srcPoints, dstPoints, "srcPoints", "dstPoints");
  const Limits limits{ransacReprojThreshold, maxIters, confidence};
  return answer(find(matches, method, ModelKind::kHomography, limits), ModelKind::kHomography, mask);
}

cv::Mat findHomography(cv::InputArray srcPoints, cv::InputArray dstPoints, cv::OutputArray mask,
                       const Method& method, double ransacReprojThreshold) {
  return findHomography(srcPoints, dstPoints, method, ransacReprojThreshold, mask);
}

cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, const Method& method,
                           double ransacReprojThreshold, double confidence, int maxIters,
                           cv::OutputArray mask) {
  const core::Correspondences matches = matchesOf(points1, points2, "points1", "points2");
  const Limits limits{ransacReprojThreshold, maxIters, confidence};
  return answer(find(matches, method, ModelKind::kFundamental, limits), ModelKind::kFundamental, mask);
}

cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, const Method& method,
                           double ransacReprojThreshold, double confidence, cv::OutputArray mask) {
  return findFundamentalMat(points1, points2, method, ransacReprojThreshold, confidence, 0, mask);
}

cv::Mat findFundamentalMat(cv::InputArray points1, cv::InputArray points2, cv::OutputArray mask,
                           const Method& method, double ransacReprojThreshold, double confidence) {
  return findFundamentalMat(points1, points2, method, ransacReprojThreshold, confidence, 0, mask);
}

cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix,
                         const Method& method, double prob, double threshold, int maxIters,
                         cv::OutputArray mask) {
  const Calibration camera = calibration(cameraMatrix, cv::noArray(), "");
  return essential(points1, points2, camera, camera, method, {threshold, maxIters, prob}, mask);
}

cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix,
                         const Method& method, double prob, double threshold, cv::OutputArray mask) {
  return findEssentialMat(points1, points2, cameraMatrix, method, prob, threshold, 0, mask);
}

cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, double focal, const cv::Point2d& pp,
                         const Method& method, double prob, double threshold, int maxIters,
                         cv::OutputArray mask) {
  const Calibration camera{{focal, 0, pp.x, 0, focal, pp.y, 0, 0, 1}, {}};
  return essential(points1, points2, camera, camera, method, {threshold, maxIters, prob}, mask);
}

cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, double focal, const cv::Point2d& pp,
                         const Method& method, double prob, double threshold, cv::OutputArray mask) {
  return findEssentialMat(points1, points2, focal, pp, method, prob, threshold, 0, mask);
}

cv::Mat findEssentialMat(cv::InputArray points1, cv::InputArray points2, cv::InputArray cameraMatrix1,
                         cv::InputArray distCoeffs1, cv::InputArray cameraMatrix2, cv::InputArray distCoeffs2,
                         const Method& method, double prob, double threshold, cv::OutputArray mask) {
  return essential(points1, points2, calibration(cameraMatrix1, distCoeffs1, "1"),
                   calibration(cameraMatrix2, distCoeffs2, "2"), method, {threshold, 0, prob}, mask);
}

void matchGMS(const cv::Size& size1, const cv::Size& size2, const std::vector<cv::KeyPoint>& keypoints1,
              const std::vector<cv::KeyPoint>& keypoints2, const std::vector<cv::DMatch>& matches1to2,
              std::vector<cv::DMatch>& matchesGMS, bool withRotation, bool withScale,
              double thresholdFactor) {
  core::Correspondences matches;
  matches.left_size = size1;
  matches.right_size = size2;
  const auto point = [](const std::vector<cv::KeyPoint>& keypoints, int index, const char* name) {
    if (index < 0 || static_cast<std::size_t>(index) >= keypoints.size()) {
      throw std::invalid_argument("matches1to2 has the " + std::string(name) + " " + std::to_string(index) +
                                  ", but there are " + std::to_string(keypoints.size()) +
                                  " keypoints; give the keypoints that were matched");
    }
    return keypoints[static_cast<std::size_t>(index)].pt;
  };
  for (const cv::DMatch& match : matches1to2)
    matches.add(point(keypoints1, match.queryIdx, "queryIdx"), point(keypoints2, match.trainIdx, "trainIdx"));
  const auto flag = [](bool value) { return std::string(value ? "true" : "false"); };
  const core::Selection selection =
      core::createSelector("gms", {{"alpha", core::formatNumber(thresholdFactor)},
                                   {"rotation", flag(withRotation)},
                                   {"scale", flag(withScale)}})
          ->select(matches);
  std::vector<cv::DMatch> kept;  // the caller may give one vector for both
  for (const std::uint32_t row : core::selectedRows(selection.mask)) kept.push_back(matches1to2[row]);
  matchesGMS = std::move(kept);
}

}  // namespace corrsel::opencv
