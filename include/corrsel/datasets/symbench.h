#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Reads SymBench (Hauagge and Snavely, CVPR 2012): pairs of buildings whose images differ in illumination,
/// age or rendering style. One folder per pair holds `<root>/<name>/01.png`, `<root>/<name>/02.png` and the
/// homography `<root>/<name>/H1to2` from 01 to 02. The dataset has 46 pairs, 31 of them registered beforehand
/// (identity). Pairs are in alphabetical order, sequence = folder name, pair = "1-2".
class SymbenchReader : public DatasetReader {
 public:
  /// Throws DatasetError when `root` is not a folder or no subfolder of it has one of the three files.
  explicit SymbenchReader(const std::string& root);

  /// One per subfolder that has any of the three files, whether or not the others are there.
  std::size_t size() const override { return folders_.size(); }

  PairId id(std::size_t index) const override;

  /// Throws DatasetError when an image is missing or cannot be decoded, or when the homography is missing, is
  /// not nine finite numbers or is singular. The other pairs stay readable.
  ImagePair read(std::size_t index) const override;

  std::vector<std::string> files() const override;

 private:
  std::vector<std::string> folders_;
};

}  // namespace corrsel::core
