#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"

namespace corrsel::core {

/// How well a second, geometrically different relation explains the matches of a pair.
///
/// Idea: A facade with equal windows looks the same when it is shifted by a window, and a corridor when it is
/// shifted by a door. Some matches then follow the shift. Together they look like a relation of their own,
/// and they lie among the matches of the answer: in the same part of an image, the answer sends a point
/// to one place and the second relation to another. This tells them from an object that moves and from a
/// second plane of a scene, which have their own parts of the images.
///
/// Algorithm:
///  1. The first relation is the homography of the answer. Where the answer is another model or none, it is
///  the
///     most significant homography of the selected matches: a fundamental matrix also agrees with a plane
///     and its shifted copy, because they look like two parallel planes.
///  2. Matches are displaced if they are farther than 20 units of the image (length_unit.h) from where the
///     first relation sends them. Of these, the ones stay for which two of their 8 nearest in the left image
///     are shifted in the same way, within 10 %. If they are fewer than 8, or than a tenth of the matches of
///     the first relation, or if so few have 4 matches of the first relation among their 8 nearest ones in an
///     image, the answer is 0. Most pairs end here.
///  3. The second relation is the most significant homography of what stayed. It must lie among the
///     matches of the answer: half of its places must have mostly matches of the answer around them
///     (auto/leftover.h). There must be few matches between both relations, a fifth of its own, which
///     excludes surfaces whose depth varies. The same is tried once more with the matches that remain.
///  4. The result is the number of places (8 units wide) of the second relation over that of the other
///  selected
///     matches.
///
/// Output: from 0 (there is no second relation) to 1 (it explains as much as the first one). From 0.2 on, a
/// pair deserves distrust. NaN where nothing is selected.
///
/// Input: coordinates, and the sizes of the images where they are known. Of more than 1000 matches a random
/// thousand is examined. The result does not depend on the order of the matches.
///
/// What it cannot find: a shift that (nearly) all matches follow, because then the right relation is not
/// there to be compared; one that fewer than 8 places follow; structure that is not locally plane. A true
/// second surface in front of the first one, such as a fence, is marked, too, if both have matches all over
/// the image. See docs/studies/cycles.md for what was measured.
///
/// Cost: O(N) for at most 1000 matches, 4 to 15 % of the time of `auto` on photographs, and up to 30 % where
/// a second relation exists. Memory of some hundred bytes per match is kept in the workspace.
/// @param matches    that were given to the selector
/// @param selection  its result; the mask is as long as the matches
double ambiguity(const Correspondences& matches, const Selection& selection, Workspace& workspace);

}  // namespace corrsel::core
