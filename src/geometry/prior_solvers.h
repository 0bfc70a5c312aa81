#pragma once

#include <opencv2/core/matx.hpp>

#include "corrsel/pose_result.h"

namespace corrsel::core {

/// Minimal solvers for cameras whose rotation is known in part, for example from an inertial unit. All rays
/// are of length 1. Of the two signs of t, the one is returned with which more of the sample's points lie in
/// front of both cameras.

/// Computes the translation from two matches and the known rotation R: t is orthogonal to the normals (R d) x
/// d' of both epipolar planes.
/// @param translation  receives t, of length 1
/// @return false where the planes are the same, or one of the matches has none, as it does not move
bool translationFromTwo(const cv::Matx33d& rotation, const cv::Vec3d (&left)[2], const cv::Vec3d (&right)[2],
                        cv::Vec3d& translation);

/// Poses that a sample can have with a known vertical.
constexpr int kVerticalSolutions = 4;

/// Computes all poses of three matches with R left_up = right_up. What remains of R is an angle about the
/// vertical, and its half-angle tangent a root of a polynomial of degree 4 (Fraundorfer, Tanskanen and
/// Pollefeys, A minimal case solution to the calibrated relative pose problem for the case of two known
/// orientation angles, ECCV 2010; Sweeney, Flynn and Turk, Solving for relative pose with a partially known
/// rotation is a quadratic eigenvalue problem, 3DV 2014). Here it is the determinant of the three epipolar
/// normals, divided by its factor 1 + q^2.
/// @param left_up, right_up  the same direction in the frames of both cameras, of length 1; the opposite of
///                           gravity, or any other
/// @return number of poses; 0 for degenerate samples
int posesFromThree(const cv::Vec3d& left_up, const cv::Vec3d& right_up, const cv::Vec3d (&left)[3],
                   const cv::Vec3d (&right)[3], Pose (&poses)[kVerticalSolutions]);

}  // namespace corrsel::core
