#include "corrsel/motion_guess.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "geometry/checked_matrix.h"

namespace corrsel::core {

void MotionGuess::check() const {
  requireRotation("rotation", rotation);
  if (translation) requireDirection("translation", *translation);
  if (!(rotation_sigma >= 0) || std::isinf(rotation_sigma)) {
    const std::string value = std::isnan(rotation_sigma) ? "nan" : formatNumber(rotation_sigma);
    throw std::invalid_argument("rotation_sigma = " + value + " rad must be a number from 0");
  }
}

}  // namespace corrsel::core
