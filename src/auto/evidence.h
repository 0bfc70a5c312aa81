#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <optional>

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

/// The best fundamental matrix.
struct FundamentalEvidence {
  bool found = false;
  cv::Matx33d model = cv::Matx33d::zeros();  ///< px
  double confidence = 0;                     ///< -log10 units
  bool explains_loose = false;  ///< at least half of the loose leftover of the homography agrees with it
};

/// What is known about the matches of a pair: all that the decision (decision.h) goes by. What is optional is
/// gathered only where the decision asks for it.
struct Evidence {
  bool local_support = false;  ///< whether any match has significant local support
  HomographyEvidence homography;
  std::optional<HomographyLeftover> homography_leftover;
  std::optional<bool> parallax;  ///< of the matches off the homography (parallax.h)
  std::optional<FundamentalEvidence> fundamental;
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
