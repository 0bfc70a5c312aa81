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

/// A projection of descriptors of whole numbers from 0 to 255.
///
/// The columns x are filled up with zeros to n, a power of two, and multiplied with some rows of the Hadamard
/// matrix of this size; means m are subtracted, and the results y are cut to [-126 a, 126 a]. All of this
/// lets no distance grow by more than the factor of the matrix: |y_q - y_t|^2 <= n |q - t|^2. Few rows with a
/// large variance hold most of a distance.
struct Projection {
  static constexpr std::size_t kMaxSize = 128;  ///< of n: products fit into 16 bits
  static constexpr std::int32_t kMaxStep = 26;  ///< of a: squared roundings fit into 16 bits

  std::size_t size;           ///< n
  std::size_t words;          ///< a quarter of the number of rows; even
  const std::uint16_t* rows;  ///< of the matrix, [4 words]
  const std::int16_t* means;  ///< [4 words]
  std::int32_t step;          ///< a, at least 2
};

/// Projections in 8 bits, which show quickly that most trains are too far: q' = y_q / 2a and t' = y_t / a,
/// rounded. The distance of q' and t' / 2 is at most that of y_q and y_t, divided by 2a, plus the errors.
struct CoarseNumbers {
  static constexpr std::size_t kQueries = 16;  ///< queries per group of `queries`

  const Projection* projection;
  const std::uint32_t* queries;      ///< q' + 64, [group][word][query of the group]
  const std::int32_t* query_offset;  ///< |q'|^2
  const std::uint16_t* query_error;  ///< |y_q - 2a q'|^2
  const std::uint32_t* trains;       ///< t', [group][word][train of the group]
  const std::int32_t* train_offset;  ///< |t'|^2 / 4, rounded down, + 64 sum(t')
  double train_error;                ///< largest |y_t - a t'| / 2a
  std::int16_t* sums;                ///< scratch, [kQueries][trains, rounded up to two groups]
  std::int16_t* train_limit;         ///< scratch, [trains, rounded up to two groups]
  /// Where below 1, any two distances that fail the test of ratios will do for a query whose nearest fail it:
  /// the root of the first is at least `ratio` times that of the second one, in float and double.
  double ratio;
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
  const CoarseNumbers* coarse;  ///< of WholeNumberForm::kCoarse; otherwise null
};

/// How whole numbers from 0 to 255 are passed to DescriptorKernels::whole_numbers().
enum class WholeNumberForm : std::uint8_t {
  /// Two per word, as 16-bit numbers; a query's are multiplied by -2. Offsets are the sums of squares, and a
  /// term is the sum of the products: |q|^2 + |t|^2 - 2 q t.
  kPairs,
  /// Where NearestBlock::coarse is set: four per word, as unsigned bytes, and no offsets but those of rows
  /// that fill up a group; a term is the sum of the squared differences. Trains are [train][word], and the
  /// number of words is a multiple of kCoarseWords. Otherwise kPairs.
  kCoarse,
};

inline constexpr std::size_t kCoarseWords = 8;

/// Exact nearest and second nearest descriptors by comparing all with all.
struct DescriptorKernels {
  /// Squared L2 distance of whole numbers from 0 to 255. @pre no distance above 2^24
  void (*whole_numbers)(const NearestBlock<std::int32_t>& block);

  WholeNumberForm whole_number_form;  ///< what whole_numbers() reads

  /// Products of NearestBlock::kTrains descriptors with all rows of the Hadamard matrix of a size; null
  /// unless whole_number_form is kCoarse.
  /// @param descriptors  [kTrains], of `columns` bytes each; null = zeros
  /// @param products     [size][kTrains]
  void (*transform)(const std::uint8_t* const* descriptors, std::size_t columns, std::size_t size,
                    std::int16_t* products);

  /// Coarse numbers of as many descriptors; null unless whole_number_form is kCoarse.
  /// @param as_queries  q' + 64 and |q'|^2 instead of what trains have
  /// @param words, offsets, errors  [word][kTrains], [kTrains] and [kTrains], see CoarseNumbers; the errors
  /// of trains are |y_t - a t'|^2
  void (*project)(const std::uint8_t* const* descriptors, std::size_t columns, const Projection& projection,
                  bool as_queries, std::uint32_t* words, std::int32_t* offsets, std::uint16_t* errors);

  /// Hamming distance. @pre no distance above 2^24
  void (*bits)(const NearestBlock<std::int32_t>& block);

  /// Squared L2 distance of floats, one per word, added up in the order of the words. Distances that are
  /// infinite or NaN never count.
  void (*floats)(const NearestBlock<float>& block);
};

}  // namespace corrsel::core
