#pragma once

#include <cstddef>

namespace corrsel::core {

/// Unit rays of matches and their derivatives: for each image nine columns of equal length, which are those
/// of Rays (geometry/rays.h).
struct MatchRays {
  static constexpr std::size_t kColumns = 9;

  const double* left[kColumns];
  const double* right[kColumns];
  std::size_t size;
};

/// A relative pose in the basis in which its derivatives are the simplest: the rows b1, b2, t of
/// translationBasis(), and these times R; both row-major.
struct PoseInBasis {
  double basis[9];
  double rotation[9];
};

/// Sums that PoseKernels::sums writes, with v = sqrt(w) (J, r), the derivatives J of r by the rotation about
/// b1, b2, t and by the translation along b1, b2, and the weight w = 1 / (1 + r^2 / c^2)^2: v_i v_j with
/// i <= j, i outer, but without v_5 v_5 = w r^2, in the place of which is the loss r^2 / (1 + r^2 / c^2).
constexpr std::size_t kPoseSums = 21;

/// Matches that lie in front of both cameras, and those that would if t were reversed.
struct SideCounts {
  std::size_t front, reversed;
};

/// Errors of relative poses between unit rays. Matches are added up in 8 lanes.
struct PoseKernels {
  /// Squared tangent Sampson errors of matches [begin, end), px^2, written to out[0 .. end - begin).
  /// @param essential  3x3, row-major
  void (*errors)(const double* essential, const MatchRays& matches, std::size_t begin, std::size_t end,
                 double* out);

  /// @param inverse_squared_scale  1 / c^2 of the Geman-McClure loss
  /// @param sums                   receives kPoseSums numbers
  void (*sums)(const PoseInBasis& pose, const MatchRays& matches, double inverse_squared_scale, double* sums);

  SideCounts (*sides)(const PoseInBasis& pose, const MatchRays& matches);
};

}  // namespace corrsel::core
