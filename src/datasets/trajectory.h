#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "datasets/text_rows.h"
#include "geometry/rigid_motion.h"

namespace corrsel::core {

/// The poses of a body at given times, e.g. from a motion capture system.
class Trajectory {
 public:
  /// @param time  ns  @param pose  from the body's frame to the world's
  void add(std::int64_t time, const RigidMotion& pose) { poses_[time] = pose; }

  bool empty() const { return poses_.empty(); }

  /// The pose at a time: the given one, or one that is interpolated between the pose before and the pose
  /// after. None where one of these is missing or more than `max_gap` ns away. O(log poses).
  std::optional<RigidMotion> at(std::int64_t time, std::int64_t max_gap) const;

 private:
  std::map<std::int64_t, RigidMotion> poses_;
};

/// The pose that a row of a table of poses holds. Throws DatasetError naming the row where it is none.
/// @param quaternion  its words w, x, y, z  @param translation  its first word, m
RigidMotion poseIn(const TextRow& row, const std::array<std::size_t, 4>& quaternion, std::size_t translation);

}  // namespace corrsel::core
