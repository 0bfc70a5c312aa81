#pragma once

#include <cstdint>

#include "corrsel/options.h"

namespace corrsel::core {

/// What is done to an image before features are searched, whatever the detector.
struct ImageOptions : OptionSet {
  enum class Equalize : std::uint8_t { kNone, kClahe };

  Equalize equalize = Equalize::kNone;
  double clahe_clip = 1.0;  ///< see cv::createCLAHE()
  int clahe_tiles = 8;      ///< in each direction

  void visit(OptionVisitor& visitor) const override;
};

}  // namespace corrsel::core
