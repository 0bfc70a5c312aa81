#pragma once

#include <cstddef>
#include <vector>

#include "corrsel/benchmark/results.h"
#include "corrsel/image_pair.h"

namespace corrsel::core {

/// A selector succeeds on a pair where its F (reading `paper`) is at least this.
inline constexpr double kExampleSuccessF = 0.8;
/// A selector fails on a pair where its F is at least this much below the best selector's...
inline constexpr double kExampleFailureShortfall = 0.3;
/// ...and the best F is at least this: a failure of the selector, not a pair that defeats all of them.
inline constexpr double kExampleFailureBestF = 0.5;

/// Of the whole run...
inline constexpr std::size_t kMaxExamples = 16;
/// ...and of each dataset beside them.
inline constexpr std::size_t kExamplesPerDataset = 3;

inline bool isExampleSuccess(double f) { return f >= kExampleSuccessF; }
inline bool isExampleFailure(double f, double best_f) {
  return best_f >= kExampleFailureBestF && best_f - f >= kExampleFailureShortfall;
}

/// Chooses example pairs, as few as a greedy cover finds. Among them every selector except keep_all has a
/// success (or else the pair of its highest F) and a failure (or else the pair of its largest shortfall
/// against the best selector, of several the one of its lowest F), and every dataset has a pair. Among pairs
/// that cover equally many of these demands, those of the highest F and the largest shortfall are preferred.
/// @param rows  of one cell (features and preselection, "given" rows beside them); repetitions are averaged;
///              rows that are not evaluated or have no F are ignored
/// @param tau  tolerance of F, px; labelled rows have none
/// @return at most max_pairs pairs, sorted by dataset, sequence and pair, whatever the order of the rows
/// O(rows log rows + pairs^2 * selectors).
std::vector<PairId> chooseExamples(const std::vector<ResultRow>& rows, double tau,
                                   std::size_t max_pairs = kMaxExamples);

}  // namespace corrsel::core
