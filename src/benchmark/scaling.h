#pragma once

#include <atomic>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/run_folder.h"

namespace corrsel::core {

/// Numbers of matches and rounds of the paper's speed test (Fig. 9).
inline constexpr int kScalingSizes[] = {1000, 2000, 3000, 4000, 5000};
inline constexpr int kScalingRounds = 10;

/// Times every selector of the configuration on generated matches of a plane (makeScene(): half of them
/// right, with descriptor distances and affine frames), after a warm-up at each size. All selectors run with
/// one thread; those that have the option `threads` also run with the configuration's number. The selectors
/// take turns within a round, so that a disturbance of the machine hits all of them. Selection time alone; the
/// homography is the model of RANSAC and USAC.
/// @return empty where `stop` was set meanwhile
std::vector<ScalingRow> measureScaling(const BenchmarkConfig& config, const std::atomic<bool>& stop);

}  // namespace corrsel::core
