#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/camera.h"
#include "programs/match/answer.h"

namespace corrsel {

/// What corrsel_match needs beyond corrsel::features. The program in C++ takes it from OpenCV's imgcodecs and
/// from yaml-cpp, `python3 -m corrsel` from the modules cv2 and yaml, so that the package for Python depends
/// on no further library.
struct MatchFront {
  std::string program;  ///< its name, as it is typed
  /// The image in the bytes of a file, of 8 bits in BGR or grey; an empty one where the bytes are no image.
  std::function<cv::Mat(const std::vector<std::uint8_t>& bytes)> decode;
  /// The bytes of an image file; none where the ending (".png") is that of no format.
  std::function<std::vector<std::uint8_t>(const std::string& ending, const cv::Mat& image)> encode;
  /// A camera from a YAML file of Kalibr or EuRoC, in which `name` ("cam0") is one of several. Throws
  /// std::exception with the fault and the remedy.
  std::function<core::Camera(const std::string& path, const std::string& name)> camera;
  /// Writes an NPZ file; without it the program has no argument --npz.
  std::function<void(const std::string& path, const MatchAnswer& answer)> write_npz;
};

/// The program that matches two images (docs/doors.md).
/// @param words  its command line without its name
/// @return the exit code: 0 = the answer can be relied on, 1 = it cannot or nothing was found, 2 = wrong
/// arguments, or a file that cannot be used; the text on `errors` names it and the remedy
int runMatch(const std::vector<std::string>& words, const MatchFront& front, std::ostream& out,
             std::ostream& errors);

}  // namespace corrsel
