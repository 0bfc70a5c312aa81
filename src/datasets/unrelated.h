#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Pairs of images that show different scenes, made from the images of another dataset. All putative matches
/// between them are outliers, so a selector should select none.
///
/// A pair consists of the left image of one pair of the dataset and the right image of another one, whose
/// sequence shows another place. At most 120 pairs are drawn, and no right image is drawn twice beside the
/// same sequence. Their ids are {"unrelated_vgg", "bark+graf", "1-2+1-5"}: sequence and pair of the left
/// image, then those of the right one. There is no ground truth (TruthKind::kNone), and matches that the
/// dataset provides are left out.
class UnrelatedReader : public DatasetReader {
 public:
  /// @param scenes  the dataset
  /// @param seed    of the drawing
  /// Throws DatasetError when no two sequences of the dataset certainly show different places.
  explicit UnrelatedReader(std::unique_ptr<DatasetReader> scenes, int seed = 0);

  std::size_t size() const override { return pairs_.size(); }
  PairId id(std::size_t index) const override;
  /// Throws DatasetError, too, where the pair of the dataset has matches only.
  ImagePair read(std::size_t index) const override;
  void check(std::size_t index) const override;
  std::vector<std::string> ignored() const override { return scenes_->ignored(); }
  std::vector<std::string> files() const override { return scenes_->files(); }
  std::vector<std::string> remarks() const override { return scenes_->remarks(); }

 private:
  struct Pair {
    std::size_t left, right;  ///< pairs of the dataset from which the images are taken
  };

  std::unique_ptr<DatasetReader> scenes_;
  std::vector<Pair> pairs_;
};

/// Whether two sequences of a dataset may show the same place, according to their names: the names are equal
/// or share three letters in a row, in upper or lower case ("notredame12" and "notredame", "breadcube" and
/// "cubechips"). The first `common` characters, with which all names of the dataset begin ("scene_1",
/// "scene_2"), do not count.
bool mayShowOnePlace(const std::string& a, const std::string& b, std::size_t common = 0);

}  // namespace corrsel::core
