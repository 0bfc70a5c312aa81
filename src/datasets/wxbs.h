#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Reads the layout of WxBS (Mishkin, Matas, Perdoch, Lenc, WxBS: Wide baseline stereo generalizations, BMVC
/// 2015): `<root>/<kind>/<scene>/01.png`, `02.png` (or .jpg) and `corrs.txt` with a line x1 y1 x2 y2, px, for
/// each of at least eight correspondences that people marked. `crossval_errors.txt`, one number for each of
/// them, is optional. The id of a pair is {dataset, scene, kind}; pairs are in alphabetical order of kind and
/// scene.
///
/// The ground truth is not measured. It is the fundamental matrix that fitFundamental() fits to the marked
/// points. A remark states how far the points lie from their epipolar lines.
class WxbsReader : public DatasetReader {
 public:
  /// Throws DatasetError when `root` is not a folder. Cost: the fits.
  WxbsReader(const std::string& name, const std::string& root);

  std::size_t size() const override { return pairs_.size(); }
  PairId id(std::size_t index) const override;
  ImagePair read(std::size_t index) const override;
  void check(std::size_t index) const override;
  std::vector<std::string> ignored() const override { return ignored_; }
  std::vector<std::string> files() const override;
  std::vector<std::string> remarks() const override { return remarks_; }

  /// Whether the folder has a pair of this layout.
  static bool fits(const std::string& root);

 private:
  struct Pair {
    std::string kind, scene, folder;
    cv::Matx33d fundamental;
    std::string fault;  ///< of the correspondences
  };

  std::string name_, root_;
  std::vector<Pair> pairs_;
  std::vector<std::string> ignored_, remarks_;
};

}  // namespace corrsel::core
