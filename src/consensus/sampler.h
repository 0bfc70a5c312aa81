#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/random.h"

namespace corrsel::core {

/// Draws samples of distinct matches: uniformly, or in the order of PROSAC (Chum and Matas, CVPR 2005).
///
/// PROSAC draws from a pool of the best n matches that grows towards all N as if T_N = 200000 uniform samples
/// were sorted by quality: T_n = T_N prod_{i<m} (n-i)/(N-i), T'_{n+1} = T'_n + ceil(T_{n+1} - T_n), T'_m = 1;
/// sample t takes m-1 of the first n-1 and the n-th, n the smallest with T'_n >= t. After T_N samples it
/// draws uniformly.
class Sampler {
 public:
  /// Uniform samples of `sample_size` from `count` matches. @pre sample_size <= count, <= 8
  Sampler(std::size_t count, int sample_size, std::uint64_t seed);

  /// PROSAC. @param order  match numbers, best first, all of them; must outlive the sampler
  Sampler(const std::vector<std::uint32_t>& order, int sample_size, std::uint64_t seed);

  /// Writes one sample. O(m^2).
  void draw(std::uint32_t* sample);

  /// Samples drawn so far.
  std::uint64_t drawn() const { return drawn_; }

  /// Matches that all samples so far were drawn from: the first ones of the order.
  std::uint32_t pool() const { return pool_; }

 private:
  void growPool();

  std::uint32_t count_;
  int sample_size_;
  Random random_;
  const std::vector<std::uint32_t>* order_ = nullptr;
  std::uint64_t drawn_ = 0;
  std::uint32_t pool_;          // n
  double expected_ = 0;         // T_n
  std::uint64_t pool_end_ = 1;  // T'_n: the last sample drawn from the pool
};

}  // namespace corrsel::core
