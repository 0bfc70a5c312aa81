#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "datasets/files.h"

namespace corrsel::core {

/// Reads pairs of one's own: `<root>/<name>/` with
/// - `left`, `right`: images (.png, .jpg, ...);
/// - `H.txt` or `F.txt`: nine numbers, row by row: a homography x' ~ H x, or a fundamental matrix x'^T F x =
/// 0
///   of rank 2, between pixel coordinates of the images as they are stored;
/// - `matches.csv`: putative matches, see readMatchList(), which become ImagePair::given. The images are
///   optional then, and the ground truth is H.txt, F.txt or the column `label`, exactly one of the three;
/// - `size.txt`: optional, beside matches without images: width and height of the left image, then of the
/// right
///   one, px.
///
/// A folder that has any of these files is a sequence, named like the folder, with the pair "1-2"; sequences
/// are in alphabetical order. Folders of all kinds may lie side by side.
class PairFolderReader : public DatasetReader {
 public:
  /// @param name  the dataset's name in the pairs' ids
  /// Throws DatasetError when `root` is not a folder.
  PairFolderReader(const std::string& name, const std::string& root);

  std::size_t size() const override { return sequences_.size(); }

  PairId id(std::size_t index) const override;

  /// Throws DatasetError naming the file when one is missing, contradicts another one or is broken, and when
  /// a match lies outside its image.
  ImagePair read(std::size_t index) const override;

  void check(std::size_t index) const override;

  std::vector<std::string> ignored() const override { return ignored_; }

  std::vector<std::string> files() const override;

  /// How well the names of a folder's files fit this layout.
  static FolderFit fit(const std::vector<std::string>& names);

  /// The files of a pair's folder in words.
  static const char* describe() { return "left.png, right.png and H.txt or F.txt, or matches.csv"; }

 private:
  std::string folderOf(std::size_t index) const;

  std::string name_, root_;
  std::vector<std::string> sequences_, ignored_;
};

}  // namespace corrsel::core
