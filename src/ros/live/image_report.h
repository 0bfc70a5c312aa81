#pragma once

#include <string>

#include "corrsel/Correspondences.h"

namespace corrsel {

/// core::faultsOf() the images of a message. What is believed of the motion, and the time between the images,
/// tell how fast the camera turns.
std::string imageFaults(const Correspondences& message);

}  // namespace corrsel
