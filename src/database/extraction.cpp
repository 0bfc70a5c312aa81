#include "corrsel/database/extraction.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "base/parallel.h"
#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "database/exif.h"
#include "features/parts/image_bytes.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

// Images of a thread that are complete before all of them are stored.
constexpr std::size_t kImagesPerThread = 4;
constexpr int kDescriptorBytes = 128;
constexpr double kFilmDiagonal = 43.2666;  // mm, of 36 x 24 mm

constexpr const char* kExtensions[] = {".bmp", ".jpeg", ".jpg",  ".pgm", ".png",
                                       ".ppm", ".tif",  ".tiff", ".webp"};

bool isImage(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

/// Paths of the images below a folder, relative to it, in byte order.
std::vector<std::string> imagesBelow(const fs::path& folder) {
  std::vector<std::string> names;
  try {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file() || !isImage(entry.path())) continue;
      names.push_back(entry.path().lexically_relative(folder).generic_string());
    }
  } catch (const fs::filesystem_error& error) {
    throw StoreError(StoreError::Kind::kStorage, folder.string() + " cannot be listed (" +
                                                     error.code().message() +
                                                     "); give the folder of the images");
  }
  if (names.empty()) {
    throw StoreError(StoreError::Kind::kContent,
                     folder.string() + " has no images, neither have the folders in it; files called " +
                         joinList({std::begin(kExtensions), std::end(kExtensions)}, ", *") + " are images");
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The features of one image, or why there are none.
struct Extracted {
  Features features;
  double focal_length = 0;  ///< px; 0 = unknown
  std::string fault;
};

Extracted extract(const fs::path& path, const FeatureExtractor& extractor) {
  Extracted result;
  std::ifstream stream(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  cv::Mat image;
  try {
    // Stored pixels count, so that positions hold for the file as other programs read it.
    if (!bytes.empty() && !isCutOff(bytes)) {
      image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    }
    if (image.empty()) {
      result.fault = undecodableCause(bytes);
    } else {
      result.features = extractor.extract(image);
      result.features.image_size = image.size();
      result.focal_length = focalLengthOnFilm(bytes) / kFilmDiagonal * std::hypot(image.cols, image.rows);
    }
  } catch (const cv::Exception& error) {
    result.fault = "OpenCV cannot decode it (" + error.err + ")";
  }
  return result;
}

/// Adds images to a database, with their cameras.
class ImageWriter {
 public:
  ImageWriter(const ExtractionInput& input, bool single_camera, ColmapStore& store)
      : given_(input.camera), single_camera_(single_camera), store_(store) {
    if (given_) size_ = cameraFromColmap(*given_).size;
    if (single_camera && !store.images().empty()) size_ = store.images().front().size;
  }

  /// @return why the image is not added; empty if it is
  std::string add(const std::string& name, const Extracted& extracted) {
    const Features& features = extracted.features;
    const cv::Size& size = features.image_size;
    if (!size_.empty() && size != size_) {
      return "is " + sizeText(size) + " px, but the camera's images are " + sizeText(size_) +
             " px; give it a database or a camera of its own";
    }
    if (single_camera_) size_ = size;
    StoredImage image;
    image.name = name;
    image.size = size;
    const std::optional<ColmapCamera> known = knownCamera(extracted);
    if (known) {
      image.camera = cameraFromColmap(*known);
      image.calibrated = true;
    }
    StoredKeypoints keypoints;
    keypoints.frames = features.frames;
    for (const cv::KeyPoint& keypoint : features.keypoints) keypoints.positions.push_back(keypoint.pt);
    cv::Mat descriptors(0, kDescriptorBytes, CV_8U);
    if (!features.descriptors.empty()) features.descriptors.convertTo(descriptors, CV_8U);
    store_.addImage(image, keypoints, descriptors, known, single_camera_);
    return "";
  }

 private:
  /// The camera with a focal length that is known.
  std::optional<ColmapCamera> knownCamera(const Extracted& extracted) const {
    const cv::Size& size = extracted.features.image_size;
    std::optional<ColmapCamera> camera = given_;
    if (!camera && extracted.focal_length > 0) {
      camera = {"SIMPLE_RADIAL", {}, {extracted.focal_length, size.width / 2.0, size.height / 2.0, 0}};
    }
    if (camera) camera->size = size;
    return camera;
  }

  const std::optional<ColmapCamera>& given_;
  const bool single_camera_;
  ColmapStore& store_;
  cv::Size size_;  ///< of all images, or 0x0
};

std::unique_ptr<FeatureExtractor> extractorFor(const ExtractionOptions& options) {
  options.check();
  return createExtractor("sift+sift", {{"sift",
                                        {{"max_features", std::to_string(options.max_features)},
                                         {"contrast_threshold", formatNumber(options.contrast_threshold)},
                                         {"root", options.root ? "true" : "false"},
                                         {"max_megapixels", formatNumber(options.max_megapixels)}}}});
}

}  // namespace

void ExtractionOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"max_features", 0, 100000, "-", "Extraction: strongest features kept; 0 = no cap"},
                  &ExtractionOptions::max_features);
  visitor.number({"contrast_threshold", 0, 1, "-", "Extraction: weak extrema are dropped"},
                 &ExtractionOptions::contrast_threshold);
  visitor.flag("root", "Extraction: RootSIFT descriptors instead of SIFT", &ExtractionOptions::root);
  visitor.number(
      {"max_megapixels", 0.01, 1000, "10^6 px", "Extraction: larger images are reduced to this size first"},
      &ExtractionOptions::max_megapixels);
  visitor.flag("single_camera", "Extraction: one camera took all images", &ExtractionOptions::single_camera);
}

ExtractionSummary extractFeatures(const ExtractionInput& input, const ExtractionOptions& options, int threads,
                                  ColmapStore& store,
                                  const std::function<void(std::size_t, std::size_t)>& progress,
                                  const std::atomic<bool>* interrupt) {
  const std::unique_ptr<FeatureExtractor> extractor = extractorFor(options);
  ImageWriter writer(input, options.single_camera, store);
  std::vector<std::string> names = imagesBelow(input.folder);
  ExtractionSummary summary;
  summary.images = names.size();
  std::set<std::string> present;
  for (const StoredImage& image : store.images()) present.insert(image.name);
  names.erase(std::remove_if(names.begin(), names.end(),
                             [&](const std::string& name) { return present.count(name) != 0; }),
              names.end());
  summary.skipped = summary.images - names.size();
  const std::size_t block = kImagesPerThread * static_cast<std::size_t>(std::max(threads, 1));
  for (std::size_t begin = 0; begin < names.size(); begin += block) {
    const std::size_t end = std::min(begin + block, names.size());
    std::vector<Extracted> extracted(end - begin);
    forEachBlock(extracted.size(), 1, threads, [&](std::size_t i, std::size_t) {
      if (interrupt == nullptr || !*interrupt) {
        extracted[i] = extract(input.folder / names[begin + i], *extractor);
      }
    });
    if (interrupt != nullptr && *interrupt) {
      summary.interrupted = true;
      break;
    }
    for (std::size_t i = begin; i < end; ++i) {
      const Extracted& image = extracted[i - begin];
      const std::string fault = image.fault.empty() ? writer.add(names[i], image) : image.fault;
      if (fault.empty()) {
        ++summary.added;
        summary.features += image.features.keypoints.size();
      } else {
        summary.refused.push_back(names[i] + ": " + fault);
      }
    }
    if (progress) progress(end, names.size());
  }
  return summary;
}

}  // namespace corrsel::core
