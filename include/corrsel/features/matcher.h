#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"

namespace corrsel::core {

/// Putative matches: the nearest right feature of every left feature, exact brute force, no cross-check and
/// no ratio test (many-to-one is normal), with first and second distance. L2 for float descriptors (not
/// squared), Hamming for binary ones; equal distances go to the lowest index. One right feature only: second
/// distance NaN. No features on one side: no matches. Descriptors whose type or length differ between the
/// images: std::invalid_argument naming both. O(N_left * N_right * D) time, O(N_left) memory.
Correspondences matchFeatures(const Features& left, const Features& right);

}  // namespace corrsel::core
