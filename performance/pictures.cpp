#include "pictures.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

namespace corrsel::performance {
namespace {

namespace fs = std::filesystem;

PictureFolders& folders() {
  static PictureFolders value;
  return value;
}

cv::Mat readGrey(const fs::path& file) {
  cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) {
    throw std::runtime_error("cannot read " + file.string() +
                             "; the sample photographs come from scripts/fetch_samples.sh");
  }
  return image;
}

Picture samplePicture(const char* left, const char* right) {
  const fs::path folder(folders().samples);
  return {readGrey(folder / left), readGrey(folder / right)};
}

/// Scaled to the width, with the middle rows.
cv::Mat fitted(const cv::Mat& image, const cv::Size& size) {
  const double factor = std::max(double(size.width) / image.cols, double(size.height) / image.rows);
  const cv::Size whole(std::max(size.width, cvRound(image.cols * factor)),
                       std::max(size.height, cvRound(image.rows * factor)));
  cv::Mat scaled;
  cv::resize(image, scaled, whole, 0, 0, factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return scaled(cv::Rect({(whole.width - size.width) / 2, (whole.height - size.height) / 2}, size)).clone();
}

Picture make(const cv::Size& size) {
  const fs::path root(folders().data_root);
  if (size == cv::Size(800, 640)) {
    if (root.empty()) return samplePicture("graf1.png", "graf3.png");
    return {readGrey(root / "vgg" / "graf" / "img1.ppm"), readGrey(root / "vgg" / "graf" / "img2.ppm")};
  }
  if (size == cv::Size(1392, 512) && !root.empty()) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(root / "kitti_stereo")) {
      const std::string name = entry.path().filename().string();
      if (name.compare(0, 5, "left_") == 0) names.push_back(name.substr(5));
    }
    const std::string first = names.empty() ? "0.png" : *std::min_element(names.begin(), names.end());
    return {readGrey(root / "kitti_stereo" / ("left_" + first)),
            readGrey(root / "kitti_stereo" / ("right_" + first))};
  }
  const Picture aloe = samplePicture("aloeL.jpg", "aloeR.jpg");
  return {fitted(aloe.left, size), fitted(aloe.right, size)};
}

}  // namespace

void setPictureFolders(const PictureFolders& chosen) { folders() = chosen; }

const Picture& picture(const cv::Size& size) {
  static std::map<std::pair<int, int>, Picture> made;
  Picture& entry = made[{size.width, size.height}];
  if (entry.left.empty()) entry = make(size);
  if (entry.left.size() != size) {
    throw std::invalid_argument("there is no photograph of " + std::to_string(size.width) + "x" +
                                std::to_string(size.height) + " px");
  }
  return entry;
}

}  // namespace corrsel::performance
