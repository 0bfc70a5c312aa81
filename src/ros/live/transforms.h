#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <mutex>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

#include "ros/live/motion_source.h"

namespace tf2_ros {
class Buffer;
class TransformListener;
}  // namespace tf2_ros

namespace corrsel {

/// Transforms from TF, received on the queue of a node handle.
class TransformInput {
 public:
  struct Transform {
    cv::Matx33d rotation;   ///< a point X in the frame `from` is R X + t in the frame `to`
    cv::Vec3d translation;  ///< t, m
  };

  /// Does not subscribe yet.
  explicit TransformInput(const ros::NodeHandle& nh) : nh_(nh) {}
  ~TransformInput() { unsubscribe(); }

  void subscribe();
  void unsubscribe();

  /// The transform between two frames, each at its time; time 0 is the newest one. Any thread.
  /// @param fixed_frame  does not move between the times; not used where they are equal
  /// @param why_missing  filled where the transform is not known
  std::optional<Transform> between(const CameraMoment& from, const CameraMoment& to,
                                   const std::string& fixed_frame, std::string& why_missing) const;

 private:
  struct Parts;

  ros::NodeHandle nh_;
  mutable std::mutex mutex_;  ///< guards parts_
  std::shared_ptr<Parts> parts_;
};

}  // namespace corrsel
