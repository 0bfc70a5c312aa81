#include "motion/coherent_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace corrsel::core {
namespace {

constexpr int kCandidates = 13, kNearest = 9;  // with the match itself
constexpr int kMinAgreeing = 3, kMinVotes = 2;
constexpr std::size_t kMinPlaces = 6;
constexpr double kMinShare = 0.02;
constexpr float kSamePlace = 3, kTolerance = 3;  // px
constexpr float kRelativeTolerance = 0.3F;

}  // namespace

bool CoherentGroups::agree(std::uint32_t a, std::uint32_t b) const {
  const Correspondences& m = *matches_;
  const float ux = m.left_x[a] - m.left_x[b], uy = m.left_y[a] - m.left_y[b];
  const float vx = m.right_x[a] - m.right_x[b], vy = m.right_y[a] - m.right_y[b];
  const float length = std::hypot(ux, uy);
  if (length <= kSamePlace || std::hypot(vx, vy) <= kSamePlace) return false;
  return std::hypot(vx - ux, vy - uy) <= kTolerance + kRelativeTolerance * length;
}

std::uint32_t CoherentGroups::rootOf(std::uint32_t i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void CoherentGroups::find(const Correspondences& matches, const std::vector<std::uint8_t>& candidate,
                          const std::vector<std::uint8_t>& still) {
  matches_ = &matches;
  members_.clear();
  candidates_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i)
    if (candidate[i] != 0) candidates_.push_back(i);
  if (candidates_.size() < kMinPlaces) return;
  still_ = static_cast<std::size_t>(std::count(still.begin(), still.end(), 1));
  findSeeds();
  unite();
  if (members_.empty()) return;
  points_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i)
    if (group_[i] >= 0 || still[i] != 0) points_.push_back(i);
  listNearest(matches.right_x, matches.right_y);
  dropInterleaved();
  listNearest(matches.left_x, matches.left_y);
  dropInterleaved();
  join(candidate);
}

void CoherentGroups::findSeeds() {
  const Correspondences& m = *matches_;
  const int k = static_cast<int>(std::min<std::size_t>(kCandidates, candidates_.size()));
  neighbours_.build(m.left_x.data(), m.left_y.data(), candidates_.size(), k, candidates_.data());
  near_.resize(candidates_.size() * k);
  seed_.assign(m.size(), 0);
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    const std::uint32_t i = candidates_[c];
    std::uint32_t* const near = near_.data() + c * k;
    neighbours_.nearest(m.left_x[i], m.left_y[i], k, near);
    int agreeing = 0;
    for (int n = 0; n < k; ++n) agreeing += agree(i, near[n]) ? 1 : 0;
    seed_[i] = agreeing >= kMinAgreeing ? 1 : 0;
  }
}

/// Writes the groups of the seeds into group_ and members_.
void CoherentGroups::unite() {
  const std::size_t n = matches_->size(), k = near_.size() / candidates_.size();
  parent_.resize(n);
  std::iota(parent_.begin(), parent_.end(), 0U);
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    const std::uint32_t i = candidates_[c];
    if (seed_[i] == 0) continue;
    for (std::size_t near = c * k; near < (c + 1) * k; ++near) {
      const std::uint32_t other = near_[near];
      if (seed_[other] != 0 && agree(i, other)) parent_[rootOf(other)] = rootOf(i);
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> groups;
  for (const std::uint32_t i : candidates_)
    if (seed_[i] != 0) groups[rootOf(i)].push_back(i);
  group_.assign(n, -1);
  for (auto& [root, rows] : groups) {
    if (!isSizable(rows)) continue;
    for (const std::uint32_t i : rows) group_[i] = static_cast<std::int32_t>(members_.size());
    members_.push_back(std::move(rows));
  }
}

/// Lists for every match the nearest ones among the seeds of groups and the static ones in one image.
void CoherentGroups::listNearest(const std::vector<float>& x, const std::vector<float>& y) {
  listed_ = std::min<std::size_t>(kNearest, points_.size());
  const int k = static_cast<int>(listed_);
  neighbours_.build(x.data(), y.data(), points_.size(), k, points_.data());
  near_.resize(x.size() * listed_);
  neighbours_.nearestToAll(x.data(), y.data(), x.size(), k, near_.data());
}

/// Whether there are more matches than chance and repeated structure let agree.
bool CoherentGroups::isSizable(const std::vector<std::uint32_t>& rows) {
  if (rows.size() < kMinPlaces) return false;
  in_.assign(matches_->size(), 0);
  for (const std::uint32_t i : rows) in_[i] = 1;
  const std::size_t places = cells_.count(*matches_, in_);
  const auto c = static_cast<double>(places);
  return places >= kMinPlaces && c > kMinShare * (c + static_cast<double>(still_)) &&
         c > kMinShare * static_cast<double>(candidates_.size());
}

void CoherentGroups::dropInterleaved() {
  for (std::size_t g = 0; g < members_.size(); ++g) {
    std::size_t own = 0, seen = 0;
    for (const std::uint32_t i : members_[g]) {
      for (std::size_t n = i * listed_; n < (i + 1) * listed_; ++n) {
        if (near_[n] == i) continue;
        ++seen;
        own += group_[near_[n]] == static_cast<std::int32_t>(g) ? 1 : 0;
      }
    }
    if (2 * own > seen) continue;
    for (const std::uint32_t i : members_[g]) group_[i] = -1;
  }
}

/// Replaces the seeds in members_ by all matches that join their groups.
void CoherentGroups::join(const std::vector<std::uint8_t>& candidate) {
  for (auto& rows : members_) rows.clear();
  std::vector<int> votes(members_.size()), agreeing(members_.size());
  for (std::uint32_t i = 0; i < matches_->size(); ++i) {
    std::fill(votes.begin(), votes.end(), 0);
    std::fill(agreeing.begin(), agreeing.end(), 0);
    for (std::size_t n = i * listed_; n < (i + 1) * listed_; ++n) {
      const std::uint32_t other = near_[n];
      if (other == i || group_[other] < 0) continue;
      ++votes[group_[other]];
      agreeing[group_[other]] += agree(i, other) ? 1 : 0;
    }
    const auto most = std::max_element(votes.begin(), votes.end()) - votes.begin();
    const int needed = candidate[i] != 0 ? kMinVotes : kNearest / 2 + 1;
    if (votes[most] >= needed && 2 * agreeing[most] >= votes[most]) members_[most].push_back(i);
  }
}

}  // namespace corrsel::core
