#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Reads the layout of EVD, the Extreme View Dataset (Mishkin, Matas, Perdoch, MODS: Fast and robust method
/// for two-view matching, CVIU 2015): `<root>/1/<name>.png`, `<root>/2/<name>.png` and `<root>/h/<name>.txt`,
/// nine numbers that map pixels of the first image to those of the second one. Each name is a sequence with
/// the pair "1-2", in alphabetical order.
class EvdReader : public DatasetReader {
 public:
  /// Throws DatasetError when `root` is not a folder.
  EvdReader(const std::string& name, const std::string& root);

  std::size_t size() const override { return names_.size(); }
  PairId id(std::size_t index) const override { return {name_, names_.at(index), "1-2"}; }
  ImagePair read(std::size_t index) const override;
  void check(std::size_t index) const override;
  std::vector<std::string> files() const override;

  /// Whether the folder has files in all three folders.
  static bool fits(const std::string& root);

 private:
  /// Path without extension of the image in folder "1" or "2", or of the homography in folder "h".
  std::string stemOf(const char* folder, std::size_t index) const;

  std::string name_, root_;
  std::vector<std::string> names_;
};

}  // namespace corrsel::core
