#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/datasets/calibrated_scene.h"
#include "corrsel/datasets/scene.h"

namespace corrsel::performance {

using core::MatchSceneKind;
using core::SceneSpec;
using Scene = core::MatchScene;
using Mask = std::vector<std::uint8_t>;  ///< one entry per match

/// `count` scenes that differ in their seeds, 0, 1... Made on first use and kept.
std::shared_ptr<const std::vector<Scene>> scenes(SceneSpec spec, std::size_t count);

/// The same for calibrated cameras; not kept.
std::shared_ptr<const std::vector<Scene>> scenes(core::CalibratedSceneSpec spec, std::size_t count);

/// Share of the inliers that `model`, a homography from left to right in px, puts within `threshold` px.
double modelRecall(const Scene& scene, const cv::Matx33d& model, double threshold);

}  // namespace corrsel::performance
