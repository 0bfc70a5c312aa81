#include "ros/live/transforms.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <utility>

#include "geometry/rotation_vector.h"

namespace corrsel {

struct TransformInput::Parts {
  explicit Parts(const ros::NodeHandle& nh) : listener(buffer, nh, false) {}

  tf2_ros::Buffer buffer;
  tf2_ros::TransformListener listener;
};

void TransformInput::subscribe() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!parts_) parts_ = std::make_shared<Parts>(nh_);
}

void TransformInput::unsubscribe() {
  std::shared_ptr<Parts> parts;  // destroyed without the lock
  const std::lock_guard<std::mutex> lock(mutex_);
  std::swap(parts, parts_);
}

std::optional<TransformInput::Transform> TransformInput::between(const CameraMoment& from,
                                                                 const CameraMoment& to,
                                                                 const std::string& fixed_frame,
                                                                 std::string& why_missing) const {
  std::shared_ptr<Parts> parts;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    parts = parts_;
  }
  if (!parts) {
    why_missing = "TF is not subscribed";
    return std::nullopt;
  }
  geometry_msgs::Transform transform;
  try {
    transform = (from.stamp == to.stamp
                     ? parts->buffer.lookupTransform(to.frame, from.frame, to.stamp)
                     : parts->buffer.lookupTransform(to.frame, to.stamp, from.frame, from.stamp, fixed_frame))
                    .transform;
  } catch (const tf2::TransformException& error) {
    why_missing = std::string("TF: ") + error.what();
    return std::nullopt;
  }
  const geometry_msgs::Quaternion& q = transform.rotation;
  return Transform{core::rotationFromQuaternion({q.w, q.x, q.y, q.z}),
                   {transform.translation.x, transform.translation.y, transform.translation.z}};
}

}  // namespace corrsel
