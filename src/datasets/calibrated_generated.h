#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// Generated matches of calibrated cameras (makeCalibratedScene(), 400 matches with noise of 1 px), without
/// images. There are three such datasets, whose names state how many percent of the matches are right:
/// calibrated95_generated, calibrated70_generated and calibrated30_generated.
///
/// The sequences are all combinations of camera ("pinhole", "rational", "fisheye", "equirectangular") and
/// motion ("rest", "rotation", "general", "forward", "plane"), e.g. "fisheye_general". Each has the pairs "1"
/// to "25". A pair depends only on the seed, its sequence and its number.
class CalibratedGeneratedReader : public DatasetReader {
 public:
  /// Whether this is the name of such a dataset.
  static bool isName(const std::string& name);

  /// @param name  see isName()
  CalibratedGeneratedReader(const std::string& name, int seed);

  std::size_t size() const override;
  PairId id(std::size_t index) const override;
  ImagePair read(std::size_t index) const override;
  void check(std::size_t index) const override { static_cast<void>(id(index)); }
  std::vector<std::string> files() const override { return {}; }

 private:
  std::string name_;
  std::int64_t seed_;
  double inlier_ratio_ = 0;
};

}  // namespace corrsel::core
