#include "database/exif.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>

namespace corrsel::core {
namespace {

constexpr std::uint8_t kHeading[] = {'E', 'x', 'i', 'f', 0, 0};
constexpr std::uint32_t kExifDirectory = 0x8769, kFocalLengthOnFilm = 0xA405;
constexpr std::size_t kEntryBytes = 12;

/// Part of a file; numbers beyond its end are 0.
struct Bytes {
  const std::uint8_t* data;
  std::size_t size;
  bool big_endian;

  std::uint32_t number(std::size_t at, std::size_t count) const {
    if (at > size || count > size - at) return 0;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i)
      value = value << 8 | data[big_endian ? at + i : at + count - 1 - i];
    return value;
  }
};

/// The Exif data of a JPEG file, which begin with the header of TIFF.
std::optional<Bytes> exifData(const std::vector<std::uint8_t>& bytes) {
  const Bytes file{bytes.data(), bytes.size(), true};
  if (file.number(0, 2) != 0xFFD8) return std::nullopt;
  // Segments have a marker and a length. The image itself begins with the marker FFDA.
  for (std::size_t at = 2; file.number(at, 1) == 0xFF && file.number(at, 2) != 0xFFDA;) {
    const std::size_t length = file.number(at + 2, 2), begin = at + 4 + sizeof kHeading;
    const std::size_t end = std::min(at + 2 + length, bytes.size());
    if (file.number(at, 2) == 0xFFE1 && begin < end &&
        std::equal(std::begin(kHeading), std::end(kHeading), bytes.data() + at + 4)) {
      Bytes exif{bytes.data() + begin, end - begin, true};
      exif.big_endian = exif.number(0, 2) == 0x4D4D;  // "MM"
      return exif;
    }
    at += 2 + std::max<std::size_t>(length, 2);
  }
  return std::nullopt;
}

/// The value of a tag in the directory at an offset; 0 where there is none.
/// @param bytes  of the value: 2 or 4
std::uint32_t valueOf(const Bytes& exif, std::size_t directory, std::uint32_t tag, std::size_t bytes) {
  const std::size_t entries = exif.number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + i * kEntryBytes;
    if (exif.number(entry, 2) == tag) return exif.number(entry + 8, bytes);
  }
  return 0;
}

}  // namespace

double focalLengthOnFilm(const std::vector<std::uint8_t>& bytes) {
  const std::optional<Bytes> exif = exifData(bytes);
  if (!exif) return 0;
  const std::uint32_t directory = valueOf(*exif, exif->number(4, 4), kExifDirectory, 4);
  return directory == 0 ? 0 : valueOf(*exif, directory, kFocalLengthOnFilm, 2);
}

}  // namespace corrsel::core
