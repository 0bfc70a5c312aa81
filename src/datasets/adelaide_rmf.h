#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Reads AdelaideRMF (Wong et al., ICCV 2011): one MATLAB file `<root>/<name>.mat` per image pair, with the
/// fields
/// - `img1`, `img2`: uint8, HxW or HxWx3 (RGB);
/// - `data`: 6xN, each column x1 y1 1 x2 y2 1, px;
/// - `label`: N whole numbers, 0 = outlier, k = member of structure k;
/// - `score`: optional, N numbers.
///
/// Any numeric class is accepted for data, label and score. The matches become ImagePair::given. Their
/// coordinates are kept as stored, because published results are computed from these numbers, although MATLAB
/// counts pixels from 1 and the rest of this package counts from 0. The score comes from SIFT matching and
/// becomes the column `distance`; correct matches have lower scores. Pairs are in alphabetical order,
/// sequence = file name without ".mat", pair = "1-2".
class AdelaideRmfReader : public DatasetReader {
 public:
  /// @param name  the dataset's name in the pairs' ids
  /// Throws DatasetError when `root` is not a folder or has no .mat file.
  AdelaideRmfReader(const std::string& name, const std::string& root);

  std::size_t size() const override { return files_.size(); }

  PairId id(std::size_t index) const override;

  /// Throws DatasetError naming the file, the field and what is wrong with it when the file cannot be read,
  /// is cut off, or has a field that is missing or of the wrong class, shape or length. The other pairs can
  /// still be read.
  ImagePair read(std::size_t index) const override;

  std::vector<std::string> files() const override { return files_; }

 private:
  std::string name_;
  std::vector<std::string> files_;
};

}  // namespace corrsel::core
