#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <optional>

#include "corrsel/motion_guess.h"
#include "corrsel/pose_result.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The best homography.
struct HomographyEvidence {
  bool found = false;
  cv::Matx33d model = cv::Matx33d::zeros();  ///< px
  double confidence = 0;                     ///< -log10 units
  /// Median distance between the two points of its inliers, px.
  double displacement = std::numeric_limits<double>::infinity();
};

/// What the homography leaves over of the local set (leftover.h).
struct HomographyLeftover {
  bool coherent = false;  ///< a sizable coherent group, farther from it than twice the threshold
  bool loose = false;     ///< a sizable number of single matches, farther from it than the threshold
};

/// The best fundamental matrix; with cameras, the best essential matrix.
struct FundamentalEvidence {
  bool found = false;
  cv::Matx33d model = cv::Matx33d::zeros();  ///< px, or of rays
  double confidence = 0;                     ///< -log10 units
  bool explains_loose = false;  ///< at least half of the loose leftover of the homography agrees with it
  ModelKind kind = ModelKind::kFundamental;  ///< or kEssential
};

/// What is known about the matches of a pair: all that the decision (decision.h) goes by. What is optional is
/// gathered only where the decision asks for it.
struct Evidence {
  bool local_support = false;  ///< whether any match has significant local support
  HomographyEvidence homography;
  std::optional<HomographyLeftover> homography_leftover;
  /// Whether the matches off the homography show parallax (parallax.h); with cameras, whether the verdict
  /// about the motion is kGeneral (calibrated/verdict.h).
  std::optional<bool> parallax;
  std::optional<FundamentalEvidence> fundamental;
  bool pose_known = false;                   ///< whether the pose was searched; only with cameras
  std::optional<PoseResult> pose;            ///< what was found
  GuessVerdict guess = GuessVerdict::kNone;  ///< of this search
  std::optional<bool> fundamental_leftover;  ///< whether it leaves a sizable coherent group over
  std::optional<double> local_confidence;    ///< of the extended local set, -log10 units
};

/// Evidence that is gathered only on demand, because it takes time.
enum class Need : std::uint8_t {
  kNone,
  kHomographyLeftover,
  kParallax,
  kFundamental,
  kFundamentalLeftover,
  kLocalConfidence
};

}  // namespace corrsel::core
