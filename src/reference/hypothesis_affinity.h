#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/random.h"

namespace corrsel::core {

/// Multi-GS: samples of matches that prefer the same hypotheses.
///
/// Idea: two inliers of one structure have small errors under the same hypotheses, also under those
/// that are only roughly right. Matches that share their best hypotheses are therefore drawn together.
///
/// Algorithm: of every block of 64 hypotheses, each match remembers the kHead with the smallest errors (equal
/// errors: the earlier ones) as the bits of one word, for the last kBlocks blocks. The affinity K_ij of two
/// matches is the number of hypotheses that both remember. The first member of a sample is uniform; each
/// further one is drawn with a probability proportional to the product of its affinities to all members so
/// far, and uniformly where all these products are zero. Before the first block is full, samples are uniform.
///
/// Cost: O(N) per hypothesis, O(N kBlocks) per member of a sample. Memory: 4 * 64 + 8 kBlocks bytes per
/// match.
///
/// Source: Chin, Yu and Suter, ECCV 2010 and PAMI 2012. Deviations: the authors sort all hypotheses and take
/// the best tenth of all of them every ten hypotheses; here it is the best tenth of every block.
class HypothesisAffinity {
 public:
  static constexpr std::size_t kBlock = 64, kHead = 6, kBlocks = 8;

  /// Forgets the hypotheses of the previous call and keeps the memory.
  void start(std::size_t matches);

  /// Memory for the squared errors of all matches under the next hypothesis. add() takes them.
  float* next() { return errors_.data() + filled_ * matches_; }

  /// Takes the hypothesis whose errors were written to next().
  void add();

  /// Writes distinct matches. @pre sample_size <= matches
  void draw(Random& random, std::size_t sample_size, std::uint32_t* sample);

  /// Hypotheses that both matches remember.
  std::uint32_t affinity(std::uint32_t a, std::uint32_t b) const;

 private:
  void closeBlock();
  void multiplyByAffinity(std::uint32_t member);

  std::size_t matches_ = 0, filled_ = 0, closed_ = 0;  // closed_: blocks
  std::vector<float> errors_;                          // [kBlock][matches]
  std::vector<std::uint64_t> remembered_;              // [kBlocks][matches]
  std::vector<double> weights_;
};

}  // namespace corrsel::core
