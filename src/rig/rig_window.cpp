#include "rig/rig_window.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "corrsel/search/options.h"
#include "points/length_unit.h"

namespace corrsel::core {
namespace {

constexpr double kPlace = 8;  // width of a place, in units of length of at least a pixel

cv::Size leftSizeOf(const Correspondences& matches) {
  const cv::Size size = matches.left_size.area() > 0 ? matches.left_size : matches.left_camera->size;
  if (size.width > 0 && size.height > 0) return size;
  throw std::invalid_argument(
      "the matches have no size of the left image; set left_size, or the size of its camera");
}

void check(double time, const Correspondences& matches) {
  if (!std::isfinite(time)) {
    throw std::invalid_argument("the time of the pair is " + formatNumber(time) + "; expected seconds");
  }
  const std::string missing = missingCameras(matches);
  if (!missing.empty()) throw std::invalid_argument(missing);
  const std::string wrong = matches.inconsistency();
  if (!wrong.empty()) throw std::invalid_argument(wrong);
}

/// Number of the cell of a coordinate, within 21 bits.
std::uint64_t cellOf(float value, double width) {
  constexpr double kMax = 1 << 20;
  const double cell = std::floor(std::clamp(value / width, -kMax, kMax - 1));
  return static_cast<std::uint64_t>(cell + kMax);
}

int cellOf(float value, int side, int grid) {
  return static_cast<int>(std::clamp(std::floor(grid * (value + 0.5) / side), 0.0, grid - 1.0));
}

/// The rows whose coordinates are finite, by the region of the left image.
std::vector<std::vector<std::uint32_t>> rowsByRegion(const Correspondences& m, const cv::Size& size,
                                                     int grid) {
  std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(grid * grid));
  for (std::size_t i = 0; i < m.size(); ++i) {
    const float values[] = {m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]};
    if (!std::all_of(std::begin(values), std::end(values), [](float v) { return std::isfinite(v); }))
      continue;
    const int region = cellOf(m.left_y[i], size.height, grid) * grid + cellOf(m.left_x[i], size.width, grid);
    rows[static_cast<std::size_t>(region)].push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace

std::size_t RigWindow::add(double time, const Correspondences& matches) {
  check(time, matches);
  const cv::Size size = leftSizeOf(matches);
  if (!pairs_.empty() && time <= pairs_.back().time) clear();
  // Less than the exact interval, so that stamps that jitter do not cost every other pair.
  const double interval = 0.9 * limits_.seconds / static_cast<double>(limits_.pairs);
  if (!pairs_.empty() && time - pairs_.back().time < interval) return 0;
  makeRoom(time);
  Pair pair = choose(matches, size);
  pair.time = time;
  const std::size_t count = pair.rays.size();
  if (count == 0) return 0;
  size_ += count;
  pairs_.push_back(std::move(pair));
  return count;
}

void RigWindow::clear() {
  pairs_.clear();
  taken_.clear();
  size_ = 0;
}

/// Drops the pairs that are older than the window, and of more than fit into it the oldest.
void RigWindow::makeRoom(double time) {
  while (!pairs_.empty() &&
         (time - pairs_.front().time > limits_.seconds || pairs_.size() >= limits_.pairs)) {
    for (const std::uint64_t place : pairs_.front().places) taken_.erase(place);
    size_ -= pairs_.front().rays.size();
    pairs_.pop_front();
  }
}

/// The matches that the window gets: the same number of each region, if there are so many, and each at a
/// place that it does not have.
RigWindow::Pair RigWindow::choose(const Correspondences& matches, const cv::Size& size) {
  const std::vector<std::vector<std::uint32_t>> by_region = rowsByRegion(matches, size, limits_.grid);
  const std::size_t quota = (limits_.matches + by_region.size() - 1) / by_region.size();
  const LengthUnits unit = LengthUnits::of(matches).atLeast(1);
  Pair pair;
  std::vector<std::uint32_t> chosen;
  std::vector<std::uint8_t> regions;
  std::size_t known = 0;
  for (std::size_t region = 0; region < by_region.size(); ++region) {
    const std::vector<std::uint32_t>& rows = by_region[region];
    const std::size_t step = std::max<std::size_t>(1, rows.size() / quota), end = chosen.size() + quota;
    for (std::size_t k = 0; k < rows.size() && chosen.size() < end; k += step) {
      const std::uint32_t row = rows[k];
      const std::uint64_t place = (cellOf(matches.left_x[row], kPlace * unit.left) << 42) |
                                  (cellOf(matches.left_y[row], kPlace * unit.left) << 21) |
                                  cellOf(matches.right_x[row], kPlace * unit.right);
      if (taken_.count(place) > 0) {
        ++known;
        continue;
      }
      pair.places.push_back(place);
      chosen.push_back(row);
      regions.push_back(static_cast<std::uint8_t>(region));
    }
  }
  if (known > chosen.size()) return {};
  taken_.insert(pair.places.begin(), pair.places.end());
  RayMatches rays;
  std::vector<std::uint8_t> exists;
  unproject(matches.subset(chosen), rays, exists);
  const std::vector<std::uint32_t> existing = selectedRows(exists);
  gatherRays(rays, existing, pair.rays);
  for (const std::uint32_t row : existing) pair.regions.push_back(regions[row]);
  return pair;
}

}  // namespace corrsel::core
