#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"

/// The selectors as one writes them down from the papers with good libraries (Eigen, nanoflann): what the
/// package's own versions are timed against and checked with. Same parameters and same rules, nothing clever.
/// @pre coordinates are finite; image sizes or frames are set where the method needs them
namespace corrsel::baselines {

using Mask = std::vector<std::uint8_t>;  ///< one entry per match, 1 = selected

/// GMS (Bian et al., CVPR 2017), alpha 4, 20 x 20 cells, structured like the published code: every variant
/// clears, fills and scans a table of all pairs of cells, for each of four shifts. O(variants * cells^2).
Mask gmsTextbook(const core::Correspondences& matches, bool rotation = false, bool scale = false);

/// VFC (Ma et al., TIP 2014) with the full kernel: one dense Cholesky factorisation of an N x N matrix per EM
/// step, in double. O(N^3) per step.
Mask vfcDense(const core::Correspondences& matches);

/// SparseVFC (Ma et al., TIP 2014): the field is spanned by 16 random matches. In double. O(N) per step.
Mask vfcSparse(const core::Correspondences& matches);

enum class LpmVariant { kPaper, kV2 };

/// LPM (Ma et al., IJCAI 2017: kPaper, K 4, lambda 6 twice; IJCV 2019: kV2) with k-d trees for the
/// neighbours. Identical matches are decided once; neighbours at equal distance are ordered by the matches'
/// coordinates. O(N log N).
Mask lpmTextbook(const core::Correspondences& matches, LpmVariant variant);

/// The paper's spectral technique, t = 0.3: N x N affinity matrix in float, power iteration from the uniform
/// vector until |dv| < 1e-6, greedy choice. O(N^2) memory and time per step.
Mask stDense(const core::Correspondences& matches);

/// The paper's game-theoretic matching, lambda 1e-4: N x N payoff matrix in float, 100 steps of replicator
/// dynamics, Otsu's threshold; matches that share a point exclude each other. O(N^2) memory and time per
/// step. @pre left_frame and right_frame are set
Mask gtmDense(const core::Correspondences& matches);

}  // namespace corrsel::baselines
