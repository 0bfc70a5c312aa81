#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// A generated stand-in for the paper's subset of the Heinly dataset (Heinly et al., ECCV 2012): as many
/// scenes (four) and pairs (29) with the same challenges, but made from photographs of the sample set:
/// - "zoom_1", "zoom_2": seven pairs each, scaled down in equal ratios to 1/4;
/// - "rotation_1" (seven pairs), "rotation_2" (eight): turned about the image centre in equal steps over 360
///   degrees.
///
/// The pairs are "0-1" to "0-8", and the ground truth is the homography. A little noise is added to the right
/// image. It depends only on the seed and the pair, not on the order of reading.
class HeinlyGeneratedReader : public DatasetReader {
 public:
  /// @param root  the sample set's folder, see SampleReader
  /// @param seed  of the noise
  /// Throws DatasetError when `root` is not a folder or has none of the four photographs.
  explicit HeinlyGeneratedReader(const std::string& root, int seed = 0);

  std::size_t size() const override;

  PairId id(std::size_t index) const override;

  /// Throws DatasetError when the photograph is missing or cannot be decoded.
  ImagePair read(std::size_t index) const override;

  void check(std::size_t index) const override;

  std::vector<std::string> files() const override;

 private:
  std::string root_;
  std::int64_t seed_;
};

}  // namespace corrsel::core
