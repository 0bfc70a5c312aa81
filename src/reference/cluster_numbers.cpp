#include "reference/cluster_numbers.h"

#include <algorithm>

namespace corrsel::core {

void ClusterNumbers::assign(const std::vector<std::uint32_t>& cluster,
                            const std::vector<std::uint32_t>& size) {
  order_.clear();
  number_.assign(size.size(), -1);
  for (const std::uint32_t c : cluster) {
    if (c == kNone || number_[c] >= 0) continue;
    number_[c] = static_cast<std::int32_t>(order_.size());
    order_.push_back(c);
  }
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return size[a] != size[b] ? size[a] > size[b] : number_[a] < number_[b];
  });
  for (std::size_t k = 0; k < order_.size(); ++k) number_[order_[k]] = static_cast<std::int32_t>(k);
}

}  // namespace corrsel::core
