#pragma once

#include <opencv2/core/types.hpp>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Whether the run estimates homographies: only the experiments `pose` and `budget` do, because they would
/// make other runs on datasets with homographies slower by about 30 %.
bool estimatesHomographies(const BenchmarkConfig& config);

/// Whether the run estimates poses where they are known: all runs but those of the experiment `curves` alone,
/// which shows none and has up to ten variants of every selector.
bool estimatesPoses(const BenchmarkConfig& config);

/// Whether pairs with this ground truth have rows in poses.csv: its pose is known, or it is a homography, and
/// the run estimates these.
bool hasPoseRows(const GroundTruth& truth, const BenchmarkConfig& config);

/// The measures of a selection in poses.csv; names and seed of the row are empty.
/// @param left_size  of the left image, px; without it there is no corner error
PoseRow measurePose(const GroundTruth& truth, const cv::Size& left_size, const Correspondences& putative,
                    const Selection& selection);

}  // namespace corrsel::core
