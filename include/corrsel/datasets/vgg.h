#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Reads the Oxford affine covariant regions dataset (Mikolajczyk et al., IJCV 2005) and others laid out like
/// it: `<root>/<scene>/img1..img6` (ppm, pgm, png or jpg) and the homographies
/// `<root>/<scene>/H1to2p..H1to6p` from img1 to the others. Each scene, in alphabetical order, gives the
/// pairs "1-2" to "1-6".
class VggReader : public DatasetReader {
 public:
  /// Throws DatasetError when `root` is not a folder or no subfolder of it looks like a scene.
  explicit VggReader(const std::string& root);

  /// Five per scene, whether or not their files are there.
  std::size_t size() const override;

  PairId id(std::size_t index) const override;

  /// Throws DatasetError when an image is missing or cannot be decoded, or when the homography is missing, is
  /// not nine finite numbers or is singular. The other pairs stay readable.
  ImagePair read(std::size_t index) const override;

  std::vector<std::string> files() const override;

 private:
  std::string scenePath(std::size_t index) const;

  std::string root_;
  std::vector<std::string> scenes_;
};

}  // namespace corrsel::core
