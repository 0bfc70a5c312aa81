#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "search/pose_model.h"

namespace corrsel::core {

/// The essential matrix of cameras whose rotation is known; two matches determine the translation
/// (geometry/prior_solvers.h).
class KnownRotationModel : public PoseModel {
 public:
  KnownRotationModel();

  using PoseModel::setPrior;  // of the kind kRotation

  /// @pre setPrior() was called
  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
};

/// The essential matrix of cameras with a known vertical; three matches determine the angle about it and the
/// translation (geometry/prior_solvers.h).
class KnownVerticalModel : public PoseModel {
 public:
  KnownVerticalModel();

  using PoseModel::setPrior;  // of the kind kVertical

  /// @pre setPrior() was called
  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
};

}  // namespace corrsel::core
