#include "corrsel/motion_labels.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/gather.h"
#include "base/usable_rows.h"
#include "corrsel/workspace.h"
#include "motion/camera_motion.h"
#include "motion/coherent_groups.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;  // of a group that is judged

struct MotionMemory {
  std::vector<std::uint32_t> rows;  // of the input: the order of everything below
  Correspondences matches;
  std::vector<std::uint8_t> base, still;
  std::vector<std::size_t> moving;  // those of `groups` that do
  std::vector<std::uint32_t> moving_rows;
  CameraMotion camera;
  CoherentGroups groups;
};

std::size_t groupCount(const Selection& selection) {
  if (selection.group.empty()) return 0;
  return static_cast<std::size_t>(*std::max_element(selection.group.begin(), selection.group.end()) + 1);
}

void splitMatches(const Correspondences& matches, const Selection& selection, MotionMemory& memory) {
  memory.rows = usableRows(matches);
  gather(matches, memory.rows, memory.matches);
  memory.base.resize(memory.rows.size());
  for (std::size_t i = 0; i < memory.rows.size(); ++i)
    memory.base[i] = selection.group[memory.rows[i]] == 0 ? 1 : 0;
  memory.still.resize(memory.rows.size());
}

/// Finds the groups that contradict the motion of the camera.
void findMoving(const Selection& selection, MotionMemory& memory) {
  const std::vector<std::uint8_t>& beyond = memory.camera.beyond();
  for (std::size_t i = 0; i < memory.rows.size(); ++i)
    memory.still[i] = selection.mask[memory.rows[i]] != 0 && beyond[i] == 0 ? 1 : 0;
  memory.groups.find(memory.matches, beyond, memory.still);
  memory.moving.clear();
  memory.moving_rows.clear();
  for (std::size_t g = 0; g < memory.groups.size(); ++g) {
    const std::vector<std::uint32_t>& members = memory.groups.members(g);
    if (members.size() < kMinMatches || !memory.camera.contradicts(members)) continue;
    memory.moving.push_back(g);
    memory.moving_rows.insert(memory.moving_rows.end(), members.begin(), members.end());
  }
  // The largest first, and equal ones by their place, so that their numbers do not depend on the input's
  // order.
  const auto key = [&memory](std::size_t g) {
    const std::vector<std::uint32_t>& members = memory.groups.members(g);
    float left = std::numeric_limits<float>::max();
    for (const std::uint32_t i : members) left = std::min(left, memory.matches.left_x[i]);
    return std::make_pair(-static_cast<std::ptrdiff_t>(members.size()), left);
  };
  std::sort(memory.moving.begin(), memory.moving.end(),
            [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
}

/// Gives the matches of a moving group its number: that of the selector's group that lies in it for the
/// most part, or the next one.
void take(const std::vector<std::uint32_t>& members, const std::vector<std::uint32_t>& rows,
          Selection& selection) {
  std::vector<GroupMotion>& motion = selection.motion;
  std::vector<std::size_t> sizes(motion.size(), 0), inside(motion.size(), 0);
  for (const std::int32_t group : selection.group)
    if (group >= 0) ++sizes[group];
  for (const std::uint32_t i : members)
    if (selection.group[rows[i]] >= 0) ++inside[selection.group[rows[i]]];
  std::int32_t number = -1;
  for (std::size_t g = 1; g < motion.size(); ++g) {
    if (inside[g] == 0 || 2 * inside[g] < sizes[g]) continue;
    motion[g] = GroupMotion::kMoving;
    if (number < 0 || inside[g] > inside[number]) number = static_cast<std::int32_t>(g);
  }
  if (number < 0) {
    number = static_cast<std::int32_t>(motion.size());
    motion.push_back(GroupMotion::kMoving);
  }
  for (const std::uint32_t i : members) {
    std::int32_t& group = selection.group[rows[i]];
    if (group <= 0 || motion[group] != GroupMotion::kMoving) group = number;
    selection.n_selected += selection.mask[rows[i]] == 0 ? 1 : 0;
    selection.mask[rows[i]] = 1;
  }
}

/// The other groups are static where most of their matches agree with the camera's motion.
void labelOthers(const MotionMemory& memory, Selection& selection) {
  std::vector<GroupMotion>& motion = selection.motion;
  std::vector<std::size_t> agreeing(motion.size(), 0), sizes(motion.size(), 0);
  for (std::size_t i = 0; i < memory.rows.size(); ++i) {
    const std::int32_t group = selection.group[memory.rows[i]];
    if (group < 0) continue;
    ++sizes[group];
    agreeing[group] += memory.camera.beyond()[i] == 0 ? 1 : 0;
  }
  for (std::size_t g = 0; g < motion.size(); ++g) {
    if (motion[g] == GroupMotion::kUnknown && 2 * agreeing[g] > sizes[g]) motion[g] = GroupMotion::kStatic;
  }
}

}  // namespace

void labelMotion(const Correspondences& matches, Selection& selection) {
  if (!selection.motion.empty() || selection.mask.size() != matches.size()) return;
  if (!matches.inconsistency().empty()) return;
  if (selection.group.empty()) {
    selection.group.resize(matches.size());
    for (std::size_t i = 0; i < matches.size(); ++i) selection.group[i] = selection.mask[i] != 0 ? 0 : -1;
  }
  const std::size_t groups = groupCount(selection);
  if (groups > matches.size()) return;  // the numbers of another package's selector may be anything
  selection.motion.assign(groups, GroupMotion::kUnknown);
  if (selection.status != Status::kOk || selection.motion.empty()) return;
  auto& memory = Workspace::ofThread().part<MotionMemory>();
  splitMatches(matches, selection, memory);
  CameraMotion& camera = memory.camera;
  if (!camera.assign(memory.matches, selection, memory.base)) return;
  findMoving(selection, memory);
  if (camera.replaceBy(memory.moving_rows)) findMoving(selection, memory);
  for (const std::size_t g : memory.moving) take(memory.groups.members(g), memory.rows, selection);
  labelOthers(memory, selection);
}

std::vector<std::uint32_t> movingRows(const Selection& selection) {
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < selection.group.size() && !selection.motion.empty(); ++i) {
    const std::int32_t group = selection.group[i];
    if (group >= 0 && selection.motion[group] == GroupMotion::kMoving)
      rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace corrsel::core
