#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "search/affine_growing.h"

namespace corrsel::core {

/// Grows the local maps of seeds one after another (affine_growing.h). A seed that supports a map that was
/// grown before is passed over, because it would grow into the same map.
///
/// Cost: that of growing for each map; memory is kept between calls.
class SeedGrowing {
 public:
  /// The parameters must outlive the calls of next().
  /// @param weights   votes per match
  /// @param diagonal  of the right image, px
  /// @param seeds     rows of `matches`, best first
  /// @param maps      per match: the linear part of its local map
  void start(const Correspondences& matches, const std::vector<float>& weights, double diagonal,
             const std::vector<std::uint32_t>& seeds, const std::vector<LinearMap>& maps);

  /// Grows the map of the next seed. @return false if there is none left
  bool next();

  /// The map that next() has grown, as a homography in pixels; nullptr where nothing has grown.
  const cv::Matx33d* map() const { return found_ ? &growing_.map() : nullptr; }

 private:
  AffineGrowing growing_;
  const std::vector<std::uint32_t>* seeds_ = nullptr;
  const std::vector<LinearMap>* maps_ = nullptr;
  std::vector<std::uint8_t> taken_;
  std::size_t next_ = 0;  // in seeds_
  bool found_ = false;
};

}  // namespace corrsel::core
