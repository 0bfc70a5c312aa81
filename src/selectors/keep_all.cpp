#include "corrsel/selectors/keep_all.h"

#include <algorithm>

namespace corrsel::core {

void KeepAllSelector::run(const Correspondences&, Workspace&, Selection& result) const {
  std::fill(result.mask.begin(), result.mask.end(), std::uint8_t{1});
}

}  // namespace corrsel::core
