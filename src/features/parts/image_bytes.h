#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace corrsel::core {

/// Whether the bytes of a PNG, JPEG or WebP file end before the image does. OpenCV decodes such JPEG data
/// without an error. False for other formats, whose end cannot be recognised. O(bytes).
bool isCutOff(const std::vector<std::uint8_t>& bytes);

/// Why bytes cannot be decoded as an image, followed by the remedy, e.g. "the PNG data are cut off after 1234
/// bytes; copy or download the file again". Recognises empty and cut-off files, formats that are not read,
/// web pages and Git LFS pointers in the place of an image, and shows the first bytes of anything else.
std::string undecodableCause(const std::vector<std::uint8_t>& bytes);

}  // namespace corrsel::core
