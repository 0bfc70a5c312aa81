#include "datasets/real_samples.h"

#include <filesystem>

#include "base/size_text.h"
#include "corrsel/camera_formats.h"
#include "corrsel/datasets/reader.h"
#include "datasets/posed_truth.h"

namespace corrsel::core {
namespace {

constexpr const char* kRig = "rig";
constexpr const char* kBox = "box";

const cv::Size kRigSize(640, 480);

// What follows is the output of scripts/maintenance/sample_truth.py with OpenCV 4.6.

// The reprojection error of the 54 corners in 13 pairs is 0.215 px (RMS). SIFT matches beside the board,
// which took no part, lie 0.25 to 0.39 px from the epipolar line (median of each view but 05, of those within
// 5 px).
const cv::Matx33d kLeftMatrix(533.563306, 0, 342.534312, 0, 533.596638, 234.765094, 0, 0, 1);
const std::vector<double> kLeftDistortion = {-0.288654869, 0.093599525, 0.0012033062, -0.000143787438};
const cv::Matx33d kRightMatrix(536.89428, 0, 327.395757, 0, 536.475288, 249.948371, 0, 0, 1);
const std::vector<double> kRightDistortion = {-0.290087999, 0.106198036, -0.000509396253, 0.000104936491};
const cv::Matx33d kRigRotation(0.999984714, 0.00352252462, 0.00426188812, -0.00349192589, 0.999968228,
                               -0.00716588275, -0.00428699471, 0.00715089101, 0.999965243);
const cv::Vec3d kRigTranslation(-3.32710991, 0.0367240843, -0.0047615149);  // squares of the board

// SIFT matches within 5 px lie 0.50 px (box) and 0.20 px (page) from where the homography puts them (median).
// It lies at most 1.67 px (box) and 0.29 px (page) from the one that fits these matches.
const cv::Matx33d kBoxHomography(0.442743361, -0.170632288, 119.306786, 0.0109762037, 0.391429871, 160.231262,
                                 -0.000221481096, -0.000396945921, 1);
const cv::Matx33d kPageHomography(0.941727579, -0.0699901953, 9.61705112, 0.0298610851, 0.936058879,
                                  -2.31006479, -8.45478498e-05, -0.000127271051, 1);

void requireSize(const cv::Mat& image, const cv::Size& size, const std::string& path,
                 const std::string& remedy) {
  if (image.size() == size) return;
  throw DatasetError(path + ": has " + sizeText(image.size()) + " px, and its ground truth is for " +
                     sizeText(size) + " px; " + remedy);
}

void addRigTruth(ImagePair& pair) {
  pair.left_camera = cameraFromOpenCv(kLeftMatrix, kLeftDistortion, kRigSize);
  pair.right_camera = cameraFromOpenCv(kRightMatrix, kRightDistortion, kRigSize);
  RelativePose pose;
  pose.rotation = kRigRotation;
  pose.translation = kRigTranslation;
  pair.truth = truthOf(pose, *pair.left_camera, *pair.right_camera);
  // Estimating poses from these matches would take longer than the rest of a run on the sample set.
  pair.truth.pose.reset();
}

/// The sizes of both images.
std::pair<cv::Size, cv::Size> sizesOf(const std::string& sequence) {
  if (sequence == kRig) return {kRigSize, kRigSize};
  if (sequence == kBox) return {{324, 223}, {512, 384}};
  return {{105, 177}, {105, 177}};
}

}  // namespace

const std::vector<RealSample>& realSamples() {
  static const std::vector<RealSample> samples = {
      {kRig, "01", "left01.jpg", "right01.jpg"},    {kRig, "02", "left02.jpg", "right02.jpg"},
      {kRig, "03", "left03.jpg", "right03.jpg"},    {kRig, "04", "left04.jpg", "right04.jpg"},
      {kRig, "06", "left06.jpg", "right06.jpg"},    {kRig, "07", "left07.jpg", "right07.jpg"},
      {kRig, "08", "left08.jpg", "right08.jpg"},    {kRig, "09", "left09.jpg", "right09.jpg"},
      {kRig, "11", "left11.jpg", "right11.jpg"},    {kRig, "12", "left12.jpg", "right12.jpg"},
      {kRig, "13", "left13.jpg", "right13.jpg"},    {kRig, "14", "left14.jpg", "right14.jpg"},
      {kBox, "1-2", "box.png", "box_in_scene.png"}, {"page", "5-6", "LR_05.png", "LR_06.png"}};
  return samples;
}

void addRealTruth(const RealSample& sample, const std::string& root, const std::string& remedy,
                  ImagePair& pair) {
  const auto [left, right] = sizesOf(sample.sequence);
  const std::filesystem::path folder(root);
  requireSize(pair.left, left, (folder / sample.left).string(), remedy);
  requireSize(pair.right, right, (folder / sample.right).string(), remedy);
  if (sample.sequence == std::string(kRig)) return addRigTruth(pair);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = sample.sequence == std::string(kBox) ? kBoxHomography : kPageHomography;
}

}  // namespace corrsel::core
