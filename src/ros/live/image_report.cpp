#include "ros/live/image_report.h"

#include <limits>
#include <opencv2/core.hpp>

#include "corrsel/features/image_faults.h"
#include "corrsel/ros/conversions.h"

namespace corrsel {

std::string imageFaults(const Correspondences& message) {
  const cv::Matx33d rotation(message.guess_rotation.data());
  const bool known = cv::norm(rotation) > 0;  // false for NaN, too
  const double turn_rate =
      known ? core::turnRate(rotation, message.header.stamp.toSec() - message.right_stamp.toSec())
            : std::numeric_limits<double>::quiet_NaN();
  return core::faultsOf(fromMsg(message.left_quality), fromMsg(message.right_quality), turn_rate);
}

}  // namespace corrsel
