#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "features/parts/image_bytes.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Bytes = std::vector<std::uint8_t>;

/// A picture that no format can describe in few bytes.
cv::Mat picture() {
  Random random(3);
  cv::Mat image(40, 60, CV_8UC3);
  for (int i = 0; i < 40 * 60 * 3; ++i) image.data[i] = static_cast<std::uint8_t>(random.index(256));
  return image;
}

Bytes encoded(const std::string& extension) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, picture(), bytes));
  return bytes;
}

Bytes bytesOf(const std::string& text) { return {text.begin(), text.end()}; }

TEST(ImageBytes, WholeFilesAreNotCutOff) {
  for (const char* extension : {".png", ".jpg", ".webp", ".bmp", ".tiff", ".ppm"}) {
    EXPECT_FALSE(isCutOff(encoded(extension))) << extension;
  }
}

TEST(ImageBytes, CutOffFilesAreRecognisedWhereverTheyEnd) {
  const struct {
    const char* extension;
    const char* name;
  } formats[] = {{".png", "PNG"}, {".jpg", "JPEG"}, {".webp", "WebP"}};
  for (const auto& format : formats) {
    const Bytes whole = encoded(format.extension);
    for (const std::size_t length : {std::size_t{20}, whole.size() / 2, whole.size() - 2}) {
      const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_TRUE(isCutOff(part)) << format.name << " " << length;
      EXPECT_EQ(undecodableCause(part), std::string("the ") + format.name + " data are cut off after " +
                                            std::to_string(length) +
                                            " bytes; copy or download the file again");
    }
  }
}

TEST(ImageBytes, CausesAreNamedWithTheRemedy) {
  const struct {
    Bytes bytes;
    std::string expected;
  } cases[] = {
      {{}, "the file is empty (0 bytes); copy or download the file again"},
      {bytesOf("no image\nat all"),
       "the file is not an image, it begins with 'no image'; replace it by the image"},
      {{0, 1, 2, 250},
       "the file is not an image, it begins with the bytes 00 01 02 fa; replace it by the image"},
      {bytesOf("GIF89a...."), "the file is a GIF image, which is not read; convert the image to PNG"},
      {bytesOf(std::string("\0\0\0\x18", 4) + "ftypheic...."),
       "the file is a HEIC image, which is not read; convert the image to PNG"},
      {bytesOf("<!DOCTYPE html><html>"), "the file is a web page, not an image; download the image itself"},
      {bytesOf("version https://git-lfs.github.com/spec/v1\noid sha256:0"),
       "the file is a pointer of Git LFS, not the image; fetch the images with git lfs pull"},
      {bytesOf("P6\n60 40\n255\nxyz"),
       std::string("the PPM data are damaged, cut off, or of a kind that OpenCV ") + CV_VERSION +
           " cannot decode; copy or download the file again, or " + "convert the image to PNG"},
  };
  for (const auto& c : cases) EXPECT_EQ(undecodableCause(c.bytes), c.expected);
}

}  // namespace
}  // namespace corrsel::core
