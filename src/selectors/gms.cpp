#include "corrsel/selectors/gms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "corrsel/text.h"

namespace corrsel::core {
namespace {

constexpr std::int32_t kNoCell = -1;
constexpr int kShifts = 4, kRotations = 8;
// The ring of neighbours clockwise from the upper left, in units of (column, row).
constexpr int kRing[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};
constexpr double kScales[5] = {1.0, 0.5, 0.70710678118654752, 1.41421356237309505, 2.0};

/// Cell of a coordinate given as a share of the image, kNoCell beyond the last one.
std::int32_t cellAlong(double position, int cells) {
  const auto cell = static_cast<std::int32_t>(std::floor(position));
  return cell < cells ? cell : kNoCell;
}

/// Coordinates as shares of the image's sides, pulled in from up to one pixel outside; NaN for points farther
/// out.
std::vector<double> shares(const std::vector<float>& positions, int size) {
  std::vector<double> result(positions.size());
  const double largest = std::nextafter(1.0, 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double position = positions[i];
    const bool inside = position >= -1.0 && position <= size;
    result[i] = inside ? std::clamp(position / size, 0.0, largest) : std::nan("");
  }
  return result;
}

/// Matches between pairs of cells, kept zeroed between uses: only the entries that were touched are cleared.
class CellCounts {
 public:
  void resize(std::size_t left_cells, std::size_t right_cells) {
    right_cells_ = right_cells;
    if (counts_.size() < left_cells * right_cells) counts_.resize(left_cells * right_cells, 0);
  }
  std::uint32_t& at(std::int32_t left, std::int32_t right) {
    return counts_[static_cast<std::size_t>(left) * right_cells_ + static_cast<std::size_t>(right)];
  }

 private:
  std::size_t right_cells_ = 0;
  std::vector<std::uint32_t> counts_;
};

/// Scratch memory of one call.
struct Workspace {
  CellCounts counts;
  std::vector<std::int32_t> left[kShifts], right;  // cell of every match
  std::vector<std::int32_t> partner;               // per left cell: the right cell with most of its matches
  std::vector<std::uint32_t> partner_count, in_cell;  // matches to the partner, matches in the left cell
  std::vector<std::uint8_t> accepted;                 // per left cell: bit r = accepted under rotation r
  std::vector<std::uint8_t> votes;                    // per match: bit r = selected under rotation r
};

void countMatches(const std::vector<std::int32_t>& left, std::size_t left_cells, Workspace& work) {
  work.partner.assign(left_cells, kNoCell);
  work.partner_count.assign(left_cells, 0);
  work.in_cell.assign(left_cells, 0);
  for (std::size_t i = 0; i < left.size(); ++i) {
    const std::int32_t l = left[i], r = work.right[i];
    if (l == kNoCell || r == kNoCell) continue;
    const std::size_t cell = static_cast<std::size_t>(l);
    ++work.in_cell[cell];
    const std::uint32_t count = ++work.counts.at(l, r);
    // Running arg-max; the lowest right cell wins among equals.
    if (count > work.partner_count[cell] || (count == work.partner_count[cell] && r < work.partner[cell])) {
      work.partner_count[cell] = count;
      work.partner[cell] = r;
    }
  }
}

void clearCounts(const std::vector<std::int32_t>& left, Workspace& work) {
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i] != kNoCell && work.right[i] != kNoCell) work.counts.at(left[i], work.right[i]) = 0;
  }
}

/// Cell at an offset, kNoCell outside the grid.
std::int32_t neighbour(std::int32_t cell, const int (&offset)[2], int side) {
  const int column = cell % side + offset[0], row = cell / side + offset[1];
  return column < 0 || row < 0 || column >= side || row >= side ? kNoCell : row * side + column;
}

/// Tests every left cell against its partner under all rotations at once: they share the look-ups of the
/// counts.
void verifyCells(int left_side, int right_side, int rotations, double alpha, Workspace& work) {
  const std::size_t left_cells = work.partner.size();
  work.accepted.assign(left_cells, 0);
  for (std::size_t cell = 0; cell < left_cells; ++cell) {
    const std::int32_t partner = work.partner[cell];
    if (partner == kNoCell) continue;
    std::int32_t near_left[8], near_right[8];
    for (int k = 0; k < 8; ++k) {
      near_left[k] = neighbour(static_cast<std::int32_t>(cell), kRing[k], left_side);
      near_right[k] = neighbour(partner, kRing[k], right_side);
    }
    for (int rotation = 0; rotation < rotations; ++rotation) {
      std::uint64_t score = work.partner_count[cell], in_cells = work.in_cell[cell];
      int pairs = 1;
      for (int k = 0; k < 8; ++k) {
        const std::int32_t l = near_left[k], r = near_right[(k + rotation) & 7];
        if (l == kNoCell || r == kNoCell) continue;
        ++pairs;
        in_cells += work.in_cell[static_cast<std::size_t>(l)];
        score += work.counts.at(l, r);
      }
      const double threshold = alpha * std::sqrt(static_cast<double>(in_cells) / pairs);
      if (static_cast<double>(score) >= threshold) {
        work.accepted[cell] = static_cast<std::uint8_t>(work.accepted[cell] | (1U << rotation));
      }
    }
  }
}

}  // namespace

void GmsOptions::visit(OptionVisitor& visitor) {
  visitor.number({"alpha", 0, 100, "-", "Threshold factor; larger selects fewer and surer matches"}, alpha);
  visitor.integer({"grid", 2, 100, "cells", "Cells per side of the left grid"}, grid);
  visitor.flag("rotation", "Try 8 rotations of the neighbourhood, 45 degrees apart", rotation);
  visitor.flag("scale", "Try 5 sizes of the right grid between 1/2 and 2", scale);
  visitor.flag("drop_first_cells",
               "Leave out the first half cells of shifted grids, as the authors' header does",
               drop_first_cells);
}

GmsSelector::GmsSelector(GmsOptions options) : options_(std::move(options)) { options_.check(); }

Presets GmsSelector::presets() {
  return {{"rotation", {{"rotation", "true"}}},
          {"scale", {{"scale", "true"}}},
          {"rotation_scale", {{"rotation", "true"}, {"scale", "true"}}}};
}

std::string GmsSelector::missingInput(const Correspondences& matches) const {
  const auto usable = [](const cv::Size& size) { return size.width > 0 && size.height > 0; };
  if (matches.empty() || (usable(matches.left_size) && usable(matches.right_size))) return "";
  return std::string("gms needs the size of the ") + (usable(matches.left_size) ? "right" : "left") +
         " image";
}

void GmsSelector::run(const Correspondences& matches, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  // Kept between calls: clearing it costs more than a whole selection.
  thread_local Workspace work;
  work.accepted.reserve(static_cast<std::size_t>(options_.grid) * static_cast<std::size_t>(options_.grid));
  const int side = options_.grid;
  const std::size_t left_cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  const std::vector<double> left_x = shares(matches.left_x, matches.left_size.width);
  const std::vector<double> left_y = shares(matches.left_y, matches.left_size.height);
  const std::vector<double> right_x = shares(matches.right_x, matches.right_size.width);
  const std::vector<double> right_y = shares(matches.right_y, matches.right_size.height);
  for (int shift = 0; shift < kShifts; ++shift) {
    const double dx = shift & 1 ? 0.5 : 0.0, dy = shift & 2 ? 0.5 : 0.0;
    const bool drop_x = options_.drop_first_cells && dx > 0, drop_y = options_.drop_first_cells && dy > 0;
    work.left[shift].resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      std::int32_t cell = kNoCell;
      if (!std::isnan(left_x[i]) && !std::isnan(left_y[i])) {
        const std::int32_t column = cellAlong(left_x[i] * side + dx, side);
        const std::int32_t row = cellAlong(left_y[i] * side + dy, side);
        const bool dropped =
            column == kNoCell || row == kNoCell || (drop_x && column == 0) || (drop_y && row == 0);
        if (!dropped) cell = row * side + column;
      }
      work.left[shift][i] = cell;
    }
  }

  const int scales = options_.scale ? 5 : 1, rotations = options_.rotation ? kRotations : 1;
  std::size_t most = 0;
  int best_scale = 0, best_rotation = 0;
  for (int scale = 0; scale < scales; ++scale) {
    const int right_side = std::max(1, static_cast<int>(std::lround(side * kScales[scale])));
    work.right.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const bool inside = !std::isnan(right_x[i]) && !std::isnan(right_y[i]);
      work.right[i] = inside ? cellAlong(right_y[i] * right_side, right_side) * right_side +
                                   cellAlong(right_x[i] * right_side, right_side)
                             : kNoCell;
    }
    work.counts.resize(left_cells,
                       static_cast<std::size_t>(right_side) * static_cast<std::size_t>(right_side));
    work.votes.assign(n, 0);
    for (int shift = 0; shift < kShifts; ++shift) {
      const std::vector<std::int32_t>& left = work.left[shift];
      countMatches(left, left_cells, work);
      verifyCells(side, right_side, rotations, options_.alpha, work);
      for (std::size_t i = 0; i < n; ++i) {
        if (left[i] == kNoCell || work.right[i] == kNoCell) continue;
        const std::size_t cell = static_cast<std::size_t>(left[i]);
        if (work.partner[cell] == work.right[i]) {
          work.votes[i] = static_cast<std::uint8_t>(work.votes[i] | work.accepted[cell]);
        }
      }
      clearCounts(left, work);
    }
    result.iterations += kShifts * rotations;
    for (int rotation = 0; rotation < rotations; ++rotation) {
      std::size_t selected = 0;
      for (const std::uint8_t vote : work.votes) selected += (vote >> rotation) & 1U;
      if (selected <= most) continue;
      most = selected;
      best_scale = scale;
      best_rotation = rotation;
      for (std::size_t i = 0; i < n; ++i) result.mask[i] = (work.votes[i] >> rotation) & 1U;
    }
  }
  if (options_.rotation || options_.scale) {
    result.message = "rotation " + std::to_string(45 * best_rotation) + " deg, scale " +
                     formatNumber(std::round(kScales[best_scale] * 1000) / 1000);
  }
}

}  // namespace corrsel::core
