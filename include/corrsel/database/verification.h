#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "corrsel/database/pair_store.h"
#include "corrsel/database/pair_verifier.h"

namespace corrsel::core {

struct VerificationOptions {
  int threads = 1;                  ///< at least 1; the result does not depend on it
  bool again = false;               ///< verify pairs whose verification is stored already
  bool strict = false;              ///< stop at the first faulty pair
  bool dry_run = false;             ///< verify, and write nothing
  double memory_gib = 1;            ///< for keypoints that are kept for further pairs, GiB; 0 to 1e6
  std::size_t commit_pairs = 500;   ///< pairs of one transaction, at most; at least 1
  double commit_seconds = 2;        ///< time between two transactions, at most, s; >= 0, may be infinite
  std::vector<ImagePairKey> pairs;  ///< ascending; empty: all pairs of the store
};

/// The state of a run, for displays.
struct VerificationProgress {
  std::size_t total = 0;  ///< pairs that this run verifies
  std::size_t done = 0;   ///< of these, pairs that are stored
  std::size_t accepted = 0;
  double seconds = 0;  ///< since the start
};

/// What a run did.
struct VerificationSummary {
  std::size_t pairs = 0;                 ///< pairs that were asked for
  std::size_t skipped = 0;               ///< stored already
  std::size_t verified = 0;              ///< by this run
  std::size_t accepted = 0;              ///< of these
  std::size_t faulty = 0;                ///< rows that cannot be used
  std::array<std::size_t, 9> configs{};  ///< pairs verified by this run, by TwoViewConfig
  double seconds = 0;
  bool interrupted = false;
};

/// Verifies the pairs of a store on several threads and stores the results in ascending order of the pairs.
///
/// Cost: memory for the keypoints of memory_gib, for the numbers of the pairs (8 bytes each), and for 64
/// pairs a thread. A pair is stored or not; a run that was killed continues where it ended.
/// @param each       called for every verified pair in ascending order, also for faulty ones
/// @param progress   called from time to time; may be empty
/// @param interrupt  where it becomes true, the run stores what is complete and returns
/// Throws StoreError; what was committed before remains. Throws std::invalid_argument for an option out of
/// its range, before anything is read.
VerificationSummary verifyPairs(PairStore& store, const PairVerifier& verifier,
                                const VerificationOptions& options,
                                const std::function<void(const VerifiedPair&)>& each = {},
                                const std::function<void(const VerificationProgress&)>& progress = {},
                                const std::atomic<bool>* interrupt = nullptr);

}  // namespace corrsel::core
