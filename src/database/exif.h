#pragma once

#include <cstdint>
#include <vector>

namespace corrsel::core {

/// The tag FocalLengthIn35mmFilm in the Exif data of a JPEG file: the focal length, in mm, with which film of
/// 36 x 24 mm shows as much along the diagonal. 0 where it is unknown, missing or damaged, and for other
/// files. O(length of the Exif data).
///
/// Source: CIPA DC-008, "Exchangeable image file format for digital still cameras: Exif", 4.6.
double focalLengthOnFilm(const std::vector<std::uint8_t>& bytes);

}  // namespace corrsel::core
