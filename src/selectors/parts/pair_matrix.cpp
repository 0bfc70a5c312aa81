#include "selectors/parts/pair_matrix.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "base/parallel.h"
#include "base/text.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kRows = PairBlock::kRows, kColumns = PairBlock::kColumns;

// Rows after which single precision sums are moved to double precision ones.
constexpr std::size_t kPanelRows = 256;

// Panels of a product that are in memory at once, per thread: enough that no thread waits long for the last.
constexpr std::size_t kPanelsPerThread = 16;

// With fewer panels starting threads takes longer than the product.
constexpr std::size_t kMinPanels = 8;

// Columns computed and multiplied at once: 16 KiB stay in the first-level cache. Also the columns after which
// single precision sums are moved to double precision ones, stored or not.
constexpr std::size_t kBlockColumns = 2048;

// Pairs between two looks at the clock, well below a millisecond.
constexpr std::size_t kPairsPerCheck = 1 << 18;

std::size_t firstColumn(std::size_t row) { return row / kColumns * kColumns; }

std::size_t blocksOf(std::size_t columns) { return (columns + kBlockColumns - 1) / kBlockColumns; }

/// Elements stored for the rows before `row`, a multiple of kColumns, of a matrix with `length` columns. Rows
/// in groups of kColumns start at the same column.
std::size_t elementsBefore(std::size_t row, std::size_t length) {
  const std::size_t groups = row / kColumns;
  return kColumns * groups * length - kColumns * kColumns * (groups * (groups - 1) / 2);
}

/// What lies on and below the diagonal is the other half.
void clearLowerHalf(std::size_t row, std::size_t begin, std::uint16_t* block) {
  for (std::size_t r = 0; r < kRows; ++r) {
    for (std::size_t j = begin; j < begin + kColumns && j <= row + r; ++j)
      block[r * kColumns + j - begin] = 0;
  }
}

}  // namespace

std::size_t PairMatrix::bytesFor(std::size_t n) {
  const std::size_t length = (n + kColumns - 1) / kColumns * kColumns;
  return elementsBefore(length, length) * sizeof(std::uint16_t);
}

void PairMatrix::assign(PairValue value, const PairRule& rule, const PairColumns& columns, std::size_t n,
                        std::size_t memory_limit) {
  value_ = value;
  rule_ = rule;
  columns_ = columns;
  n_ = n;
  filled_ = false;
  const std::size_t bytes = bytesFor(n);
  stored_bytes_ = bytes <= memory_limit ? bytes : 0;
  if (stored_bytes_ > capacity_) {
    blocks_.reset();
    capacity_ = 0;
    blocks_ = makeLargeArray<std::uint16_t>(stored_bytes_ / sizeof(std::uint16_t));
    capacity_ = stored_bytes_;
  }
}

void PairMatrix::release() {
  if (capacity_ <= kKeptBytes) return;
  blocks_.reset();
  capacity_ = stored_bytes_ = 0;
}

bool PairMatrix::multiply(const double* v, double* y, const Deadline& deadline, int threads) {
  const std::size_t length = columns_.size;
  v_.assign(length, 0);
  for (std::size_t i = 0; i < n_; ++i) v_[i] = static_cast<float>(v[i]);
  y_.assign(length, 0);
  const std::size_t panels = (length + kPanelRows - 1) / kPanelRows;
  if (panels < kMinPanels) threads = 1;
  // Panels are added up in their order, whichever thread has multiplied them.
  const std::size_t at_once = threads > 1 ? std::min(panels, kPanelsPerThread * std::size_t(threads)) : 1;
  if (panels_.size() < at_once) panels_.resize(at_once);
  std::atomic<bool> stopped{false};
  for (std::size_t first = 0; first < panels && !stopped; first += at_once) {
    const std::size_t count = std::min(at_once, panels - first);
    forEachBlock(count, 1, threads, [&](std::size_t k, std::size_t) {
      if (!stopped && !multiplyPanel((first + k) * kPanelRows, deadline, panels_[k])) stopped = true;
    });
    for (std::size_t k = 0; k < count && !stopped; ++k) add((first + k) * kPanelRows, panels_[k]);
  }
  if (stopped) return false;
  filled_ = true;
  for (std::size_t i = 0; i < n_; ++i) y[i] = y_[i] / static_cast<double>(PairBlock::kOne);
  return true;
}

bool PairMatrix::multiplyPanel(std::size_t begin_row, const Deadline& deadline, Panel& panel) {
  if (deadline.passed()) return false;
  const std::size_t length = columns_.size, end_row = std::min(begin_row + kPanelRows, length);
  const PairKernels& kernel = kernels().pairs;
  const auto compute = kernel.block[static_cast<std::size_t>(value_)];
  alignas(64) std::uint16_t scratch[kRows * kBlockColumns];
  panel.of_columns.assign(length - begin_row, 0);
  panel.of_rows.assign(blocksOf(length - begin_row) * kPanelRows, 0);
  std::uint16_t* stored = isStored() ? blocks_.get() + elementsBefore(begin_row, length) : nullptr;
  std::size_t pairs = 0;
  for (std::size_t row = begin_row; row < end_row; row += kRows) {
    const std::size_t first = firstColumn(row);
    double* of_rows = panel.of_rows.data() + (row - begin_row);
    for (std::size_t begin = first; begin < length; begin += kBlockColumns) {
      const std::size_t end = std::min(begin + kBlockColumns, length);
      std::uint16_t* const block = isStored() ? stored : scratch;
      if (!isStored() || !filled_) {
        compute(columns_, rule_, row, begin, end, block);
        if (begin == first) clearLowerHalf(row, begin, block);
      }
      kernel.product(block, end - begin, v_.data() + row, v_.data() + begin,
                     panel.of_columns.data() + (begin - begin_row), of_rows);
      if (isStored()) stored += kRows * (end - begin);
      of_rows += kPanelRows;
    }
    pairs += kRows * (length - first);
    if (pairs >= kPairsPerCheck) {
      pairs = 0;
      if (deadline.passed()) return false;
    }
  }
  return true;
}

void PairMatrix::add(std::size_t begin_row, const Panel& panel) {
  const std::size_t length = columns_.size, rows = std::min(kPanelRows, length - begin_row);
  double* const y = y_.data() + begin_row;
  for (std::size_t block = 0; block < blocksOf(length - begin_row); ++block) {
    for (std::size_t i = 0; i < rows; ++i) y[i] += panel.of_rows[block * kPanelRows + i];
  }
  for (std::size_t j = 0; j < length - begin_row; ++j) y[j] += static_cast<double>(panel.of_columns[j]);
}

void PairMemory::assign(const Correspondences& matches, PairValue value, const PairRule& rule,
                        int memory_limit) {
  std::vector<std::uint32_t> rows(matches.size());
  std::iota(rows.begin(), rows.end(), 0U);
  distinct.assign(matches, {}, rows);
  matrix.assign(value, rule, distinct.columns(), distinct.size(),
                static_cast<std::size_t>(memory_limit) << 20);
}

bool writeScores(const DistinctMatches& distinct, const double* values, bool timed_out, double max_seconds,
                 Selection& result) {
  const std::size_t n = result.mask.size();
  if (timed_out) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    result.message = "stopped after " + std::to_string(result.iterations) +
                     " products, max_seconds = " + formatNumber(max_seconds);
    if (result.iterations == 0) return false;
  } else if (distinct.size() == 1 && n > 1) {
    result.status = Status::kDegenerate;
    result.message = "all matches are equal";
  } else if (std::all_of(values, values + distinct.size(), [](double value) { return value == 0; })) {
    result.message = "no two matches agree";
  }
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) result.score[i] = static_cast<float>(values[distinct.ofRow(i)]);
  return true;
}

}  // namespace corrsel::core
