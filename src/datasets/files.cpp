#include "datasets/files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/stretching.h"
#include "features/parts/image_bytes.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr int kEightBits = cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION;

constexpr const char* kImageExtensions[] = {".ppm", ".pgm", ".png",  ".jpg", ".jpeg",
                                            ".bmp", ".tif", ".tiff", ".webp"};

// Of the ratio of singular values. A matrix written with four digits passes; one with fewer moves its
// epipolar lines by more than a pixel in an image of 1000 px.
constexpr double kRankTolerance = 1e-3;

bool isFile(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Files `stem` plus any extension, in byte order.
std::vector<std::string> filesOf(const std::string& stem) {
  const fs::path path(stem);
  std::vector<std::string> paths;
  for (const std::string& name : fileNames(path.parent_path().string())) {
    const fs::path file(name);
    if (file.has_extension() && file.stem() == path.filename()) {
      paths.push_back((path.parent_path() / file).string());
    }
  }
  return paths;
}

[[noreturn]] void fail(const std::string& path, const std::string& fault, const std::string& remedy) {
  throw DatasetError(path + ": " + fault + "; " + remedy);
}

/// Reads nine finite numbers, row by row.
/// @param what  what the matrix is, for the error text
cv::Matx33d readMatrix(const std::string& path, const std::string& what, const std::string& remedy) {
  if (!isFile(path)) fail(path, "the " + what + " is missing", remedy);
  std::ifstream stream(path);
  cv::Matx33d matrix;
  int count = 0;
  for (std::string word; stream >> word; ++count) {
    if (count == 9) fail(path, "holds more than the 9 numbers of a " + what, remedy);
    try {
      matrix.val[count] = parseNumber(word, "entry " + std::to_string(count + 1));
    } catch (const std::invalid_argument& error) {
      fail(path, error.what(), remedy);
    }
    if (!std::isfinite(matrix.val[count])) {
      fail(path, "the " + what + " has an entry that is not finite", remedy);
    }
  }
  if (count < 9) fail(path, "holds " + std::to_string(count) + " numbers where a " + what + " has 9", remedy);
  return matrix;
}

/// A number with three digits, for error texts.
std::string roughText(double value) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

/// Singular values of the matrix for coordinates in units of `unit` px.
cv::Matx31d singularValues(const cv::Matx33d& fundamental, double unit) {
  const cv::Matx33d to_pixels = cv::Matx33d::diag(cv::Vec3d(unit, unit, 1.0));
  cv::Matx31d values;
  cv::SVD::compute(to_pixels * fundamental * to_pixels, values);
  return values;
}

/// @param remedy     for a missing file
/// @param undecoded  what is added to the cause where the image cannot be decoded
/// @param flags      of cv::imdecode
cv::Mat readImage(const std::string& path, const std::string& remedy, const std::string& undecoded,
                  int flags) {
  requireImageFile(path, remedy);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(path, "the image cannot be opened", "check the permissions of the file");
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  const std::string fault = "the image cannot be decoded: ";
  const auto failUndecoded = [&] {
    throw DatasetError(path + ": " + fault + undecodableCause(bytes) + undecoded);
  };
  if (bytes.empty() || isCutOff(bytes)) failUndecoded();
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception& error) {
    fail(path, fault + error.err, remedy);
  }
  if (image.empty()) failUndecoded();
  return image;
}

}  // namespace

void requireImageFile(const std::string& path, const std::string& remedy) {
  if (!isFile(path)) fail(path, "the image is missing", remedy);
}

std::string imageExtensions() { return joinList({std::begin(kImageExtensions), std::end(kImageExtensions)}); }

bool isImageExtension(const std::string& extension) {
  std::string lower = extension;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return std::find(std::begin(kImageExtensions), std::end(kImageExtensions), lower) !=
         std::end(kImageExtensions);
}

bool isImageOf(const std::string& name, const std::string& stem) {
  const fs::path file(name);
  return file.stem() == stem && isImageExtension(file.extension().string());
}

std::vector<std::string> imagesOf(const std::string& stem) {
  std::vector<std::string> paths;
  for (const std::string& path : filesOf(stem)) {
    if (isImageExtension(fs::path(path).extension().string())) paths.push_back(path);
  }
  return paths;
}

std::string requireImage(const std::string& stem, const std::string& remedy) {
  const std::vector<std::string> paths = imagesOf(stem);
  if (paths.size() == 1) return paths.front();
  if (!paths.empty()) {
    std::vector<std::string> names;
    for (const std::string& path : paths) names.push_back(fs::path(path).filename().string());
    fail(stem, joinList(names, " and ") + " are several files for one image",
         "keep the one to which the ground truth belongs");
  }
  const std::vector<std::string> others = filesOf(stem);
  if (others.empty()) fail(stem, "the image is missing (tried " + imageExtensions() + ")", remedy);
  fail(others.front(), "files of this type are not read as images; " + imageExtensions() + " are",
       "convert the image to PNG");
}

cv::Mat readImageFile(const std::string& path, const std::string& remedy) {
  return readImage(path, remedy, "; " + remedy, kEightBits);
}

void readImages(const std::string& root, const std::string& left, const std::string& right,
                const std::string& remedy, ImagePair& pair) {
  const auto stored = [&remedy](const std::string& path) {
    return StoredImage{path, [&](bool all_bits) {
                         return readImage(path, remedy, "",
                                          kEightBits | (all_bits ? cv::IMREAD_ANYDEPTH : 0));
                       }};
  };
  readStretched(stored(left), stored(right), pair);
  pair.left_name = fs::path(left).lexically_relative(root).generic_string();
  pair.right_name = fs::path(right).lexically_relative(root).generic_string();
}

cv::Matx33d readHomographyFile(const std::string& path, const std::string& remedy) {
  const cv::Matx33d homography = readMatrix(path, "homography", remedy);
  checkHomography(homography, path, remedy);
  return homography;
}

cv::Matx33d readFundamentalFile(const std::string& path, const std::string& remedy) {
  const cv::Matx33d fundamental = readMatrix(path, "fundamental matrix", remedy);
  // In kilopixels the entries of a valid matrix are of similar size. In pixels a homography, whose last
  // singular value in kilopixels is as small, is told apart.
  const cv::Matx31d values = singularValues(fundamental, 1e3), in_pixels = singularValues(fundamental, 1);
  if (!(values(1) > 1e-8 * values(0))) fail(path, "the fundamental matrix has a rank below 2", remedy);
  const double ratio = std::max(values(2) / values(1), in_pixels(2) / in_pixels(1));
  if (ratio > kRankTolerance) {
    fail(path,
         "the fundamental matrix does not have rank 2: its third singular value is " + roughText(ratio) +
             " of the second, at most " + formatNumber(kRankTolerance) + " is allowed",
         "write all digits of the matrix, or set its smallest singular value to zero; a homography is called "
         "H.txt");
  }
  return fundamental;
}

void checkHomography(const cv::Matx33d& homography, const std::string& path, const std::string& remedy) {
  for (const double value : homography.val) {
    if (!std::isfinite(value)) fail(path, "the homography has an entry that is not finite", remedy);
  }
  // In kilopixels the entries of a valid homography are of similar size, so that the smallest singular value
  // reveals a rank deficiency whatever the scale.
  const cv::Matx33d to_kilopixels = cv::Matx33d::diag(cv::Vec3d(1e-3, 1e-3, 1.0));
  const cv::Matx33d to_pixels = cv::Matx33d::diag(cv::Vec3d(1e3, 1e3, 1.0));
  const auto isSingular = [&](const cv::Matx33d& matrix) {
    cv::Matx31d singular_values;
    cv::SVD::compute(to_kilopixels * matrix * to_pixels, singular_values);
    return !(singular_values(2) > 1e-8 * singular_values(0));
  };
  if (!isSingular(homography)) return;
  const bool by_columns = !isSingular(homography.t());
  fail(
      path,
      std::string("the homography is singular") +
          (by_columns ? ", but its transpose is not: the numbers are probably written column by column" : ""),
      remedy);
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

std::string describeDataRoot(const std::string& root) {
  constexpr std::size_t kShown = 20;
  std::error_code ignored;
  if (!fs::exists(root, ignored)) return "'" + root + "' does not exist";
  if (!fs::is_directory(root, ignored)) return "'" + root + "' is a file";
  std::vector<std::string> names = subfolders(root);
  if (names.empty()) return "'" + root + "' holds no folder";
  const std::size_t more = names.size() - std::min(names.size(), kShown);
  names.resize(names.size() - more);
  return "'" + root + "' holds the folders " + joinList(names) +
         (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

std::string roundedText(double value) {
  char buffer[320];
  std::snprintf(buffer, sizeof(buffer), "%.2f", value);
  return buffer;
}

std::string below(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

std::string folderName(const std::string& folder) {
  return (fs::absolute(folder) / "").lexically_normal().parent_path().filename().string();
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
