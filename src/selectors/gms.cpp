#include "corrsel/selectors/gms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/text.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr int kShifts = 4, kRotations = 8;
// The ring of neighbours clockwise from the upper left, in units of (column, row).
constexpr int kRing[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};
constexpr double kScales[5] = {1.0, 0.5, 0.70710678118654752, 1.41421356237309505, 2.0};
constexpr std::uint16_t kOutside = 0xFFFF;  // more than the cells of any grid

ImageGrid gridOver(const cv::Size& size, int side) {
  const double enlarged = side * (1.0 + std::ldexp(1.0, -40));
  return {enlarged / size.width,
          enlarged / size.height,
          static_cast<float>(size.width),
          static_cast<float>(size.height),
          side,
          kOutside};
}

/// Gives the cell `to` to all matches that are outside in one of the images.
void moveOutside(std::uint16_t* cells, const std::uint16_t* right, std::size_t n, std::uint16_t to) {
  for (std::size_t i = 0; i < n; ++i) {
    const bool outside = (cells[i] == kOutside) | (right[i] == kOutside);
    cells[i] = outside ? to : cells[i];
  }
}

/// The four left grids and the memory that a call needs. It is kept between calls.
class Voting {
 public:
  /// Prepares the tables of a left grid and finds the half cells of the matches.
  void start(const Correspondences& matches, int side, bool drop_first_cells) {
    if (side != side_ || drop_first_cells != drop_first_cells_) layOut(side, drop_first_cells);
    size_ = matches.size();
    half_.resize(size_);
    right_.resize(size_);
    votes_.resize(size_);
    const Kernels& kernel = kernels();
    kernel.gms.cells(matches.left_x.data(), matches.left_y.data(), size_,
                     gridOver(matches.left_size, 2 * side_), half_.data());
    findRightCells(matches, side_);
    const auto outside = static_cast<std::uint16_t>(4 * side_ * side_);
    moveOutside(half_.data(), right_.data(), size_, outside);
    countLeftCells();
    sortByHalfRow();
  }

  /// Finds the votes with a right grid of `right_side` cells per side. @return the number per rotation
  void vote(const Correspondences& matches, int right_side, int rotations, double alpha,
            std::uint32_t (&selected)[kRotations]) {
    const Kernels& kernel = kernels();
    findRightCells(matches, right_side);
    // Matches that are outside have no left cell either.
    moveOutside(right_.data(), right_.data(), size_, 0);
    for (std::size_t i = 0; i < size_; ++i) sorted_right_[i] = right_[order_[i]];
    const CellPairs pairs = {sorted_half_.data(), sorted_right_.data(), cells_of_half_.data(), size_};
    makeRoom(right_side);
    forgetBeforeOverflow();
    const std::uint32_t* decisions[kShifts];
    for (int shift = 0; shift < kShifts; ++shift) {
      // Counts of three rows at a time are enough, and stay in the processor's cache.
      countRow(pairs, shift, 0, right_side);
      for (int row = 0; row < side_; ++row) {
        if (row + 1 < side_) countRow(pairs, shift, row + 1, right_side);
        const CellStatistics statistics = {
            {row > 0 ? rows_[(row + 2) % 3] : CountRow{zeros_.data(), 0}, rows_[row % 3],
             row + 1 < side_ ? rows_[(row + 1) % 3] : CountRow{zeros_.data(), 0}},
            zeros_.data(),
            best_.data(),
            in_cell_[shift].data(),
            neighbours_.data(),
            noCell(),
            row,
            side_,
            right_side,
            alpha};
        const auto verify = rotations > 1 ? kernel.gms.verify_rotations : kernel.gms.verify;
        verify(statistics, decisions_[shift].data());
      }
      decisions[shift] = decisions_[shift].data();
    }
    kernel.gms.vote(pairs, decisions, votes_.data());
    kernel.gms.count_votes(votes_.data(), size_, selected);
  }

  void select(int rotation, std::uint8_t* mask) const {
    const std::uint8_t* const votes = votes_.data();
    const std::uint32_t* const order = order_.data();
    for (std::size_t i = 0; i < size_; ++i) mask[order[i]] = (votes[i] >> rotation) & 1U;
  }

 private:
  std::size_t cells() const { return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }
  /// Matches without a left cell are counted here.
  std::uint32_t lostCell() const { return static_cast<std::uint32_t>(side_ * side_); }
  /// The number of all cells outside the grid.
  std::uint32_t noCell() const { return lostCell() + 1; }

  void layOut(int side, bool drop_first_cells) {
    side_ = side;
    drop_first_cells_ = drop_first_cells;
    best_.assign(cells() + 1, 0);
    for (int shift = 0; shift < kShifts; ++shift) {
      decisions_[shift].assign(cells() + 1, CellStatistics::kNoPartner);
      in_cell_[shift].assign(cells() + 2, 0);
    }
    in_half_.resize(4 * cells() + 1);
    cells_of_half_.resize(4 * cells() + 1);
    row_of_half_.assign(4 * cells() + 1, static_cast<std::uint16_t>(2 * side));
    row_begin_.resize(2 * static_cast<std::size_t>(side) + 2);
    for (int row = 0; row < 2 * side; ++row) {
      for (int column = 0; column < 2 * side; ++column) {
        row_of_half_[static_cast<std::size_t>(row * 2 * side + column)] = static_cast<std::uint16_t>(row);
        ShiftedCells& cells_of = cells_of_half_[static_cast<std::size_t>(row * 2 * side + column)];
        for (int shift = 0; shift < kShifts; ++shift) {
          const int dx = shift & 1, dy = shift >> 1, c = (column + dx) / 2, r = (row + dy) / 2;
          const bool dropped =
              c == side || r == side || (drop_first_cells && ((dx == 1 && c == 0) || (dy == 1 && r == 0)));
          cells_of.shifted[shift] = static_cast<std::uint16_t>(dropped ? side * side : r * side + c);
        }
      }
    }
    const auto lost = static_cast<std::uint16_t>(lostCell());
    cells_of_half_.back() = {{lost, lost, lost, lost}};
    neighbours_.resize(cells());
    for (int cell = 0; cell < side * side; ++cell) {
      LeftNeighbours& near = neighbours_[static_cast<std::size_t>(cell)];
      near.inside = 0;
      for (int k = 0; k < 8; ++k) {
        const int column = cell % side + kRing[k][0], row = cell / side + kRing[k][1];
        const bool inside = column >= 0 && row >= 0 && column < side && row < side;
        near.cell[k] = inside ? static_cast<std::uint32_t>(row * side + column) : noCell();
        near.inside += inside ? 1 : 0;
      }
    }
  }

  void findRightCells(const Correspondences& matches, int right_side) {
    kernels().gms.cells(matches.right_x.data(), matches.right_y.data(), size_,
                        gridOver(matches.right_size, right_side), right_.data());
  }

  /// Matches per left cell of the four grids, by way of the half cells that they share.
  void countLeftCells() {
    std::fill(in_half_.begin(), in_half_.end(), 0U);
    for (const std::uint16_t half : half_) ++in_half_[half];
    for (int shift = 0; shift < kShifts; ++shift) {
      std::vector<std::uint32_t>& in_cell = in_cell_[shift];
      std::fill(in_cell.begin(), in_cell.end(), 0U);
      for (std::size_t half = 0; half + 1 < in_half_.size(); ++half)
        in_cell[cells_of_half_[half].shifted[shift]] += in_half_[half];
    }
  }

  /// Matches in the order of their half rows, those without a cell last.
  void sortByHalfRow() {
    order_.resize(size_);
    sorted_half_.resize(size_);
    sorted_right_.resize(size_);
    std::fill(row_begin_.begin(), row_begin_.end(), 0U);
    for (std::size_t half = 0; half < in_half_.size(); ++half)
      row_begin_[row_of_half_[half] + 1U] += in_half_[half];
    for (std::size_t row = 1; row < row_begin_.size(); ++row) row_begin_[row] += row_begin_[row - 1];
    next_in_row_ = row_begin_;
    std::uint32_t* const next = next_in_row_.data();
    const std::uint16_t* const row_of_half = row_of_half_.data();
    for (std::size_t i = 0; i < size_; ++i) {
      const std::uint16_t half = half_[i];
      const std::uint32_t place = next[row_of_half[half]]++;
      order_[place] = static_cast<std::uint32_t>(i);
      sorted_half_[place] = half;
    }
  }

  void makeRoom(int right_side) {
    const std::size_t right_cells =
        static_cast<std::size_t>(right_side) * static_cast<std::size_t>(right_side);
    const std::size_t entries = static_cast<std::size_t>(side_ + 1) * right_cells;
    if (counts_.size() < 3 * entries) counts_.resize(3 * entries, 0);
    if (zeros_.size() < right_cells) zeros_.resize(right_cells, 0);
    for (std::size_t k = 0; k < 3; ++k) rows_[k] = {counts_.data() + k * entries, base_};
  }

  /// Clears the counts, which is needed once in a few hundred calls or more.
  void forgetBeforeOverflow() {
    const std::uint64_t to_come = last_use_ + static_cast<std::uint64_t>(kShifts) * size_;
    if (base_ + to_come <= std::numeric_limits<std::uint32_t>::max()) return;
    std::fill(counts_.begin(), counts_.end(), 0U);
    std::fill(best_.begin(), best_.end(), 0U);
    base_ = 0;
    last_use_ = 0;
  }

  void countRow(const CellPairs& pairs, int shift, int row, int right_side) {
    const int first = 2 * row - (shift >> 1), end = first + 2;
    const std::size_t begin = row_begin_[static_cast<std::size_t>(std::max(first, 0))];
    const std::size_t stop = row_begin_[static_cast<std::size_t>(end)];
    nextUse(stop - begin);
    rows_[row % 3].base = base_;
    kernels().gms.count(pairs, begin, stop, shift, row, side_,
                        static_cast<std::size_t>(right_side) * static_cast<std::size_t>(right_side),
                        rows_[row % 3], best_.data());
  }

  /// Raises the base, so that what was counted in a row's memory before counts as zero while up to `matches`
  /// are counted. Clearing the memory would take longer than counting.
  void nextUse(std::size_t matches) {
    base_ += static_cast<std::uint32_t>(last_use_);
    last_use_ = matches;
  }

  int side_ = 0;
  bool drop_first_cells_ = false;
  std::vector<ShiftedCells> cells_of_half_;
  std::vector<std::uint16_t> row_of_half_;
  std::vector<LeftNeighbours> neighbours_;

  std::size_t size_ = 0;
  std::vector<std::uint16_t> half_, right_;  // per match
  std::vector<std::uint32_t> in_half_, in_cell_[kShifts], decisions_[kShifts];

  // Per match, sorted by half row.
  std::vector<std::uint32_t> order_, row_begin_, next_in_row_;
  std::vector<std::uint16_t> sorted_half_, sorted_right_;
  std::vector<std::uint8_t> votes_;  // bit r = selected under rotation r

  std::vector<std::uint32_t> counts_, zeros_;  // see CountRow
  CountRow rows_[3] = {};                      // row r of the grid is in rows_[r % 3]
  std::vector<std::uint64_t> best_;
  // The start value lets the first clearing happen after a few dozen calls, so that tests reach it.
  std::uint32_t base_ = 0xFFF00000U;
  std::size_t last_use_ = 0;  // entries are at most base + this
};

}  // namespace

void GmsOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"alpha", 0, 100, "-", "Threshold factor; larger selects fewer and surer matches"},
                 &GmsOptions::alpha);
  visitor.integer({"grid", 2, 100, "cells", "Cells per side of the left grid"}, &GmsOptions::grid);
  visitor.flag("rotation", "Try 8 rotations of the neighbourhood, 45 degrees apart", &GmsOptions::rotation);
  visitor.flag("scale", "Try 5 sizes of the right grid between 1/2 and 2", &GmsOptions::scale);
  visitor.flag("drop_first_cells",
               "Leave out the first half cells of shifted grids, as the authors' header does",
               &GmsOptions::drop_first_cells);
  visitConfidence(visitor);
}

Presets GmsSelector::presets() const {
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

void GmsSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  Voting& work = workspace.part<Voting>();
  work.start(matches, options_.grid, options_.drop_first_cells);
  const int scales = options_.scale ? 5 : 1, rotations = options_.rotation ? kRotations : 1;
  std::uint32_t max_selected = 0;
  int best_scale = 0, best_rotation = 0;
  for (int scale = 0; scale < scales; ++scale) {
    const int right_side = std::max(1, static_cast<int>(std::lround(options_.grid * kScales[scale])));
    std::uint32_t selected[kRotations];
    work.vote(matches, right_side, rotations, options_.alpha, selected);
    result.iterations += kShifts * rotations;
    for (int rotation = 0; rotation < rotations; ++rotation) {
      if (selected[rotation] <= max_selected) continue;
      max_selected = selected[rotation];
      best_scale = scale;
      best_rotation = rotation;
      work.select(rotation, result.mask.data());
    }
  }
  if (options_.rotation || options_.scale) {
    result.message = "rotation " + std::to_string(45 * best_rotation) + " deg, scale " +
                     formatNumber(std::round(kScales[best_scale] * 1000) / 1000);
  }
}

}  // namespace corrsel::core
