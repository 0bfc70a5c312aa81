#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "matching/nearest.h"

namespace corrsel::core {

/// Throws std::invalid_argument as matchFeatures() does.
void checkDescriptors(const Features& left, const Features& right);

/// The matches of left features with their nearest right features.
/// @param mutual  only those whose right feature has the left one as its nearest, too. @pre nearest.query is
///                filled
Correspondences putativeMatches(const Features& left, const Features& right, const Neighbours& nearest,
                                bool mutual);

}  // namespace corrsel::core
