#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/neighbours.h"
#include "corrsel/random.h"
#include "geometry/normalization.h"
#include "search/multi_gs.h"
#include "search/progressive_napsac.h"

namespace corrsel::core {

/// How samples are drawn from matches that are ordered by quality.
struct ProsacSchedule {
  double samples = 200000;  ///< T_N: the pool reaches all matches after so many samples
  int prefixes = 1;  ///< later samples come in turn from all matches, the best half, the best quarter...
};

/// The matches near a match in both images.
///
/// Algorithm: of the 2 k matches that are nearest in the left image, the k with the smallest sum of the
/// squared distances in both images. That is nearly always the set of the k nearest matches in the four
/// dimensions of their coordinates. Equal distances are ordered by number. O(k) on average for evenly spread
/// points.
class MatchNeighbourhood {
 public:
  static constexpr int kLargest = 32;

  /// Copies the left points and refers to the right ones.
  void build(const NormalizedMatches& matches);

  /// Writes up to k matches near the match, itself excluded, in no particular order. @pre k <= kLargest
  /// @return how many were written
  int find(std::uint32_t match, int k, std::uint32_t* out) const;

 private:
  const NormalizedMatches* matches_ = nullptr;
  PlanarNeighbours neighbours_;
};

/// Draws samples of distinct matches: uniformly, in the order of PROSAC (Chum and Matas, CVPR 2005), near one
/// another, by Progressive NAPSAC (search/progressive_napsac.h) or by Multi-GS (search/multi_gs.h).
///
/// Local samples consist of a uniform match and others among the k nearest to it, with k = 8, 16, 32 and all
/// matches in turn. Right matches of one structure crowd, so pure samples are far more frequent than among
/// uniform ones. Their models are inaccurate and need local optimisation. (NAPSAC, Myatt et al., BMVC 2002,
/// draws from a ball of fixed radius.)
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

  /// Local samples. @param near  of the matches; must outlive the sampler
  /// @param best_first  all match numbers, must outlive the sampler; nullptr = all alike
  Sampler(const MatchNeighbourhood& near, std::size_t count, const std::vector<std::uint32_t>* best_first,
          int sample_size, std::uint64_t seed, const ProsacSchedule& schedule = {});

  /// Progressive NAPSAC, followed by PROSAC.
  /// @param near  of the matches in this order; both must outlive the sampler
  Sampler(GrowingNeighbourhoods& near, const std::vector<std::uint32_t>& order, int sample_size,
          std::uint64_t seed, const ProsacSchedule& schedule = {});

  /// Multi-GS. @param affinity  of the matches; must outlive the sampler. The caller adds hypotheses to it
  Sampler(HypothesisAffinity& affinity, std::size_t count, int sample_size, std::uint64_t seed);

  /// Writes one sample. O(m^2), and a search of neighbours for local samples.
  void draw(std::uint32_t* sample);

  /// Samples drawn so far.
  std::uint64_t drawn() const { return drawn_; }

  /// Number of matches, counted from the best, from which all samples so far were drawn.
  std::uint32_t pool() const { return growing_ != nullptr && drawn_ <= growing_samples_ ? count_ : pool_; }

 private:
  void growPool();
  void drawNear(std::uint32_t* sample);
  std::uint32_t prefix(std::uint64_t turn) const;

  std::uint32_t count_;
  int sample_size_;
  Random random_;
  const std::vector<std::uint32_t>* order_ = nullptr;
  const MatchNeighbourhood* near_ = nullptr;
  GrowingNeighbourhoods* growing_ = nullptr;
  std::uint64_t growing_samples_ = 0;  // the first ones
  HypothesisAffinity* affinity_ = nullptr;
  ProsacSchedule schedule_;
  std::uint64_t drawn_ = 0;
  std::uint32_t pool_;          // n
  double expected_ = 0;         // T_n
  std::uint64_t pool_end_ = 1;  // T'_n: the last sample drawn from the pool
};

}  // namespace corrsel::core
