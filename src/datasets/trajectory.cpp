#include "datasets/trajectory.h"

#include <iterator>

namespace corrsel::core {

std::optional<RigidMotion> Trajectory::at(std::int64_t time, std::int64_t most_gap) const {
  const auto after = poses_.lower_bound(time);
  if (after == poses_.end()) return std::nullopt;
  if (after->first == time) return after->second;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (time - before->first > most_gap || after->first - time > most_gap) return std::nullopt;
  const double share =
      static_cast<double>(time - before->first) / static_cast<double>(after->first - before->first);
  return interpolated(before->second, after->second, share);
}

}  // namespace corrsel::core
