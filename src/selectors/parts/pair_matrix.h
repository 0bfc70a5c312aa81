#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/deadline.h"
#include "base/large_array.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "kernels/kernels.h"
#include "points/distinct_matches.h"

namespace corrsel::core {

/// The symmetric N x N matrix of the values that pairs of matches have, in [0, 1], zero on the diagonal.
///
/// Values are rounded to 16 bits, an error of at most 2^-17 (7.7e-6) each. The upper half is computed
/// together with the first product and kept, N^2 bytes, unless that exceeds the memory limit: then every
/// product computes it again.
///
/// A product runs over panels of 256 rows, whose sums are in single precision; panels are added up in double
/// precision and in a fixed order. Products are therefore bit-identical for any number of threads, at any
/// kernel level, and whether the values are stored or not.
///
/// One object is used by one thread at a time. Up to kKeptBytes of its memory stay with it from one assign()
/// to the next.
class PairMatrix {
 public:
  static constexpr std::size_t kKeptBytes = std::size_t{256} << 20;

  /// @param columns       N matches, kept by reference
  /// @param memory_limit  bytes that may be stored
  void assign(PairValue value, const PairRule& rule, const PairColumns& columns, std::size_t n,
              std::size_t memory_limit);

  /// y = A v for N values; v is rounded to single precision. O(N^2) time.
  /// @param threads  that may be used, the caller's included
  /// @return false where the deadline passed before the end: y is then meaningless
  bool multiply(const double* v, double* y, const Deadline& deadline, int threads = 1);

  bool isStored() const { return stored_bytes_ > 0; }

  /// Bytes that the stored form of N matches takes.
  static std::size_t bytesFor(std::size_t n);

  /// Gives back what exceeds kKeptBytes.
  void release();

 private:
  /// What the rows of a panel add to a product.
  struct Panel {
    std::vector<float> of_columns;  ///< by the columns from the panel's first row on
    std::vector<double> of_rows;    ///< block after block of columns, by the panel's rows
  };

  bool multiplyPanel(std::size_t begin_row, const Deadline& deadline, Panel& panel);
  void add(std::size_t begin_row, const Panel& panel);

  PairValue value_ = PairValue::kRatio;
  PairRule rule_;
  PairColumns columns_{};
  std::size_t n_ = 0, stored_bytes_ = 0, capacity_ = 0;
  bool filled_ = false;
  LargeArray<std::uint16_t> blocks_;
  std::vector<Panel> panels_;
  std::vector<float> v_;
  std::vector<double> y_;
};

/// What the selectors that compare all pairs keep from call to call; a part of the workspace.
struct PairMemory {
  /// Takes all matches. O(N log N) time.
  /// @param memory_limit  MiB that the matrix may store
  void assign(const Correspondences& matches, PairValue value, const PairRule& rule, int memory_limit);

  DistinctMatches distinct;
  PairMatrix matrix;
};

/// Writes what products with the matrix have found: the scores, and why the search ended where that needs a
/// word. `result.iterations` is the number of products.
/// @param values       of the distinct matches, the largest is 1, or all are 0
/// @param max_seconds  the option, for the message
/// @return false if the time was over before the first product, so that there are no scores
bool writeScores(const DistinctMatches& distinct, const double* values, bool timed_out, double max_seconds,
                 Selection& result);

}  // namespace corrsel::core
