#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "datasets/files.h"

namespace corrsel::core {

/// Layout of a dataset of image pairs with homographies. Images are of any type that isImageExtension()
/// accepts; an image that exists with several extensions is broken. A homography file has nine numbers, row
/// by row, which map the pixel coordinates of the left image (x to the right, y down, px) to those of the
/// right image.
enum class HomographyLayout {
  /// `<scene>/img1..img6`, `<scene>/H1to2p..H1to6p`: the Oxford affine covariant regions (Mikolajczyk et al.,
  /// IJCV 2005). A scene has five pairs, "1-2" to "1-6", whether or not their files exist.
  kVgg,
  /// The same with N images, where N is the highest number (up to 999) that an image or a homography of the
  /// scene has. The pairs are "1-2" to "1-N". The Heinly dataset (Heinly et al., ECCV 2012).
  kNumbered,
  /// `<scene>/1..N`, `<scene>/H_1_2..H_1_N`: HPatches (Balntas et al., CVPR 2017), where N is 6.
  kHpatches,
  /// `<name>/01`, `<name>/02`, `<name>/H1to2`: SymBench (Hauagge and Snavely, CVPR 2012). Each folder
  /// has one pair, "1-2".
  kSymbench,
};

/// Reads image pairs with homographies. A folder below the root is a sequence, named like the folder, when it
/// has any file of the layout; sequences are in alphabetical order. Only the pairs whose own files are
/// missing or broken cannot be read.
class HomographyPairReader : public DatasetReader {
 public:
  /// @param name  the dataset's name in the pairs' ids
  /// Throws DatasetError when `root` is not a folder.
  HomographyPairReader(const std::string& name, const std::string& root, HomographyLayout layout);

  std::size_t size() const override { return pairs_.size(); }

  PairId id(std::size_t index) const override;

  /// Throws DatasetError when an image is missing or cannot be decoded, or when the homography is missing, is
  /// not nine finite numbers or is singular.
  ImagePair read(std::size_t index) const override;

  void check(std::size_t index) const override;

  std::vector<std::string> ignored() const override { return ignored_; }

  std::vector<std::string> files() const override;

  /// How well the names of a folder's files fit the layout.
  static FolderFit fit(HomographyLayout layout, const std::vector<std::string>& names);

  /// The files of a sequence's folder in words, e.g. "img1..img6 and H1to2p..H1to6p".
  static const char* describe(HomographyLayout layout);

 private:
  struct Pair {
    std::string sequence;
    int right;  ///< number of the right image
  };

  std::string folderOf(std::size_t index) const;

  std::string name_, root_;
  HomographyLayout layout_;
  std::vector<Pair> pairs_;
  std::vector<std::string> ignored_;
};

}  // namespace corrsel::core
