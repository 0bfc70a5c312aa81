#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "points/cell_grid.h"
#include "posterior/probability_weights.h"
#include "search/local_support.h"

namespace corrsel::core {

/// Matches with an answer about them. All per-match values are in one order.
struct AnsweredMatches {
  const Correspondences& matches;  ///< finite coordinates, at least one
  const LocalSupport& support;     ///< of these matches
  const std::vector<std::uint8_t>& mask;
  ModelKind kind;
  cv::Matx33d model;  ///< px; valid if kind is not kNone
  double confidence;  ///< of the answer, -log10 units
};

/// What the log odds of a match depend on, see MatchProbability. The weights are found by
/// scripts/maintenance/train_probability.sh.
class AnswerTerms {
 public:
  static constexpr double kHomographyScale = 5;     ///< t of homographies, px
  static constexpr double kFundamentalScale = 2.5;  ///< t of fundamental matrices, px

  /// Density of outliers that are spread evenly over the right image, per outlier: per px^2 under a
  /// homography, and per px of distance under a fundamental matrix.
  static double outlierDensity(const AnsweredMatches& answered);

  /// @param errors  squared residuals, px^2; empty without a model. Both arguments must outlive the object.
  AnswerTerms(const AnsweredMatches& answered, const std::vector<double>& errors);

  ProbabilityTerms of(std::size_t match) const;

  /// Matches outside of the extended local set that are farther than t from the model.
  std::size_t farOthers() const { return far_others_; }

 private:
  static constexpr int kSide = 8;  // cells

  void countAgreements();
  double leftOverAt(std::size_t match) const;

  const AnsweredMatches& answered_;
  const std::vector<double>& errors_;
  double squared_scale_, doubt_, purity_ = 0;
  std::size_t far_others_ = 0;
  CellGrid grid_;  // of the left image; the members of the extended local set in it, and those off the model
  std::array<std::uint32_t, kSide * kSide> members_{}, far_members_{};
};

}  // namespace corrsel::core
