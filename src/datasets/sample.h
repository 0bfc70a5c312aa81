#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// The folder that scripts/fetch_samples.sh fills by default: $XDG_CACHE_HOME/corrsel/sample, or
/// ~/.cache/corrsel/sample.
std::string sampleFolder();

/// The built-in sample set, made from the example images of Debian's package opencv-doc, which
/// scripts/fetch_samples.sh collects in one folder:
/// - "graf/1-3": a painted wall from two viewpoints, with its homography;
/// - "aloe/L-R": a rectified stereo pair with its disparity image;
/// - ten sequences of five pairs "0-1" to "0-5" of growing strength: a photograph and its image under a known
///   homography and one nuisance. They follow the paper's eight VGG cases (zoom_rotation_1, zoom_rotation_2,
///   blur_1, blur_2, viewpoint_1, viewpoint_2, light, jpeg), plus pure zoom and pure rotation;
/// - from kFirstReal on the pairs of realSamples(): a calibrated stereo rig, a box and a page.
///
/// The generated images depend only on the seed and the pair, not on the order of reading.
class SampleReader : public DatasetReader {
 public:
  /// Index of the first of realSamples(), which joined the set later. The pairs before it, and what was
  /// measured or chosen on them, stay as they were.
  static constexpr std::size_t kFirstReal = 52;

  /// @param root  the folder with the files named by imageNames()
  /// @param seed  of the generated pairs' homographies and noise
  /// Throws DatasetError when `root` is not a folder or has none of the files.
  explicit SampleReader(const std::string& root, int seed = 0);

  /// Names of the files that the pairs are made from: images and graf's homography.
  static std::vector<std::string> imageNames();

  /// Names of the images of the pairs before kFirstReal, from which the tests of binary descriptors are
  /// chosen.
  static std::vector<std::string> trainingImages();

  std::size_t size() const override;

  PairId id(std::size_t index) const override;

  /// Throws DatasetError when a source file is missing or cannot be decoded. The other pairs can still be
  /// read.
  ImagePair read(std::size_t index) const override;

  /// Checks the existence of the images only.
  void check(std::size_t index) const override;

  std::vector<std::string> files() const override;

 private:
  std::string path(const char* name) const;

  std::string root_;
  std::int64_t seed_;
};

}  // namespace corrsel::core
