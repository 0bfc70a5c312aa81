#include "datasets/sample.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "corrsel/camera_formats.h"
#include "corrsel/random.h"
#include "datasets/files.h"
#include "datasets/generator.h"
#include "datasets/lens.h"
#include "datasets/real_samples.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGrafLeft = "graf1.png";
constexpr const char* kGrafRight = "graf3.png";
constexpr const char* kGrafHomography = "H1to3p.xml";
constexpr const char* kAloeLeft = "aloeL.jpg";
constexpr const char* kAloeRight = "aloeR.jpg";
constexpr const char* kAloeDisparity = "aloeGT.png";

// The pair is Aloe of Middlebury's set of 2006 at full size. The set states for all scenes (Scharstein and
// Pal, Learning conditional random fields for stereo, CVPR 2007): the focal length and the baseline, and that
// each scene's disparities had a number of px, its dmin, subtracted.
constexpr double kAloeFocalLength = 3740;    // px
constexpr double kAloeBaseline = 0.16;       // m
constexpr double kAloeDisparityShift = 270;  // px

enum class Nuisance { kZoomRotation, kBlur, kViewpoint, kLight, kJpeg, kZoom, kRotation };

struct Sequence {
  const char* name;
  const char* photograph;
  Nuisance nuisance;
};

// Small, distant views need a photograph of high resolution; changes of the viewpoint need one that is mostly
// planar.
constexpr Sequence kSequences[] = {
    {"zoom_rotation_1", "building.jpg", Nuisance::kZoomRotation},
    {"zoom_rotation_2", "scenetext04.jpg", Nuisance::kZoomRotation},
    {"blur_1", "baboon.jpg", Nuisance::kBlur},
    {"blur_2", "scenetext_segmented_word01.jpg", Nuisance::kBlur},
    {"viewpoint_1", "board.jpg", Nuisance::kViewpoint},
    {"viewpoint_2", "scenetext01.jpg", Nuisance::kViewpoint},
    {"light", "leuvenA.jpg", Nuisance::kLight},
    {"jpeg", "home.jpg", Nuisance::kJpeg},
    {"zoom", "scenetext03.jpg", Nuisance::kZoom},
    {"rotation", "aero1.jpg", Nuisance::kRotation},
};

constexpr int kStrengths = 5;
constexpr std::size_t kTakenPairs = 2;  // graf and aloe precede the generated pairs
static_assert(SampleReader::kFirstReal == kTakenPairs + std::size(kSequences) * kStrengths);

constexpr double kZoomRotationScale[kStrengths] = {1.2, 1.6, 2.1, 2.8, 3.5};  // size left / size right
constexpr double kZoomRotationAngle[kStrengths] = {15, 30, 45, 60, 75};       // degrees, either way
constexpr double kZoomScale[kStrengths] = {1.5, 2.0, 2.6, 3.3, 4.0};          // size left / size right
constexpr double kRotationAngle[kStrengths] = {36, 72, 108, 144, 180};        // degrees
constexpr double kTiltAngle[kStrengths] = {15, 27.5, 40, 52.5, 65};           // degrees
constexpr double kBlurSigma[kStrengths] = {1.0, 2.0, 3.0, 4.5, 6.0};          // px
constexpr double kLightGain[kStrengths] = {0.8, 0.65, 0.5, 0.35, 0.25};
constexpr double kLightGamma[kStrengths] = {1.0, 1.15, 1.3, 1.45, 1.6};
constexpr int kJpegQuality[kStrengths] = {40, 20, 10, 5, 3};  // of 100

constexpr double kJitter = 0.03;  // how far a corner moves at most, part of the image width

const Sequence& sequenceOf(std::size_t index) { return kSequences[(index - kTakenPairs) / kStrengths]; }

/// 0 to 4.
int strengthOf(std::size_t index) { return static_cast<int>((index - kTakenPairs) % kStrengths); }

/// What a pinhole camera sees of a plane, at first parallel to the image, after it has been tilted about an
/// axis through its centre. A focal length of 1.5 times the longer side keeps the plane in front of the
/// camera at every tilt.
cv::Matx33d tilt(double degrees, double axis_radians, const cv::Size& size) {
  const double focal_length = 1.5 * std::max(size.width, size.height);
  const double c = std::cos(degrees * CV_PI / 180.0);
  const double s = std::sin(degrees * CV_PI / 180.0);
  const double ux = std::cos(axis_radians);
  const double uy = std::sin(axis_radians);
  // First two columns of the rotation about (ux, uy, 0), and the plane's distance: one focal length.
  const cv::Matx33d pose{c + ux * ux * (1 - c),
                         ux * uy * (1 - c),
                         0,
                         ux * uy * (1 - c),
                         c + uy * uy * (1 - c),
                         0,
                         -uy * s,
                         ux * s,
                         focal_length};
  return aboutCentre(cv::Matx33d::diag(cv::Vec3d(focal_length, focal_length, 1.0)) * pose, size);
}

/// The homography that maps four points to four others, by Gaussian elimination with partial pivoting.
/// OpenCV's solver fuses multiplications with additions on some processors. The products of coordinates are
/// of single precision, like those of cv::getPerspectiveTransform, with which the sample set was defined.
cv::Matx33d homographyThrough(const cv::Point2f (&from)[4], const cv::Point2f (&to)[4]) {
  // u (h20 x + h21 y + 1) = h00 x + h01 y + h02, and likewise v with the second row of H.
  double rows[8][9] = {};
  for (int i = 0; i < 4; ++i) {
    const float x = from[i].x, y = from[i].y, u = to[i].x, v = to[i].y;
    const double of_u[9] = {x, y, 1, 0, 0, 0, -x * u, -y * u, u};
    const double of_v[9] = {0, 0, 0, x, y, 1, -x * v, -y * v, v};
    std::copy_n(of_u, 9, rows[i]);
    std::copy_n(of_v, 9, rows[i + 4]);
  }
  for (int i = 0; i < 8; ++i) {
    int pivot = i;
    for (int j = i + 1; j < 8; ++j) {
      if (std::abs(rows[j][i]) > std::abs(rows[pivot][i])) pivot = j;
    }
    std::swap(rows[i], rows[pivot]);
    const double inverse = 1 / rows[i][i];
    for (int j = i + 1; j < 8; ++j) {
      const double factor = rows[j][i] * inverse;
      for (int k = i + 1; k < 9; ++k) rows[j][k] -= factor * rows[i][k];
    }
  }
  cv::Matx33d homography = cv::Matx33d::eye();
  for (int i = 7; i >= 0; --i) {
    double rest = rows[i][8];
    for (int k = i + 1; k < 8; ++k) rest -= rows[i][k] * homography.val[k];
    homography.val[i] = rest / rows[i][i];
  }
  return homography;
}

/// Moves each corner a little, so that the identity is not a correct model of the blur, light and JPEG pairs.
cv::Matx33d jitter(Random& random, const cv::Size& size) {
  const float right = static_cast<float>(size.width - 1);
  const float bottom = static_cast<float>(size.height - 1);
  const cv::Point2f from[4] = {{0, 0}, {right, 0}, {right, bottom}, {0, bottom}};
  cv::Point2f to[4];
  for (int i = 0; i < 4; ++i) {
    const double dx = random.uniform(-kJitter, kJitter) * size.width;
    const double dy = random.uniform(-kJitter, kJitter) * size.width;
    to[i] = from[i] + cv::Point2f(static_cast<float>(dx), static_cast<float>(dy));
  }
  return homographyThrough(from, to);
}

cv::Matx33d drawHomography(Nuisance nuisance, int strength, const cv::Size& size, Random& random) {
  switch (nuisance) {
    case Nuisance::kZoomRotation: {
      const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
      return similarity(kZoomRotationScale[strength], sign * kZoomRotationAngle[strength], size);
    }
    case Nuisance::kZoom:
      return similarity(kZoomScale[strength], 0.0, size);
    case Nuisance::kRotation:
      return similarity(1.0, kRotationAngle[strength], size);
    case Nuisance::kViewpoint:
      return tilt(kTiltAngle[strength], random.uniform(0.0, 2.0 * CV_PI), size);
    case Nuisance::kBlur:
    case Nuisance::kLight:
    case Nuisance::kJpeg:
      break;
  }
  return jitter(random, size);
}

void darken(cv::Mat& image, double gain, double gamma) {
  cv::Mat table(1, 256, CV_8U);
  for (int level = 0; level < 256; ++level) {
    table.at<std::uint8_t>(level) =
        cv::saturate_cast<std::uint8_t>(255.0 * gain * std::pow(level / 255.0, gamma));
  }
  cv::LUT(image, table, image);
}

cv::Mat compress(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> buffer;
  cv::imencode(".jpg", image, buffer, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(buffer, cv::IMREAD_ANYCOLOR);
}

/// The order is that of a camera: optics and light, then the sensor's noise, then the file.
cv::Mat applyNuisance(cv::Mat image, Nuisance nuisance, int strength, Random& random) {
  if (nuisance == Nuisance::kBlur) image = blur(image, kBlurSigma[strength], cv::BORDER_REFLECT_101);
  if (nuisance == Nuisance::kLight) darken(image, kLightGain[strength], kLightGamma[strength]);
  addNoise(image, random);
  return nuisance == Nuisance::kJpeg ? compress(image, kJpegQuality[strength]) : image;
}

cv::Matx33d readGrafHomography(const std::string& path) {
  if (existingFiles({path}).empty())
    throw DatasetError(path + ": the homography is missing; " + kSampleRemedy);
  cv::Mat matrix;
  try {
    cv::FileStorage(path, cv::FileStorage::READ)["H13"] >> matrix;
  } catch (const cv::Exception& error) {
    throw DatasetError(path + ": cannot be parsed (" + error.err + "); " + kSampleRemedy);
  }
  if (matrix.rows != 3 || matrix.cols != 3 || matrix.channels() != 1) {
    throw DatasetError(path + ": has no 3x3 matrix 'H13'; " + kSampleRemedy);
  }
  matrix.convertTo(matrix, CV_64F);
  const cv::Matx33d homography = matrix;
  checkHomography(homography, path, kSampleRemedy);
  return homography;
}

/// The grey level is the disparity in px (0 = unknown): over 5070 SIFT matches (ratio test 0.6, rows within
/// 1 px) the level divided by left x minus right x has the median 0.996, 90 % of them 0.985 to 1.007.
cv::Mat readDisparity(const std::string& path, const cv::Size& size) {
  const cv::Mat levels = readImageFile(path, kSampleRemedy);
  if (levels.channels() != 1 || levels.size() != size) {
    throw DatasetError(path + ": is not a grey image of the left image's size; " + kSampleRemedy);
  }
  cv::Mat disparity;
  levels.convertTo(disparity, CV_32F);
  disparity.setTo(std::numeric_limits<float>::quiet_NaN(), levels == 0);
  return disparity;
}

/// A sideways step. The subtracted disparity is a difference of the principal points. Where these lie is not
/// published; their mean is taken to be the centre of the image, which is where the centres of both
/// photographs lie before the columns without a counterpart are cut off.
RelativePose aloePose(const cv::Size& size) {
  RelativePose pose;
  const double x = 0.5 * (size.width - 1), y = 0.5 * (size.height - 1), half = 0.5 * kAloeDisparityShift;
  pose.left_camera = {kAloeFocalLength, 0, x - half, 0, kAloeFocalLength, y, 0, 0, 1};
  pose.right_camera = {kAloeFocalLength, 0, x + half, 0, kAloeFocalLength, y, 0, 0, 1};
  pose.translation = {-kAloeBaseline, 0, 0};
  return pose;
}

}  // namespace

std::string sampleFolder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  const char* const home = std::getenv("HOME");
  const fs::path root = cache && *cache ? fs::path(cache) : fs::path(home && *home ? home : ".") / ".cache";
  return (root / "corrsel" / "sample").string();
}

SampleReader::SampleReader(const std::string& root, int seed) : root_(root), seed_(seed) {
  requireFolder(root, "sample dataset", kSampleRemedy);
  if (SampleReader::files().empty()) {
    throw DatasetError("sample dataset: '" + root + "' has none of the sample images; " + kSampleRemedy);
  }
}

std::vector<std::string> SampleReader::imageNames() {
  std::vector<std::string> names = {kGrafLeft, kGrafRight, kGrafHomography,
                                    kAloeLeft, kAloeRight, kAloeDisparity};
  for (const Sequence& sequence : kSequences) names.push_back(sequence.photograph);
  for (const RealSample& sample : realSamples()) {
    names.push_back(sample.left);
    names.push_back(sample.right);
  }
  return names;
}

std::vector<std::string> SampleReader::trainingImages() {
  std::vector<std::string> names = {kGrafLeft, kGrafRight, kAloeLeft, kAloeRight};
  for (const Sequence& sequence : kSequences) names.push_back(sequence.photograph);
  return names;
}

std::size_t SampleReader::size() const { return kFirstReal + realSamples().size(); }

PairId SampleReader::id(std::size_t index) const {
  if (index >= size()) throw std::out_of_range("sample dataset: no pair " + std::to_string(index));
  if (index == 0) return {"sample", "graf", "1-3"};
  if (index == 1) return {"sample", "aloe", "L-R"};
  if (index >= kFirstReal) {
    const RealSample& sample = realSamples()[index - kFirstReal];
    return {"sample", sample.sequence, sample.pair};
  }
  return {"sample", sequenceOf(index).name, "0-" + std::to_string(strengthOf(index) + 1)};
}

ImagePair SampleReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  if (index == 0) {
    pair.left = readImageFile(path(kGrafLeft), kSampleRemedy);
    pair.right = readImageFile(path(kGrafRight), kSampleRemedy);
    pair.truth.kind = TruthKind::kHomography;
    pair.truth.matrix = readGrafHomography(path(kGrafHomography));
    pair.left_name = kGrafLeft;
    pair.right_name = kGrafRight;
    return pair;
  }
  if (index == 1) {
    pair.left = readImageFile(path(kAloeLeft), kSampleRemedy);
    pair.right = readImageFile(path(kAloeRight), kSampleRemedy);
    pair.truth.kind = TruthKind::kDisparity;
    pair.truth.disparity = readDisparity(path(kAloeDisparity), pair.left.size());
    pair.truth.pose = aloePose(pair.left.size());
    pair.left_camera = cameraFromOpenCv(pair.truth.pose->left_camera, {}, pair.left.size());
    pair.right_camera = cameraFromOpenCv(pair.truth.pose->right_camera, {}, pair.right.size());
    pair.left_name = kAloeLeft;
    pair.right_name = kAloeRight;
    return pair;
  }
  if (index >= kFirstReal) {
    const RealSample& sample = realSamples()[index - kFirstReal];
    pair.left = readImageFile(path(sample.left), kSampleRemedy);
    pair.right = readImageFile(path(sample.right), kSampleRemedy);
    pair.left_name = sample.left;
    pair.right_name = sample.right;
    addRealTruth(sample, root_, kSampleRemedy, pair);
    return pair;
  }
  const Sequence& sequence = sequenceOf(index);
  const int strength = strengthOf(index);
  Random random = engineOf(seed_, sequence.name, strength);
  const cv::Mat photograph = readImageFile(path(sequence.photograph), kSampleRemedy);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = drawHomography(sequence.nuisance, strength, photograph.size(), random);
  pair.left = antialiased(photograph, pair.truth.matrix);
  pair.right = applyNuisance(warp(pair.left, pair.truth.matrix), sequence.nuisance, strength, random);
  return pair;
}

void SampleReader::check(std::size_t index) const {
  static_cast<void>(id(index));  // throws where there is no such pair
  std::vector<const char*> names;
  if (index == 0) {
    names = {kGrafLeft, kGrafRight};
    readGrafHomography(path(kGrafHomography));
  } else if (index == 1) {
    names = {kAloeLeft, kAloeRight, kAloeDisparity};
  } else if (index >= kFirstReal) {
    const RealSample& sample = realSamples()[index - kFirstReal];
    names = {sample.left, sample.right};
  } else {
    names = {sequenceOf(index).photograph};
  }
  for (const char* name : names) requireImageFile(path(name), kSampleRemedy);
}

std::vector<std::string> SampleReader::files() const {
  std::vector<std::string> paths;
  for (const std::string& name : imageNames()) paths.push_back(path(name.c_str()));
  return existingFiles(paths);
}

std::string SampleReader::path(const char* name) const {
  return (std::filesystem::path(root_) / name).string();
}

}  // namespace corrsel::core
