#include "selectors/parts/pair_matrix.h"

#include <algorithm>

namespace corrsel::core {
namespace {

constexpr std::size_t kRows = PairBlock::kRows, kColumns = PairBlock::kColumns;

// Rows after which single precision sums are moved to double precision ones.
constexpr std::size_t kRowsPerSum = 256;

// Columns computed and multiplied at once: 16 KiB stay in the first-level cache. Also the columns after which
// single precision sums are moved to double precision ones, stored or not.
constexpr std::size_t kBlockColumns = 2048;

// Pairs between two looks at the clock, well below a millisecond.
constexpr std::size_t kPairsPerCheck = 1 << 18;

std::size_t firstColumn(std::size_t row) { return row / kColumns * kColumns; }

/// What lies on and below the diagonal is the other half.
void clearLowerHalf(std::size_t row, std::size_t begin, std::uint16_t* block) {
  for (std::size_t r = 0; r < kRows; ++r) {
    for (std::size_t j = begin; j < begin + kColumns && j <= row + r; ++j)
      block[r * kColumns + j - begin] = 0;
  }
}

}  // namespace

std::size_t PairMatrix::bytesFor(std::size_t n) {
  // Rows in groups of kColumns start at the same column.
  const std::size_t groups = (n + kColumns - 1) / kColumns;
  return groups * (groups + 1) / 2 * kColumns * kColumns * sizeof(std::uint16_t);
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
    blocks_.reset(new std::uint16_t[stored_bytes_ / sizeof(std::uint16_t)]);
    capacity_ = stored_bytes_;
  }
  if (!isStored()) scratch_.resize(kRows * kBlockColumns);
}

void PairMatrix::release() {
  if (capacity_ <= kKeptBytes) return;
  blocks_.reset();
  capacity_ = stored_bytes_ = 0;
}

bool PairMatrix::multiply(const double* v, double* y, const Deadline& deadline) {
  if (deadline.passed()) return false;
  const std::size_t length = columns_.size;
  const PairKernels& kernel = kernels().pairs;
  const auto compute = kernel.block[static_cast<std::size_t>(value_)];
  v_.assign(length, 0);
  for (std::size_t i = 0; i < n_; ++i) v_[i] = static_cast<float>(v[i]);
  partial_.assign(length, 0);
  y_.assign(length, 0);
  std::uint16_t* stored = blocks_.get();
  std::size_t pairs = 0;
  for (std::size_t row = 0; row < length; row += kRows) {
    const std::size_t first = firstColumn(row);
    for (std::size_t begin = first; begin < length; begin += kBlockColumns) {
      const std::size_t end = std::min(begin + kBlockColumns, length);
      std::uint16_t* const block = isStored() ? stored : scratch_.data();
      if (!isStored() || !filled_) {
        compute(columns_, rule_, row, begin, end, block);
        if (begin == first) clearLowerHalf(row, begin, block);
      }
      kernel.product(block, end - begin, v_.data() + row, v_.data() + begin, partial_.data() + begin,
                     y_.data() + row);
      if (isStored()) stored += kRows * (end - begin);
    }
    if ((row + kRows) % kRowsPerSum == 0 || row + kRows == length) {
      for (std::size_t j = firstColumn(row / kRowsPerSum * kRowsPerSum); j < length; ++j) {
        y_[j] += static_cast<double>(partial_[j]);
        partial_[j] = 0;
      }
    }
    pairs += kRows * (length - first);
    if (pairs >= kPairsPerCheck) {
      pairs = 0;
      if (deadline.passed()) return false;
    }
  }
  filled_ = true;
  for (std::size_t i = 0; i < n_; ++i) y[i] = y_[i] / static_cast<double>(PairBlock::kOne);
  return true;
}

PairWorkspace& PairWorkspace::ofThread() {
  thread_local PairWorkspace workspace;
  return workspace;
}

}  // namespace corrsel::core
