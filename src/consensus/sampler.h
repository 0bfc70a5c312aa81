#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/random.h"

namespace corrsel::core {

/// How samples are drawn from matches that are ordered by quality.
struct ProsacSchedule {
  double samples = 200000;  ///< T_N: the pool reaches all matches after so many samples
  int prefixes = 1;  ///< later samples come in turn from all matches, the best half, the best quarter...
};

/// Draws samples of distinct matches: uniformly, or in the order of PROSAC (Chum and Matas, CVPR 2005).
///
/// Algorithm: PROSAC draws from a pool of the best n matches, which grows towards all N as if T_N uniform
/// samples were sorted by quality:
///   T_n = T_N prod_{i<m} (n-i)/(N-i), T'_{n+1} = T'_n + ceil(T_{n+1} - T_n), T'_m = 1.
/// Sample t consists of the n-th match and m-1 of the first n-1, where n is the smallest with T'_n >= t.
/// PROSAC draws uniformly after T_N samples. With several prefixes, sample t is instead drawn uniformly from
/// the best N / 2^k matches, k = t mod prefixes, but from 20 at least. If right matches are rare and more
/// frequent among the best, a prefix gives far more all-inlier samples than all matches do. Nobody knows
/// which prefix is the best one, and each of them has the same number of samples, so the search takes at most
/// `prefixes` times as long as with the best one.
class Sampler {
 public:
  /// Uniform samples of `sample_size` from `count` matches. @pre sample_size <= count, <= 8
  Sampler(std::size_t count, int sample_size, std::uint64_t seed);

  /// PROSAC samples. @param order  all match numbers, best first; must outlive the sampler
  Sampler(const std::vector<std::uint32_t>& order, int sample_size, std::uint64_t seed,
          const ProsacSchedule& schedule = {});

  /// Writes one sample. O(m^2).
  void draw(std::uint32_t* sample);

  /// Samples drawn so far.
  std::uint64_t drawn() const { return drawn_; }

  /// Number of matches, counted from the best, from which all samples so far were drawn.
  std::uint32_t pool() const { return pool_; }

 private:
  void growPool();

  std::uint32_t count_;
  int sample_size_;
  Random random_;
  const std::vector<std::uint32_t>* order_ = nullptr;
  ProsacSchedule schedule_;
  std::uint64_t drawn_ = 0;
  std::uint32_t pool_;          // n
  double expected_ = 0;         // T_n
  std::uint64_t pool_end_ = 1;  // T'_n: the last sample drawn from the pool
};

}  // namespace corrsel::core
