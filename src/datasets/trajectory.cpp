#include "datasets/trajectory.h"

#include <iterator>
#include <stdexcept>
#include <string>

namespace corrsel::core {

std::optional<RigidMotion> Trajectory::at(std::int64_t time, std::int64_t max_gap) const {
  const auto after = poses_.lower_bound(time);
  if (after == poses_.end()) return std::nullopt;
  if (after->first == time) return after->second;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (time - before->first > max_gap || after->first - time > max_gap) return std::nullopt;
  const double share =
      static_cast<double>(time - before->first) / static_cast<double>(after->first - before->first);
  return interpolated(before->second, after->second, share);
}

RigidMotion poseIn(const TextRow& row, const std::array<std::size_t, 4>& quaternion,
                   std::size_t translation) {
  const auto [w, x, y, z] = quaternion;
  try {
    return motionOf(row.number(w), row.number(x), row.number(y), row.number(z),
                    {row.number(translation), row.number(translation + 1), row.number(translation + 2)});
  } catch (const std::invalid_argument& error) {
    row.fail(std::string(error.what()) + "; remove the line");
  }
}

}  // namespace corrsel::core
