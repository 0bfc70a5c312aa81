#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

namespace corrsel::core {

/// What is believed of the motion between two calibrated images before they are matched, for example from a
/// gyroscope, from other sensors, or because the camera goes on as it did before. It is never taken as true:
/// it tells where to look first, and is tested. What is known exactly is a PosePrior.
struct MotionGuess {
  cv::Matx33d rotation = cv::Matx33d::eye();  ///< R of Pose
  std::optional<cv::Vec3d> translation;       ///< t of Pose, of length 1; nothing where it is not known
  /// Standard deviation of the rotation about every axis, rad; at least 0.
  double rotation_sigma = 0;

  /// Throws std::invalid_argument naming the member, its value and what is valid: numbers that are not
  /// finite, a matrix that differs from a rotation by more than 1e-4, a translation whose length differs from
  /// 1 by more than 1e-6, and a negative standard deviation.
  void check() const;
};

/// What the matches show about a MotionGuess. The texts returned by toString() are part of the file formats.
enum class GuessVerdict : std::uint8_t {
  kNone = 0,         ///< there was no guess, or nothing has tested it
  kConfirmed = 1,    ///< the matches agree with it
  kContradicted = 2  ///< the matches show another motion
};

std::string toString(GuessVerdict verdict);

}  // namespace corrsel::core
