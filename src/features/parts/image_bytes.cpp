#include "features/parts/image_bytes.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdio>
#include <opencv2/core/version.hpp>
#include <string_view>

namespace corrsel::core {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr char kCopyAgain[] = "copy or download the file again";
constexpr char kConvert[] = "convert the image to PNG";

/// Bytes by which a kind of file is recognised.
struct Signature {
  std::size_t offset;
  std::string_view bytes;
  const char* name;
};

using namespace std::string_view_literals;

/// Formats that are read.
constexpr Signature kRead[] = {
    {0, "\x89PNG\r\n\x1a\n"sv, "PNG"},
    {0, "\xff\xd8\xff"sv, "JPEG"},
    {8, "WEBP"sv, "WebP"},
    {0, "BM"sv, "BMP"},
    {0, "II*\0"sv, "TIFF"},
    {0, "MM\0*"sv, "TIFF"},
    {0, "P2"sv, "PGM"},
    {0, "P3"sv, "PPM"},
    {0, "P5"sv, "PGM"},
    {0, "P6"sv, "PPM"},
};

/// Formats that are not read.
constexpr Signature kOther[] = {
    {4, "ftypavif"sv, "AVIF image"},          {4, "ftyphei"sv, "HEIC image"},
    {4, "ftypmif1"sv, "HEIF image"},          {0, "GIF8"sv, "GIF image"},
    {0, "\0\0\0\x0cjP"sv, "JPEG 2000 image"}, {0, "%PDF"sv, "PDF document"},
};

constexpr Signature kWebPages[] = {
    {0, "<!DOCTYPE"sv, ""}, {0, "<!doctype"sv, ""}, {0, "<html"sv, ""}, {0, "<HTML"sv, ""}};
constexpr Signature kLfsPointer = {0, "version https://git-lfs"sv, ""};

bool has(const Bytes& bytes, const Signature& signature) {
  return bytes.size() >= signature.offset + signature.bytes.size() &&
         std::equal(signature.bytes.begin(), signature.bytes.end(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(signature.offset),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

template <std::size_t n>
const Signature* find(const Bytes& bytes, const Signature (&signatures)[n]) {
  const auto found = std::find_if(std::begin(signatures), std::end(signatures),
                                  [&bytes](const Signature& signature) { return has(bytes, signature); });
  return found == std::end(signatures) ? nullptr : found;
}

/// Whether a JPEG has no end-of-image marker behind its last start-of-scan marker; inside a scan neither can
/// occur (ITU-T T.81, B.1.1.2 and F.1.2.3).
bool isCutOffJpeg(const Bytes& bytes) {
  constexpr std::array<std::uint8_t, 2> kStartOfScan = {0xff, 0xda}, kEndOfImage = {0xff, 0xd9};
  const auto scan = std::find_end(bytes.begin(), bytes.end(), kStartOfScan.begin(), kStartOfScan.end());
  return std::search(scan, bytes.end(), kEndOfImage.begin(), kEndOfImage.end()) == bytes.end();
}

/// Whether a PNG has no IEND chunk (ISO/IEC 15948, 11.2.5), which is the same in every file.
bool isCutOffPng(const Bytes& bytes) {
  constexpr std::array<std::uint8_t, 8> kEnd = {'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
  return std::search(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end()) == bytes.end();
}

/// Whether a WebP file is shorter than its RIFF header states (RFC 9649, 2.4).
bool isCutOffWebp(const Bytes& bytes) {
  std::size_t length = 0;  // of what follows the first eight bytes
  for (std::size_t i = 8; i-- > 4;) length = length << 8U | bytes[i];
  return bytes.size() < 8 + length;
}

/// The first bytes as text in quotes, or in hexadecimal where they are no text.
std::string beginning(const Bytes& bytes) {
  constexpr std::size_t kTextLength = 24, kHexLength = 8;
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), kTextLength));
  std::string text;
  for (auto byte = bytes.begin(); byte != end && *byte != '\n' && *byte != '\r'; ++byte) {
    if (std::isprint(*byte) == 0) {
      text.clear();
      break;
    }
    text += static_cast<char>(*byte);
  }
  if (!text.empty()) return "'" + text + "'";
  text = "the bytes";
  for (std::size_t i = 0; i < std::min(bytes.size(), kHexLength); ++i) {
    char hex[4];
    std::snprintf(hex, sizeof(hex), " %02x", static_cast<unsigned>(bytes[i]));
    text += hex;
  }
  return text;
}

}  // namespace

bool isCutOff(const std::vector<std::uint8_t>& bytes) {
  const Signature* const format = find(bytes, kRead);
  if (format == nullptr) return false;
  const std::string_view name = format->name;
  return (name == "JPEG" && isCutOffJpeg(bytes)) || (name == "PNG" && isCutOffPng(bytes)) ||
         (name == "WebP" && isCutOffWebp(bytes));
}

std::string undecodableCause(const std::vector<std::uint8_t>& bytes) {
  if (bytes.empty()) return std::string("the file is empty (0 bytes); ") + kCopyAgain;
  if (const Signature* const format = find(bytes, kRead)) {
    const std::string data = std::string("the ") + format->name + " data are ";
    if (isCutOff(bytes)) {
      return data + "cut off after " + std::to_string(bytes.size()) + " bytes; " + kCopyAgain;
    }
    return data + "damaged, cut off, or of a kind that OpenCV " CV_VERSION " cannot decode; " + kCopyAgain +
           ", or " + kConvert;
  }
  if (const Signature* const format = find(bytes, kOther)) {
    return std::string("the file is a ") + format->name + ", which is not read; " + kConvert;
  }
  if (find(bytes, kWebPages) != nullptr) {
    return "the file is a web page, not an image; download the image itself";
  }
  if (has(bytes, kLfsPointer)) {
    return "the file is a pointer of Git LFS, not the image; fetch the images with git lfs pull";
  }
  return "the file is not an image, it begins with " + beginning(bytes) + "; replace it by the image";
}

}  // namespace corrsel::core
