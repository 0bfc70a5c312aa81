#pragma once

#include "search/proposal.h"

namespace corrsel::core {

/// Size of the shortest prefix of the best matches from which samples are drawn in turn.
inline constexpr std::uint32_t kMinPrefix = 20;

/// Number of matches in the prefix of `count` matches that has its turn.
std::uint32_t prefixInTurn(std::uint32_t count, std::uint64_t turn, const ProsacSchedule& schedule);

/// PROSAC: samples of the best matches first. Uniform samples where the quality is unknown.
///
/// Algorithm: PROSAC draws from a pool of the best n matches, which grows towards all N as if T_N uniform
/// samples were sorted by quality:
///   T_n = T_N prod_{i<m} (n-i)/(N-i), T'_{n+1} = T'_n + ceil(T_{n+1} - T_n), T'_m = 1.
/// Sample t consists of the n-th match and m-1 of the first n-1, where n is the smallest with T'_n >= t.
/// PROSAC draws uniformly after T_N samples. With several prefixes, sample t is instead drawn uniformly from
/// the best N / 2^k matches, k = t mod prefixes, but from 20 at least. If inliers are rare and more frequent
/// among the best, a prefix gives far more all-inlier samples than all matches do. Nobody knows which prefix
/// is the best one, and each of them has the same number of samples, so the search takes at most `prefixes`
/// times as long as with the best one.
///
/// Source: Chum and Matas, CVPR 2005; the prefixes are this package's.
class ProsacProposal : public SampleProposal {
 public:
  ProsacProposal() : ProsacProposal({"PROSAC", true, true}) {}

  const std::vector<std::uint32_t>* prefixes() const override { return order_; }
  std::uint32_t pool() const override { return pool_; }

 protected:
  explicit ProsacProposal(const ProposalTraits& values) : SampleProposal(values) {}
  void prepare() override;
  void drawSample(std::uint32_t* sample) override;

  /// Lets other samples come first.
  void delay(std::uint64_t samples) { pool_end_ += samples; }

 private:
  void growPool();

  ProsacSchedule schedule_;
  std::uint32_t pool_ = 0;      // n
  double expected_ = 0;         // T_n
  std::uint64_t pool_end_ = 1;  // T'_n: the last sample drawn from the pool
};

}  // namespace corrsel::core
