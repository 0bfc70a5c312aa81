#include "auto/leftover.h"

#include <algorithm>

#include "base/gather.h"

namespace corrsel::core {
namespace {

constexpr double kSamePlace = 4;  // units of the image
constexpr std::size_t kMinPlaces = 6;
constexpr double kShareOfExplained = 0.04, kShareOfOthers = 0.02;

}  // namespace

bool Leftover::isSizable(std::size_t count, std::size_t explained) const {
  const auto c = static_cast<double>(count), m = static_cast<double>(explained);
  const auto n = static_cast<double>(matches_->size());
  return count >= kMinPlaces && c > kShareOfExplained * (c + m) && c > kShareOfOthers * (n - m);
}

int Leftover::countOutside(const std::uint32_t* nearest, int count, std::size_t member,
                           const std::vector<std::uint8_t>& explained, int& seen) const {
  const auto isNear = [](float ax, float ay, float bx, float by, double unit) {
    return (ax - bx) * (ax - bx) + (ay - by) * (ay - by) <= kSamePlace * kSamePlace * unit * unit;
  };
  int outside = 0, used = 0;
  for (int i = 0; i < count && used < kNearest; ++i) {
    const std::uint32_t other = nearest[i];
    if (isNear(left_x_[member], left_y_[member], left_x_[other], left_y_[other], units_.left) &&
        isNear(right_x_[member], right_y_[member], right_x_[other], right_y_[other], units_.right)) {
      continue;
    }
    ++used;
    outside += explained[members_[other]] == 0 ? 1 : 0;
  }
  seen += used;
  return outside;
}

std::size_t Leftover::coherent(const std::vector<std::uint8_t>& local,
                               const std::vector<std::uint8_t>& explained) {
  const Correspondences& m = *matches_;
  members_.clear();
  for (std::uint32_t i = 0; i < m.size(); ++i)
    if (local[i] != 0 || explained[i] != 0) members_.push_back(i);
  left_over_.clear();
  for (std::uint32_t i = 0; i < members_.size(); ++i)
    if (explained[members_[i]] == 0) left_over_.push_back(i);
  coherent_.assign(m.size(), 0);
  if (members_.size() < kMinPlaces || left_over_.empty()) return 0;
  gather(m.left_x, members_, left_x_);
  gather(m.left_y, members_, left_y_);
  gather(m.right_x, members_, right_x_);
  gather(m.right_y, members_, right_y_);
  const int listed = std::min(kListed, static_cast<int>(members_.size()));
  const auto list = [&](PlanarNeighbours& index, const std::vector<float>& x, const std::vector<float>& y,
                        std::vector<std::uint32_t>& nearest) {
    index.build(x.data(), y.data(), members_.size(), listed);
    nearest.resize(left_over_.size() * static_cast<std::size_t>(listed));
    index.nearestToAll(x.data(), y.data(), left_over_.size(), listed, nearest.data(), left_over_.data());
  };
  list(left_, left_x_, left_y_, nearest_left_);
  list(right_, right_x_, right_y_, nearest_right_);
  for (std::size_t i = 0; i < left_over_.size(); ++i) {
    const std::size_t row = i * static_cast<std::size_t>(listed);
    int seen = 0;
    int outside = countOutside(&nearest_left_[row], listed, left_over_[i], explained, seen);
    outside += countOutside(&nearest_right_[row], listed, left_over_[i], explained, seen);
    coherent_[members_[left_over_[i]]] = 2 * outside > seen ? 1 : 0;
  }
  return distinctPlaces(coherent_);
}

}  // namespace corrsel::core
