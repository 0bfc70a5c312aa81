#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Numbers of matches and rounds of the paper's speed test (Fig. 9).
inline constexpr int kScalingSizes[] = {1000, 2000, 3000, 4000, 5000};
inline constexpr int kScalingRounds = 10;

/// One row of scaling.csv: one timed selection of generated matches.
struct ScalingRow {
  std::string selector;
  int threads = 1;
  std::size_t n = 0;  ///< matches
  int round = 0;
  std::size_t n_selected = 0;
  Status status = Status::kOk;
  double select_seconds = kUndefined;
};

/// Times every selector of the configuration on generated matches of a plane (makeScene(): half of them
/// right, with descriptor distances and affine frames), after a warm-up at each size. All selectors run with
/// one thread; those that have the option `threads` also run with the configuration's number. The selectors
/// take turns within a round, so that a disturbance of the machine hits all of them. Selection time alone;
/// the homography is the model of RANSAC and USAC.
/// @return empty where `stop` was set meanwhile
std::vector<ScalingRow> measureScaling(const BenchmarkConfig& config, const std::atomic<bool>& stop);

}  // namespace corrsel::core
