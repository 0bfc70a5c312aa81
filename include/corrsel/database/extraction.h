#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/camera_formats.h"
#include "corrsel/database/colmap_store.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct ExtractionOptions : OptionSet {
  int max_features = 10000;          ///< strongest features of an image that are kept; 0 = all
  double contrast_threshold = 0.02;  ///< of SIFT; COLMAP's default finds about as many features
  /// RootSIFT, COLMAP's default (L1_ROOT); otherwise SIFT with rows of unit length (L2). Both are stored as
  /// whole numbers, the length being 512.
  bool root = true;
  double max_megapixels = 12;  ///< larger images are reduced to this size before features are searched
  bool single_camera = false;  ///< all images were taken by one camera

  void visit(OptionVisitor& visitor) const override;
};

/// What is known beside the options.
struct ExtractionInput {
  std::filesystem::path folder;  ///< with images, also in folders below
  /// A camera that took all images, with a size of 0x0 if its parameters hold for every image. Its focal
  /// length is trusted. Absent: see extractFeatures().
  std::optional<ColmapCamera> camera;
};

struct ExtractionSummary {
  std::size_t images = 0;            ///< in the folder
  std::size_t skipped = 0;           ///< of these, in the database already
  std::size_t added = 0;             ///< of these, added by this call
  std::size_t features = 0;          ///< of the images that were added
  std::vector<std::string> refused;  ///< images that cannot be used, and why, one sentence each
  bool interrupted = false;
};

/// Finds features in all images of a folder and adds them to a database.
///
/// Images are added in byte order of their names, which are paths below the folder, whatever the number of
/// threads. Images whose name is in the database are skipped, so that a call that was killed can be repeated.
/// Exif orientations are not applied, as in COLMAP.
///
/// Cameras: The given one; otherwise SIMPLE_RADIAL with the principal point in the centre and no distortion.
/// Its focal length is that of the tag FocalLengthIn35mmFilm in Exif data of JPEG files, trusted, or else, as
/// COLMAP guesses, 1.2 times the longer side, not trusted. Every image has a camera of its own, unless it is
/// trusted and the same; with single_camera, all have that of the first image of the database, and images of
/// another size are refused.
///
/// Features: own SIFT with its local frames, as six columns.
///
/// Cost: per thread 65 bytes a pixel, and the features of four images. On one core about 0.13 s for an image
/// of a megapixel.
/// @param progress   called with the number of images done and the number of images to do; may be empty
/// @param interrupt  where it becomes true, the call returns; what is stored remains
/// Throws StoreError, also where the folder has no images, and std::invalid_argument for options out of
/// range.
ExtractionSummary extractFeatures(const ExtractionInput& input, const ExtractionOptions& options, int threads,
                                  ColmapStore& store,
                                  const std::function<void(std::size_t, std::size_t)>& progress = {},
                                  const std::atomic<bool>* interrupt = nullptr);

}  // namespace corrsel::core
