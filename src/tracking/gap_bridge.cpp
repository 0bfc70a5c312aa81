#include "corrsel/tracking/gap_bridge.h"

#include <limits>
#include <stdexcept>
#include <utility>

namespace corrsel::core {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A wrong link spoils a whole track, and a missing one only makes two of it.
constexpr float kProbable = 0.9F;

/// Which rows of the putative matches are judged, and which of them may become links.
struct Rows {
  std::vector<std::uint32_t> judged;
  std::vector<char> open;  ///< per judged row
};

Rows rowsOf(const GapTask& task, const Correspondences& matches) {
  std::vector<std::uint32_t> partner(task.newest.keypoints.size(), kNone);
  for (const FeatureLink& link : task.seen) partner[link.newest] = link.earlier;
  std::vector<char> free(task.newest.keypoints.size(), 0), lost(task.earlier.keypoints.size(), 0);
  for (const std::uint32_t i : task.free) free[i] = 1;
  for (const std::uint32_t i : task.lost) lost[i] = 1;
  Rows rows;
  for (std::uint32_t row = 0; row < matches.size(); ++row) {
    const std::uint32_t left = matches.left_index[row], right = matches.right_index[row];
    const bool open = free[left] != 0 && lost[right] != 0;
    if (!open && partner[left] != right) continue;
    rows.judged.push_back(row);
    rows.open.push_back(open ? 1 : 0);
  }
  return rows;
}

}  // namespace

GapBridge::GapBridge(std::shared_ptr<const Selector> selector, int threads)
    : selector_(std::move(selector)), threads_(threads) {
  if (selector_ == nullptr) throw std::invalid_argument("gap bridge: the selector is null; give one");
}

std::vector<FeatureLink> GapBridge::operator()(const GapTask& task) const {
  if (task.free.empty() || task.lost.empty()) return {};
  if (task.newest.descriptors.empty() || task.earlier.descriptors.empty()) return {};
  MatchOptions options;
  options.mutual = true;
  const Correspondences putative = matchFeatures(task.newest, task.earlier, options, threads_);
  const Rows rows = rowsOf(task, putative);
  const Correspondences judged = putative.subset(rows.judged);
  const Selection selection = selector_->select(judged);
  if (selection.status != Status::kOk && selection.status != Status::kTimeLimit) return {};
  std::vector<FeatureLink> links;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    if (rows.open[i] == 0 || selection.mask[i] == 0) continue;
    if (!selection.probability.empty() && selection.probability[i] < kProbable) continue;
    links.push_back({judged.left_index[i], judged.right_index[i], judged.distance[i]});
  }
  return links;
}

}  // namespace corrsel::core
