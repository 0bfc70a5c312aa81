#pragma once

#include <cstddef>
#include <string>

namespace corrsel::core {

/// How far a run has got.
struct Progress {
  std::size_t done = 0, total = 0;  ///< image pairs, those of an earlier session included
  std::string current;              ///< the pair or the stage that is being processed
  double rate = 0;                  ///< pairs per second of this session; NaN before the first
  double remaining = 0;             ///< s; NaN before the first
};

}  // namespace corrsel::core
