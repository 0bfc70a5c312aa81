#include "points/shared_points.h"

#include <algorithm>

#include "base/gather.h"
#include "points/place_keys.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kWordBits = 64;

}  // namespace

void SharedPoints::find(const std::vector<float>& x, const std::vector<float>& y, double cell) {
  constexpr std::size_t kBitsPerPoint = 16;
  const std::size_t n = x.size();
  const unsigned bits = bitsFor(kBitsPerPoint * n, 6);
  words_.assign((std::size_t{1} << bits) / kWordBits, {0, 0});
  bits_.resize(n);
  const auto inverse_cell = static_cast<float>(1.0 / cell);
  if (hasTooManyCells(x, y, cell)) {
    setBits<true>(x, y, inverse_cell, bits);
  } else {
    setBits<false>(x, y, inverse_cell, bits);
  }
  // There are no branches on what nobody can predict.
  candidates_.resize(n);
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    candidates_[count] = i;
    count += words_[bits_[i] / kWordBits].twice >> (bits_[i] % kWordBits) & 1;
  }
  candidates_.resize(count);
  gather(x, candidates_, x_);
  gather(y, candidates_, y_);
  groups_.number(x_, y_, cell);
  of.assign(n, 0);
  for (std::size_t c = 0; c < count; ++c) {
    const std::uint32_t group = groups_.of[c];
    of[candidates_[c]] = groups_.sizes[group] > 1 ? group + 1 : 0;
  }
}

template <bool exact>
void SharedPoints::setBits(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell,
                           unsigned bits) {
  constexpr float kNearest = 0.5F;
  std::uint64_t keys[kPlaceBlock];
  for (std::size_t begin = 0; begin < x.size(); begin += kPlaceBlock) {
    const std::size_t count = std::min(kPlaceBlock, x.size() - begin);
    placeKeys<exact>(x.data() + begin, y.data() + begin, count, inverse_cell, kNearest, keys);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t hash = hashOf(keys[k], bits);
      bits_[begin + k] = static_cast<std::uint32_t>(hash);
      Word& word = words_[hash / kWordBits];
      const std::uint64_t bit = std::uint64_t{1} << (hash % kWordBits);
      word.twice |= word.once & bit;
      word.once |= bit;
    }
  }
}

}  // namespace corrsel::core
