#include "points/cell_runs.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {
namespace {

/// The cell of a coordinate; the same for all levels of precision of the caller, and monotone.
std::size_t cellOf(double offset, double cells_per_px, std::size_t side) {
  const double cell = offset * cells_per_px;
  if (!(cell > 0)) return 0;
  return cell < static_cast<double>(side) ? static_cast<std::size_t>(cell) : side - 1;
}

}  // namespace

std::size_t CellRuns::column(double x) const { return cellOf(x - low_[0], cells_per_px_[0], side_); }
std::size_t CellRuns::row(double y) const { return cellOf(y - low_[1], cells_per_px_[1], side_); }

void CellRuns::build(const float* x, const float* y, std::size_t count, std::array<double, 2> low,
                     std::array<double, 2> high) {
  // By measurement: rows of about 16 sqrt(count / 256) points.
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(count)) / 4);
  side_ = std::clamp<std::size_t>(side, 1, kMostRows);
  low_ = low;
  for (std::size_t axis = 0; axis < 2; ++axis)
    cells_per_px_[axis] = static_cast<double>(side_) / std::max(high[axis] - low[axis], 1e-6);

  const std::size_t stride = side_ + 1;
  start_.assign(side_ * stride + 1, 0);
  cell_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    cell_[i] = static_cast<std::uint32_t>(row(y[i]) * stride + column(x[i]));
    ++start_[cell_[i]];
  }
  std::uint32_t next = 0;
  for (std::size_t cell = 0; cell < start_.size(); ++cell) {
    if (cell % stride == 0) {
      next = static_cast<std::uint32_t>((next + SupportRun::kMultiple - 1) / SupportRun::kMultiple *
                                        SupportRun::kMultiple);
    }
    const std::uint32_t in_cell = start_[cell];
    start_[cell] = next;
    next += in_cell;
  }
  slot_.resize(count);
  for (std::size_t i = 0; i < count; ++i) slot_[i] = start_[cell_[i]]++;
  // Now every entry is the end of its cell, which is the start of the next one, except at the starts of rows.
  for (std::size_t cell = start_.size() - 1; cell > 0; --cell) {
    if (cell % stride != 0) start_[cell] = start_[cell - 1];
  }
  for (std::size_t begin = 0, slot = 0; begin + stride <= start_.size(); begin += stride) {
    start_[begin] = static_cast<std::uint32_t>(slot);
    slot =
        (start_[begin + side_] + SupportRun::kMultiple - 1) / SupportRun::kMultiple * SupportRun::kMultiple;
  }
}

std::size_t CellRuns::find(double x, double y, double half_width, double half_height,
                           SupportRun* runs) const {
  constexpr std::uint32_t kMask = SupportRun::kMultiple - 1;
  const std::size_t first = column(x - half_width), last = column(x + half_width) + 1;
  const std::size_t stride = side_ + 1;
  std::size_t found = 0;
  for (std::size_t r = row(y - half_height), end = row(y + half_height); r <= end; ++r) {
    const std::uint32_t begin = start_[r * stride + first] & ~kMask;
    const std::uint32_t beyond = (start_[r * stride + last] + kMask) & ~kMask;
    if (begin < beyond) runs[found++] = {begin, beyond};
  }
  return found;
}

}  // namespace corrsel::core
