#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Finds out which groups of a selection are the scene, which stands still, and which are objects that move
/// by themselves, and fills Selection::motion.
///
/// Idea: an object is a group of neighbouring matches that move alike, have no static matches among them, and
/// contradict the motion of the camera. Noise and wrong matches contradict it one by one; a badly fitted
/// model, parallax and repeated structure contradict it coherently, but a better model of the camera's motion
/// explains those, or correct matches lie among them.
///
/// Algorithm:
///  1. The motion of the camera is that of the pose, or without one that of the model
///     (src/motion/camera_motion.h). Matches whose error is beyond the noise are candidates.
///  2. Candidates that move like their neighbours form groups (src/motion/coherent_groups.h).
///  3. A group of at least 8 matches moves where most of its matches contradict the camera's motion:
///     - at rest, and where the pose is a rotation, by more than ten times the displacement that the static
///       scene shows itself;
///     - otherwise, and in those cases too, by lying off every epipolar geometry that explains the static
///       matches: one that is fitted to both together does not explain them. With cameras this is a pose, and
///       matches that lie behind the cameras contradict it, too.
///  4. Moving groups are added to the selection.
///
/// Output: `motion` has one entry per group. Group 0 is kStatic: the camera moves against it, or nothing
/// moves. Where an object fills more of the images than the scene does, the camera seems to move against the
/// object. Moving groups that the selector has found keep their numbers, and those that it has not found get
/// the next ones, the largest first. The matches of a moving group are correct, so their mask is 1, and
/// `n_selected` counts them. A match that agrees with group 0, but lies inside of a moving group and moves
/// like it, changes to that group. Where the selection has no groups, group 0 is what was selected.
///
/// kUnknown is what cannot be told: all groups where the status is not `ok`, where there is no model, and
/// where the model is a homography and the scene is unknown; and a group that is off a homography, but agrees
/// with an epipolar geometry of it. It may be the parallax of the static scene, or an object.
///
/// What two images do not show: an object that moves along the epipolar lines looks like one at another
/// depth, unless it then lies behind the camera (which is only tested with cameras). An object that moves
/// without turning before a plane, too, is kUnknown. At rest, a static thing that is more than ten times as
/// near as the rest of the scene seems to move if the camera moves by less than a pixel shows.
///
/// Does nothing where the selection is not of these matches or has been labelled before, where its group
/// numbers reach beyond the number of matches, or where the columns
/// of the matches are inconsistent. Nothing is drawn at random.
///
/// Cost: O(N); docs/studies/moving_objects.md has the times. The memory is kept by the calling thread.
///
/// Source: own work. That a fundamental matrix of both groups tells motion from parallax is the idea of Torr,
/// Phil. Trans. R. Soc. A 356 (1998).
/// @param matches    those that the selector was given
/// @param selection  of select(), for these matches
void labelMotion(const Correspondences& matches, Selection& selection);

/// The rows of the matches that belong to moving groups, ascending; none before labelMotion().
std::vector<std::uint32_t> movingRows(const Selection& selection);

}  // namespace corrsel::core
