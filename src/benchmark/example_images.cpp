#include "benchmark/example_images.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "base/text.h"
#include "benchmark/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

std::string listOf(const std::string& folder) { return (fs::path(folder) / imagesTable().file()).string(); }

}  // namespace

std::vector<ExampleImage> readExampleImages(const std::string& folder) {
  return imagesTable().intactRows(readTextFile(listOf(folder)));
}

void clearExampleImages(const std::string& folder) {
  for (const ExampleImage& image : readExampleImages(folder)) {
    std::error_code ignored;
    fs::remove(fs::path(folder) / "images" / safeFileName(image.file), ignored);
  }
  writeFile(listOf(folder), imagesTable().text({}));
}

void appendExampleImage(const std::string& folder, ExampleImage image, const cv::Mat& picture) {
  image.file = safeFileName(image.id.dataset + "_" + image.id.sequence + "_" + image.id.pair + "_" +
                            image.features + "_" + image.preselection + "_" + image.selector) +
               ".jpg";
  const std::string file = (fs::path(folder) / "images" / image.file).string();
  if (!cv::imwrite(file, picture, {cv::IMWRITE_JPEG_QUALITY, 85})) {
    throw RunFolderError("cannot write " + file + ": check the permissions and the free space of its folder");
  }
  appendToFile(listOf(folder), imagesTable().line(image));
}

}  // namespace corrsel::core
