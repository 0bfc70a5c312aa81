#include "search/seed_growing.h"

namespace corrsel::core {

void SeedGrowing::start(const Correspondences& matches, const std::vector<float>& weights, double diagonal,
                        const std::vector<std::uint32_t>& seeds, const std::vector<LinearMap>& maps) {
  growing_.assign(matches, weights, diagonal);
  seeds_ = &seeds;
  maps_ = &maps;
  taken_.assign(matches.size(), 0);
  next_ = 0;
  found_ = false;
}

bool SeedGrowing::next() {
  found_ = false;
  while (next_ < seeds_->size() && taken_[(*seeds_)[next_]] != 0) ++next_;
  if (next_ == seeds_->size()) return false;
  const std::uint32_t seed = (*seeds_)[next_++];
  found_ = growing_.grow(seed, (*maps_)[seed]);
  for (const std::uint32_t i : growing_.supporters()) taken_[i] = 1;
  return true;
}

}  // namespace corrsel::core
