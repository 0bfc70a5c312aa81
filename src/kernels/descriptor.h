#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Larger than every distance between descriptors; twice its value still fits the type.
template <typename Distance>
inline constexpr Distance kFarDistance = Distance{1} << 29;
template <>
inline constexpr float kFarDistance<float> = __builtin_huge_valf();

/// Excludes descriptors from being the second neighbour of a query: those of features closer than `radius` to
/// the centre of the query.
struct NearFeatures {
  const double *x, *y;                ///< px, per train
  const double *centre_x, *centre_y;  ///< px, per query
  double radius;                      ///< px
};

/// Descriptors with fewer bits per number, four numbers per word. They show quickly that most trains are too
/// far. Queries hold q / 2 and trains t / 4, rounded down, which represent q' = 2 (q / 2) + 1/2 and t' = 4 (t
/// / 4) + 1. The distance of q' and t' differs from that of q and t by at most |q - q'| + |t - t'|.
struct CoarseNumbers {
  static constexpr std::size_t kWords = 4;  ///< the number of words is a multiple of it

  /// Largest |q|^2 and |t'|^2. Within this bound (q / 2) (t / 4) - |t'|^2 / 16, which is from -|t'|^2 / 16 to
  /// |q|^2 / 16, fits into 16 bits.
  static constexpr std::int32_t kLargestSquares = 16 * 0x7fff;

  std::size_t words;                 ///< per descriptor
  const std::uint32_t* queries;      ///< as in NearestBlock
  const std::int32_t* query_offset;  ///< sum(4 (q / 2)^2 - 2 (q / 2) - 3/4), rounded up
  const std::uint32_t* trains;
  const std::int32_t* train_offset;  ///< sum(16 (t / 4)^2 + 4 (t / 4) + 1)
  double error;                      ///< largest |q - q'| + largest |t - t'|
  std::int32_t* limit;               ///< scratch, per query
};

/// Some queries and all trains. A descriptor is a row of 32-bit words; the distance of a query and a train
/// is the sum of their offsets and of a term per word, see DescriptorKernels. Rows that fill up a group have
/// the offset kFarDistance and words of zeros.
template <typename Distance>
struct NearestBlock {
  static constexpr std::size_t kTrains = 16;  ///< trains per group
  static constexpr std::size_t kQueries = 8;  ///< the number of queries is a multiple of it

  std::size_t words;             ///< per descriptor
  const std::uint32_t* queries;  ///< [query][word]
  const Distance* query_offset;
  std::size_t query_count;
  const std::uint32_t* trains;  ///< [group][word][train of the group]
  const Distance* train_offset;
  std::size_t groups;

  /// Per query: the smallest distance and the second smallest (equal where two trains are equally near),
  /// and their trains; of equal distances the one with the lowest number. The values that are present when
  /// the kernel is called take part.
  Distance *best, *second;
  std::uint32_t *best_train, *second_train;

  /// Per train, or null: the smallest distance and its query, the lowest of equals. Queries count from
  /// first_query. The values that are present when the kernel is called take part and win ties.
  Distance* train_best;
  std::uint32_t* train_best_query;
  std::uint32_t first_query;

  const NearFeatures* near;     ///< or null
  const CoarseNumbers* coarse;  ///< whole numbers only; or null. With it trains are [train][word]
};

/// How whole numbers from 0 to 255 are passed to DescriptorKernels::whole_numbers().
enum class WholeNumberForm : std::uint8_t {
  /// Two per word, as 16-bit numbers; a query's are multiplied by -2. Offsets are the sums of squares, and a
  /// term is the sum of the products: |q|^2 + |t|^2 - 2 q t.
  kPairs,
  /// The same, and NearestBlock::coarse may be set.
  kPairsAndCoarse,
  /// Four per word: q as unsigned bytes, t' = t - 128 as signed bytes. The offset of a query is |q|^2 - 256
  /// sum(q), that of a train |t|^2, and a term is -2 q t'. Rows that fill up a group of trains hold t = 0.
  /// @pre at most kMostByteWords words
  kBytes,
};

/// Up to this number of words, sums of products of bytes and offsets fit into 32 bits.
inline constexpr std::size_t kMostByteWords = 2048;

/// Exact nearest and second nearest descriptors by comparing all with all.
struct DescriptorKernels {
  /// Squared L2 distance of whole numbers from 0 to 255. @pre no distance above 2^24
  void (*whole_numbers)(const NearestBlock<std::int32_t>& block);

  WholeNumberForm whole_number_form;  ///< what whole_numbers() reads

  /// Hamming distance. @pre no distance above 2^24
  void (*bits)(const NearestBlock<std::int32_t>& block);

  /// Squared L2 distance of floats, one per word, added up in the order of the words. Distances that are
  /// infinite or NaN never count.
  void (*floats)(const NearestBlock<float>& block);
};

}  // namespace corrsel::core
