#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// Reads both images of a pair as readImageFile() does, except that images that use fewer than their 16 bits
/// are stretched (readStretched()). The images get the names of their files.
/// @param root         the dataset's folder, which the names do not contain
/// @param left, right  paths
/// @param remedy       what the user can do about a missing file
void readImages(const std::string& root, const std::string& left, const std::string& right,
                const std::string& remedy, ImagePair& pair);

/// Reads an image as it is stored: 8 bit, one channel or three (BGR); deeper images are scaled to 8 bit, an
/// alpha channel is dropped and an Exif orientation is not applied, since ground truth counts stored pixels.
/// Throws DatasetError naming the file when it is missing, and with the cause when it cannot be decoded.
/// @param remedy  the last part of the error: what the user can do about a missing or damaged file
cv::Mat readImageFile(const std::string& path, const std::string& remedy);

/// Throws DatasetError naming the file when it is missing. It is not opened.
void requireImageFile(const std::string& path, const std::string& remedy);

/// The image files `stem` plus an extension that isImageExtension() accepts, in byte order.
/// @param stem  path without extension
std::vector<std::string> imagesOf(const std::string& stem);

/// The only one of them. Throws DatasetError naming the stem and the extensions tried where there is none,
/// the file where one of another type is there instead, and the files where there are several.
std::string requireImage(const std::string& stem, const std::string& remedy);

/// The extensions of images that are read, for texts: ".ppm, .pgm, ...".
std::string imageExtensions();

/// Whether `extension` (with its dot, in lower or upper case) is one of them.
bool isImageExtension(const std::string& extension);

/// Reads a homography from a text file of nine numbers, row by row, separated by white space. The matrix is
/// kept as written. Throws DatasetError naming the file when it is missing, or holds anything but nine finite
/// numbers of a regular matrix.
cv::Matx33d readHomographyFile(const std::string& path, const std::string& remedy);

/// Reads a fundamental matrix (x'^T F x = 0, px) in the same form. Throws DatasetError naming the file when
/// it is missing, or holds anything but nine finite numbers of a matrix of rank 2. The third singular value
/// may be a thousandth of the second.
cv::Matx33d readFundamentalFile(const std::string& path, const std::string& remedy);

/// Throws DatasetError naming `path` when the matrix has an entry that is not finite or is singular as a map
/// between images of the usual size (hundreds to thousands of px).
void checkHomography(const cv::Matx33d& homography, const std::string& path, const std::string& remedy);

/// Throws DatasetError when `path` is not a folder.
/// @param what  the dataset, for the error text, e.g. "VGG dataset"
void requireFolder(const std::string& path, const std::string& what, const std::string& remedy);

/// Whether a file name is `stem` plus one of these extensions.
bool isImageOf(const std::string& name, const std::string& stem);

/// What the files of a folder lack to be a pair in a layout.
struct FolderFit {
  std::size_t present = 0;           ///< files of the layout
  std::vector<std::string> lacking;  ///< of the pair that is nearest to complete, in words
  bool whole() const { return present > 0 && lacking.empty(); }
};

/// Names of the folders in `root`, in byte order, without those whose names begin with a dot. Throws
/// DatasetError when `root` cannot be listed.
std::vector<std::string> subfolders(const std::string& root);

/// What a folder is that should hold one folder per dataset, for messages: "'/d' does not exist", "'/d' is a
/// file", "'/d' holds no folder" or "'/d' holds the folders a, b" (at most twenty of them).
std::string describeDataRoot(const std::string& root);

/// Decimal text with two digits after the point, for people.
std::string roundedText(double value);

/// The path of a file or folder in a folder.
std::string below(const std::string& folder, const std::string& name);

/// The name of a folder, whose path may end with a slash or be relative.
std::string folderName(const std::string& folder);

/// Names of the regular files in `folder`, in byte order; none where it cannot be listed.
std::vector<std::string> fileNames(const std::string& folder);

/// Returns the paths that are regular files, in the given order.
std::vector<std::string> existingFiles(const std::vector<std::string>& paths);

}  // namespace corrsel::core
