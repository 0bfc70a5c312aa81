#include "datasets/files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImageExtensions[] = {".ppm", ".pgm", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff",
                                            ".PPM", ".PGM", ".PNG", ".JPG", ".JPEG", ".BMP", ".TIF", ".TIFF"};

bool isFile(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

[[noreturn]] void fail(const std::string& path, const std::string& fault, const std::string& remedy) {
  throw DatasetError(path + ": " + fault + "; " + remedy);
}

}  // namespace

void requireImageFile(const std::string& path, const std::string& remedy) {
  if (!isFile(path)) fail(path, "the image is missing", remedy);
}

std::string findImage(const std::string& stem) {
  for (const char* extension : kImageExtensions) {
    if (isFile(stem + extension)) return stem + extension;
  }
  return "";
}

std::string requireImage(const std::string& stem, const std::string& remedy) {
  const std::string path = findImage(stem);
  if (path.empty()) {
    fail(stem, "the image is missing (tried .ppm, .pgm, .png, .jpg, .jpeg, .bmp, .tif, .tiff)", remedy);
  }
  return path;
}

bool isImageExtension(const std::string& extension) {
  return std::find(std::begin(kImageExtensions), std::end(kImageExtensions), extension) !=
         std::end(kImageExtensions);
}

cv::Mat readImageFile(const std::string& path, const std::string& remedy) {
  requireImageFile(path, remedy);
  cv::Mat image;
  try {
    image = cv::imread(path, cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    fail(path, "the image cannot be decoded (" + error.err + ")", remedy);
  }
  if (image.empty()) fail(path, "the image cannot be decoded", remedy);
  return image;
}

cv::Matx33d readHomographyFile(const std::string& path, const std::string& remedy) {
  if (!isFile(path)) fail(path, "the homography is missing", remedy);
  std::ifstream stream(path);
  cv::Matx33d homography;
  int count = 0;
  for (std::string word; stream >> word; ++count) {
    if (count == 9) fail(path, "holds more than the 9 numbers of a homography", remedy);
    try {
      homography.val[count] = parseNumber(word, "entry " + std::to_string(count + 1));
    } catch (const std::invalid_argument& error) {
      fail(path, error.what(), remedy);
    }
  }
  if (count < 9) {
    fail(path, "holds " + std::to_string(count) + " numbers where a homography has 9", remedy);
  }
  checkHomography(homography, path, remedy);
  return homography;
}

void checkHomography(const cv::Matx33d& homography, const std::string& path, const std::string& remedy) {
  for (const double value : homography.val) {
    if (!std::isfinite(value)) fail(path, "the homography has an entry that is not finite", remedy);
  }
  // In kilopixels the entries of a valid homography are of similar size, so that the smallest singular value
  // reveals a rank deficiency whatever the scale.
  const cv::Matx33d to_kilopixels = cv::Matx33d::diag(cv::Vec3d(1e-3, 1e-3, 1.0));
  const cv::Matx33d to_pixels = cv::Matx33d::diag(cv::Vec3d(1e3, 1e3, 1.0));
  cv::Matx31d singular_values;
  cv::SVD::compute(to_kilopixels * homography * to_pixels, singular_values);
  if (!(singular_values(2) > 1e-8 * singular_values(0))) fail(path, "the homography is singular", remedy);
}

void requireFolder(const std::string& path, const std::string& what, const std::string& remedy) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    throw DatasetError(what + ": '" + path + "' is not a folder; " + remedy);
  }
}

std::vector<std::string> subfolders(const std::string& root) {
  std::vector<std::string> names;
  std::error_code error, ignored;
  for (fs::directory_iterator entry(root, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name[0] != '.' && entry->is_directory(ignored)) names.push_back(name);
  }
  if (error) {
    fail(root, "the folder cannot be listed (" + error.message() + ")", "check its path and permissions");
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> fileNames(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error, ignored;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_regular_file(ignored)) names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> existingFiles(const std::vector<std::string>& paths) {
  std::vector<std::string> existing;
  for (const std::string& path : paths) {
    if (isFile(path)) existing.push_back(path);
  }
  return existing;
}

}  // namespace corrsel::core
