#include "matching/nearest.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>

#include "base/parallel.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

// Number of queries that are compared with all trains before the next ones, so that their words stay in the
// L1 cache.
constexpr std::size_t kBlock = 64;
// Integers, and therefore their sums, are exact in float up to this value.
constexpr double kMaxExact = 1 << 24;

using Rows = std::vector<std::uint32_t>;

std::size_t roundedUp(std::size_t n, std::size_t unit) { return (n + unit - 1) / unit * unit; }

/// Properties of the values of descriptors.
struct Content {
  Rows rows;        ///< those without NaN
  cv::Mat bytes;    ///< the same values as bytes if all are whole numbers from 0 to 255, otherwise empty
  int largest = 0;  ///< of bytes
  std::uint32_t squares = 0;  ///< the largest sum of the squares of a descriptor's bytes
};

Rows allRows(const cv::Mat& descriptors) {
  Rows rows(static_cast<std::size_t>(descriptors.rows));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<std::uint32_t>(i);
  return rows;
}

/// Adds the values of a row of bytes to the content.
void addBytes(const std::uint8_t* numbers, int columns, Content& content) {
  int largest = 0;
  std::uint32_t squares = 0;
  for (int c = 0; c < columns; ++c) {
    const int number = numbers[c];
    largest = std::max(largest, number);
    squares += static_cast<std::uint32_t>(number * number);
  }
  content.largest = std::max(content.largest, largest);
  content.squares = std::max(content.squares, squares);
}

Content contentOfBytes(const cv::Mat& descriptors) {
  Content content;
  content.rows = allRows(descriptors);
  content.bytes = descriptors;
  for (int r = 0; r < descriptors.rows; ++r) addBytes(descriptors.ptr(r), descriptors.cols, content);
  return content;
}

Content contentOf(const cv::Mat& descriptors) {
  if (descriptors.type() == CV_8U) return contentOfBytes(descriptors);
  Content content;
  cv::Mat bytes;
  descriptors.convertTo(bytes, CV_8U);
  bool whole = true;
  for (int r = 0; r < descriptors.rows; ++r) {
    const float* const row = descriptors.ptr<float>(r);
    const auto* const numbers = bytes.ptr<std::uint8_t>(r);
    // Without branches, so that the compiler vectorises the loops.
    int other = 0, nan = 0;
    for (int c = 0; c < descriptors.cols; ++c) {
      other |= static_cast<float>(numbers[c]) != row[c];
      nan |= row[c] != row[c];
    }
    if (!nan) content.rows.push_back(static_cast<std::uint32_t>(r));
    whole = whole && !other;
    if (whole) addBytes(numbers, descriptors.cols, content);
  }
  if (whole) content.bytes = bytes;
  return content;
}

/// Whether products of integers give the exact distances.
bool haveExactProducts(const Content& left, const Content& right, int columns) {
  const double largest = std::max(left.largest, right.largest);
  return !left.bytes.empty() && !right.bytes.empty() && columns * largest * largest <= kMaxExact;
}

/// The same descriptors as CV_32F.
cv::Mat asFloats(const cv::Mat& descriptors) {
  if (descriptors.type() == CV_32F) return descriptors;
  cv::Mat floats;
  descriptors.convertTo(floats, CV_32F);
  return floats;
}

// Metrics: they convert a row to the words and the offset of a kernel. Rows that fill up a group of trains
// consist of kPadding.

/// L2 distance of bytes.
struct WholeNumberMetric {
  using Distance = std::int32_t;
  static void run(const NearestBlock<Distance>& block) { kernels().descriptors.whole_numbers(block); }
  static float distance(Distance d) { return std::sqrt(static_cast<float>(d)); }
};

/// WholeNumberForm::kPairs.
struct PairRows : WholeNumberMetric {
  static constexpr std::uint32_t kPadding = 0;
  static std::size_t words(const cv::Mat& m) { return (static_cast<std::size_t>(m.cols) + 1) / 2; }
  static Distance convert(const cv::Mat& m, int row, int factor, std::uint32_t* words) {
    const auto* const values = m.ptr<std::uint8_t>(row);
    auto* const numbers = reinterpret_cast<std::int16_t*>(words);
    Distance squares = 0;
    for (int c = 0; c < m.cols; ++c) {
      numbers[c] = static_cast<std::int16_t>(factor * values[c]);
      squares += values[c] * values[c];
    }
    return squares;
  }
  static Distance query(const cv::Mat& m, int row, std::uint32_t* words) {
    return convert(m, row, -2, words);
  }
  static Distance train(const cv::Mat& m, int row, std::uint32_t* words) { return convert(m, row, 1, words); }
};

/// Rows that are copied unchanged and padded with zeros.
template <typename D>
struct PlainRows {
  using Distance = D;
  static constexpr std::uint32_t kPadding = 0;
  static std::size_t words(const cv::Mat& m) {
    return roundedUp(static_cast<std::size_t>(m.cols) * m.elemSize(), sizeof(std::uint32_t)) /
           sizeof(std::uint32_t);
  }
  static Distance query(const cv::Mat& m, int row, std::uint32_t* words) {
    std::memcpy(words, m.ptr(row), static_cast<std::size_t>(m.cols) * m.elemSize());
    return 0;
  }
  static Distance train(const cv::Mat& m, int row, std::uint32_t* words) { return query(m, row, words); }
};

struct BitRows : PlainRows<std::int32_t> {
  static void run(const NearestBlock<Distance>& block) { kernels().descriptors.bits(block); }
  static float distance(Distance d) { return static_cast<float>(d); }
};

/// WholeNumberForm::kCoarse.
struct ByteSquareRows : PlainRows<std::int32_t> {
  static std::size_t words(const cv::Mat& m) { return roundedUp(PlainRows::words(m), kCoarseWords); }
  static void run(const NearestBlock<Distance>& block) { kernels().descriptors.whole_numbers(block); }
  static float distance(Distance d) { return std::sqrt(static_cast<float>(d)); }
};

struct FloatRows : PlainRows<float> {
  static void run(const NearestBlock<Distance>& block) { kernels().descriptors.floats(block); }
  static float distance(Distance d) { return std::sqrt(d); }
};

/// Trains in the layout of the kernels.
template <class Metric>
struct PackedTrains {
  using Distance = typename Metric::Distance;
  static constexpr std::size_t kGroup = NearestBlock<Distance>::kTrains;

  /// @param by_lane  [group][word][train of the group] instead of [train][word]
  PackedTrains(const cv::Mat& descriptors, const Rows& rows, bool by_lane)
      : word_count(Metric::words(descriptors)),
        groups(roundedUp(rows.size(), kGroup) / kGroup),
        words(groups * kGroup * word_count, Metric::kPadding),
        offsets(groups * kGroup, kFarDistance<Distance>) {
    std::vector<std::uint32_t> row(word_count);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::uint32_t* const group = words.data() + i / kGroup * kGroup * word_count;
      std::uint32_t* const own = by_lane ? row.data() : group + i % kGroup * word_count;
      offsets[i] = Metric::train(descriptors, static_cast<int>(rows[i]), own);
      for (std::size_t w = 0; by_lane && w < word_count; ++w) group[w * kGroup + i % kGroup] = row[w];
    }
  }

  std::size_t word_count, groups;
  std::vector<std::uint32_t> words;
  std::vector<Distance> offsets;
};

/// Some queries in the layout of the kernels.
template <class Metric>
struct PackedQueries {
  using Distance = typename Metric::Distance;

  explicit PackedQueries(std::size_t word_count)
      : word_count(word_count), words(kBlock * word_count), offsets(kBlock) {}

  /// Rows [begin, end) of `rows`, at most kBlock.
  void pack(const cv::Mat& descriptors, const Rows& rows, std::size_t begin, std::size_t end) {
    std::fill(words.begin(), words.end(), 0U);
    std::fill(offsets.begin(), offsets.end(), kFarDistance<Distance>);
    for (std::size_t i = begin; i < end; ++i) {
      offsets[i - begin] =
          Metric::query(descriptors, static_cast<int>(rows[i]), words.data() + (i - begin) * word_count);
    }
  }

  std::size_t word_count;
  std::vector<std::uint32_t> words;
  std::vector<Distance> offsets;
};

/// Coarse numbers of some descriptors, in groups of 16.
struct CoarseRows {
  static constexpr std::size_t kGroup = CoarseNumbers::kQueries;
  static_assert(kGroup == NearestBlock<std::int32_t>::kTrains, "one kernel serves queries and trains");

  /// Descriptors [begin, end) of `rows`.
  void project(const cv::Mat& bytes, const Rows& rows, std::size_t begin, std::size_t end,
               const Projection& projection, bool as_queries) {
    const std::size_t groups = roundedUp(end - begin, kGroup) / kGroup;
    words.resize(groups * kGroup * projection.words);
    offsets.resize(groups * kGroup);
    errors.resize(groups * kGroup);
    for (std::size_t group = 0; group < groups; ++group) {
      const std::size_t first = begin + group * kGroup;
      Sixteen group_rows{};
      for (std::size_t i = first; i < std::min(end, first + kGroup); ++i) {
        group_rows[i - first] = bytes.ptr<std::uint8_t>(static_cast<int>(rows[i]));
      }
      kernels().descriptors.project(group_rows.data(), static_cast<std::size_t>(bytes.cols), projection,
                                    as_queries, words.data() + group * kGroup * projection.words,
                                    offsets.data() + group * kGroup, errors.data() + group * kGroup);
    }
  }

  /// Pointers to descriptors; null where there are fewer.
  using Sixteen = std::array<const std::uint8_t*, kGroup>;

  std::vector<std::uint32_t> words;
  std::vector<std::int32_t> offsets;
  std::vector<std::uint16_t> errors;
};

/// A projection that fits some trains, and their coarse numbers.
class CoarseTrains {
 public:
  /// Whether the projection of such descriptors is short enough for 8 bits.
  /// @param squares  the largest sum of the squares of a descriptor
  static bool possible(int columns, std::uint32_t squares) {
    return static_cast<std::size_t>(columns) <= Projection::kMaxSize &&
           stepFor(sizeFor(columns), squares) <= Projection::kMaxStep;
  }

  /// @param ratio  of NeighbourSearch
  CoarseTrains(const cv::Mat& trains, const Rows& rows, std::uint32_t squares, double ratio) {
    projection.size = sizeFor(trains.cols);
    projection.words = roundedUp(projection.size * (ratio < 1 ? kFew : kMany) / 16, 8) / 4;
    projection.step = std::max(2, stepFor(projection.size, squares));
    chooseRows(trains, rows);
    projection.rows = rows_.data();
    projection.means = means_.data();
    numbers.project(trains, rows, 0, rows.size(), projection, false);
    std::uint16_t largest = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) largest = std::max(largest, numbers.errors[i]);
    error = std::sqrt(static_cast<double>(largest)) / (2.0 * projection.step);
  }
  CoarseTrains(const CoarseTrains&) = delete;
  CoarseTrains& operator=(const CoarseTrains&) = delete;

  Projection projection{};
  CoarseRows numbers;
  double error = 0;  ///< as in CoarseNumbers

 private:
  // Rows of the matrix that are used, in sixteenths of all. More rows exclude more trains but take longer.
  // The test of ratios excludes more by itself.
  static constexpr std::size_t kMany = 8, kFew = 6;
  // Trains from which the variances are estimated.
  static constexpr std::size_t kSamples = 256;

  static std::size_t sizeFor(int columns) {
    std::size_t size = 8;
    while (size < static_cast<std::size_t>(columns)) size *= 2;
    return size;
  }

  /// |q'|^2 of a query without the means is at most 2^15.
  static int stepFor(std::size_t size, std::uint32_t squares) {
    return static_cast<int>(std::ceil(std::sqrt(static_cast<double>(size) * squares / (4.0 * 0x7fff))));
  }

  /// Sets the rows with the largest variances, and the means.
  void chooseRows(const cv::Mat& trains, const Rows& given) {
    const std::size_t size = projection.size, samples = std::min(given.size(), kSamples);
    std::vector<double> sums(size), squares(size);
    std::vector<std::int16_t> products(size * CoarseRows::kGroup);
    for (std::size_t first = 0; first < samples; first += CoarseRows::kGroup) {
      CoarseRows::Sixteen rows{};
      for (std::size_t i = first; i < std::min(samples, first + CoarseRows::kGroup); ++i) {
        rows[i - first] = trains.ptr<std::uint8_t>(static_cast<int>(given[i * given.size() / samples]));
      }
      kernels().descriptors.transform(rows.data(), static_cast<std::size_t>(trains.cols), size,
                                      products.data());
      for (std::size_t row = 0; row < size; ++row) {
        for (std::size_t i = 0; i < CoarseRows::kGroup; ++i) {
          const double product = products[row * CoarseRows::kGroup + i];
          sums[row] += product;
          squares[row] += product * product;
        }
      }
    }
    const auto n = static_cast<double>(samples);
    std::vector<std::pair<double, std::uint16_t>> order;
    for (std::size_t row = 0; row < size; ++row) {
      order.emplace_back(sums[row] / n * sums[row] - squares[row], static_cast<std::uint16_t>(row));
    }
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < 4 * projection.words; ++i) {
      rows_.push_back(order[i].second);
      means_.push_back(static_cast<std::int16_t>(std::lround(sums[order[i].second] / n)));
    }
  }

  std::vector<std::uint16_t> rows_;
  std::vector<std::int16_t> means_;
};

/// The smallest distance of every train.
template <typename Distance>
struct TrainMinima {
  explicit TrainMinima(std::size_t size)
      : best(size, kFarDistance<Distance>), query(size, Neighbours::kNone) {}

  /// Smaller distances win; among equal ones the lower query.
  void merge(const TrainMinima& other) {
    for (std::size_t i = 0; i < best.size(); ++i) {
      if (other.best[i] < best[i] || (other.best[i] == best[i] && other.query[i] < query[i])) {
        best[i] = other.best[i];
        query[i] = other.query[i];
      }
    }
  }

  std::vector<Distance> best;
  std::vector<std::uint32_t> query;
};

/// Two nearest trains of some queries, with trains numbered in the packed order.
template <typename Distance>
struct Nearest {
  explicit Nearest(std::size_t size)
      : best(size, kFarDistance<Distance>),
        second(size, kFarDistance<Distance>),
        best_train(size, Neighbours::kNone),
        second_train(size, Neighbours::kNone) {}
  std::vector<Distance> best, second;
  std::vector<std::uint32_t> best_train, second_train;
};

/// A block of `count` queries from `begin` on, and where their neighbours are written.
template <class Metric>
NearestBlock<typename Metric::Distance> blockOf(const PackedQueries<Metric>& queries,
                                                const PackedTrains<Metric>& trains, std::size_t begin,
                                                std::size_t count,
                                                Nearest<typename Metric::Distance>& nearest) {
  using Block = NearestBlock<typename Metric::Distance>;
  Block block{};
  block.words = trains.word_count;
  block.queries = queries.words.data();
  block.query_offset = queries.offsets.data();
  block.query_count = roundedUp(count, Block::kQueries);
  block.trains = trains.words.data();
  block.train_offset = trains.offsets.data();
  block.groups = trains.groups;
  block.best = nearest.best.data() + begin;
  block.second = nearest.second.data() + begin;
  block.best_train = nearest.best_train.data() + begin;
  block.second_train = nearest.second_train.data() + begin;
  block.first_query = static_cast<std::uint32_t>(begin);
  return block;
}

/// Compares the queries `rows` with all trains.
/// @param coarse   of the trains, or null
/// @param nearest  one entry per row, padded to whole groups
/// @param minima   of the trains, or null
/// @param near     trains that cannot be second, or null; per row of `rows`, padded like `nearest`
/// @param ratio    as in CoarseNumbers
template <class Metric>
void compare(const cv::Mat& queries, const Rows& rows, const PackedTrains<Metric>& trains,
             const CoarseTrains* coarse, const NearFeatures* near, double ratio, std::size_t threads,
             Nearest<typename Metric::Distance>& nearest, TrainMinima<typename Metric::Distance>* minima) {
  using Distance = typename Metric::Distance;
  const std::size_t blocks = roundedUp(rows.size(), kBlock) / kBlock;
  std::atomic<std::size_t> next{0};
  std::mutex merging;
  onThreads(std::min(threads, std::max<std::size_t>(blocks, 1)), [&] {
    PackedQueries<Metric> packed(trains.word_count);
    CoarseRows coarse_queries;
    const std::size_t coarse_trains = coarse ? roundedUp(trains.groups, 2) * trains.kGroup : 0;
    std::vector<std::int16_t> coarse_sums(coarse_trains * CoarseNumbers::kQueries),
        train_limits(coarse_trains);
    TrainMinima<Distance> own(minima ? trains.offsets.size() : 0);
    for (std::size_t begin; (begin = kBlock * next++) < rows.size();) {
      const std::size_t end = std::min(begin + kBlock, rows.size());
      packed.pack(queries, rows, begin, end);
      NearestBlock<Distance> block = blockOf(packed, trains, begin, end - begin, nearest);
      if (minima) {
        block.train_best = own.best.data();
        block.train_best_query = own.query.data();
      }
      CoarseNumbers coarse_block{};
      if (coarse != nullptr) {
        coarse_queries.project(queries, rows, begin, end, coarse->projection, true);
        coarse_block = {&coarse->projection,
                        coarse_queries.words.data(),
                        coarse_queries.offsets.data(),
                        coarse_queries.errors.data(),
                        coarse->numbers.words.data(),
                        coarse->numbers.offsets.data(),
                        coarse->error,
                        coarse_sums.data(),
                        train_limits.data(),
                        ratio};
        block.coarse = &coarse_block;
      }
      NearFeatures block_near{};
      if (near != nullptr) {
        block_near = *near;
        block_near.centre_x += begin;
        block_near.centre_y += begin;
        block.near = &block_near;
      }
      Metric::run(block);
    }
    if (!minima) return;
    const std::lock_guard<std::mutex> lock(merging);
    minima->merge(own);
  });
}

/// Repeats the search for the second neighbour of the queries whose second is too near to the first.
template <class Metric>
void findFarSeconds(const cv::Mat& queries, const Rows& query_rows, const PackedTrains<Metric>& trains,
                    const CoarseTrains* coarse, const Rows& train_rows, const NeighbourSearch& search,
                    std::size_t threads, Nearest<typename Metric::Distance>& nearest) {
  using Distance = typename Metric::Distance;
  std::vector<double> x, y, centre_x, centre_y;
  for (const std::uint32_t row : train_rows) {
    x.push_back((*search.train_keypoints)[row].pt.x);
    y.push_back((*search.train_keypoints)[row].pt.y);
  }
  Rows rows, numbers;
  for (std::size_t i = 0; i < query_rows.size(); ++i) {
    const std::uint32_t first = nearest.best_train[i], second = nearest.second_train[i];
    if (second == Neighbours::kNone) continue;
    const double dx = x[second] - x[first], dy = y[second] - y[first];
    if (!(dx * dx + dy * dy < search.second_radius * search.second_radius)) continue;
    rows.push_back(query_rows[i]);
    numbers.push_back(static_cast<std::uint32_t>(i));
    centre_x.push_back(x[first]);
    centre_y.push_back(y[first]);
  }
  Nearest<Distance> far(roundedUp(rows.size(), NearestBlock<Distance>::kQueries));
  // No distance is smaller, so all other trains can become second.
  std::fill(far.best.begin(), far.best.end(), Distance{-1});
  const NearFeatures near{x.data(), y.data(), centre_x.data(), centre_y.data(), search.second_radius};
  compare<Metric>(queries, rows, trains, coarse, &near, 1, threads, far, nullptr);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    nearest.second[numbers[k]] = far.second[k];
    nearest.second_train[numbers[k]] = far.second_train[k];
  }
}

/// A result of findNeighbours() without any neighbour.
Neighbours noNeighbours(std::size_t queries, std::size_t trains, bool nearest_query) {
  Neighbours result;
  result.train.assign(queries, Neighbours::kNone);
  result.distance.assign(queries, std::numeric_limits<float>::quiet_NaN());
  result.second_distance = result.distance;
  if (nearest_query) result.query.assign(trains, Neighbours::kNone);
  return result;
}

template <class Metric>
Neighbours find(const cv::Mat& queries, const Rows& query_rows, const cv::Mat& trains, const Rows& train_rows,
                const NeighbourSearch& search, const CoarseTrains* coarse = nullptr) {
  using Distance = typename Metric::Distance;
  const PackedTrains<Metric> packed(trains, train_rows, coarse == nullptr);
  const auto threads = static_cast<std::size_t>(std::max(search.threads, 1));
  Nearest<Distance> nearest(roundedUp(query_rows.size(), NearestBlock<Distance>::kQueries));
  TrainMinima<Distance> minima(search.nearest_query ? packed.offsets.size() : 0);
  compare<Metric>(queries, query_rows, packed, coarse, nullptr, search.ratio, threads, nearest,
                  search.nearest_query ? &minima : nullptr);
  if (search.second_radius > 0) {
    findFarSeconds<Metric>(queries, query_rows, packed, coarse, train_rows, search, threads, nearest);
  }
  Neighbours result = noNeighbours(static_cast<std::size_t>(queries.rows),
                                   static_cast<std::size_t>(trains.rows), search.nearest_query);
  for (std::size_t i = 0; i < query_rows.size(); ++i) {
    const std::uint32_t row = query_rows[i], train = nearest.best_train[i];
    if (train == Neighbours::kNone) continue;
    const float distance = Metric::distance(nearest.best[i]);
    // Without a second neighbour, whose distance is far, nothing speaks against the first one.
    if (search.ratio < 1 && distance >= search.ratio * Metric::distance(nearest.second[i])) continue;
    result.train[row] = train_rows[train];
    result.distance[row] = distance;
    if (search.ratio < 1 || nearest.second_train[i] == Neighbours::kNone) continue;
    result.second_distance[row] = Metric::distance(nearest.second[i]);
  }
  if (search.nearest_query) {
    for (std::size_t i = 0; i < train_rows.size(); ++i) {
      if (minima.query[i] != Neighbours::kNone) result.query[train_rows[i]] = query_rows[minima.query[i]];
    }
  }
  return result;
}

/// The neighbours of the queries of groups, each of which has its own trains.
template <class Metric>
class AmongCandidates {
 public:
  using Distance = typename Metric::Distance;

  AmongCandidates(const cv::Mat& queries, const cv::Mat& trains, const Rows& background,
                  const NeighbourSearch& search)
      : queries_(queries),
        trains_(trains),
        search_(search),
        background_(trains, background, true),
        minima_(search.nearest_query ? static_cast<std::size_t>(trains.rows) : 0),
        result_(
            noNeighbours(static_cast<std::size_t>(queries.rows), minima_.best.size(), search.nearest_query)) {
    for (const std::uint32_t row : background) {
      background_x_.push_back((*search.train_keypoints)[row].pt.x);
      background_y_.push_back((*search.train_keypoints)[row].pt.y);
    }
  }

  Neighbours run(const std::vector<CandidateGroup>& groups) {
    forEachBlock(groups.size(), 1, search_.threads,
                 [&](std::size_t group, std::size_t) { find(groups[group]); });
    result_.query = minima_.query;
    return result_;
  }

 private:
  void find(const CandidateGroup& group) {
    if (group.trains.empty()) return;
    const PackedTrains<Metric> packed(trains_, group.trains, true);
    Nearest<Distance> nearest(roundedUp(group.queries.size(), NearestBlock<Distance>::kQueries));
    TrainMinima<Distance> minima(search_.nearest_query ? packed.offsets.size() : 0);
    compare<Metric>(queries_, group.queries, packed, nullptr, nullptr, 1, 1, nearest,
                    search_.nearest_query ? &minima : nullptr);
    if (search_.second_radius > 0) {
      findFarSeconds<Metric>(queries_, group.queries, packed, nullptr, group.trains, search_, 1, nearest);
    }
    compareWithBackground(group, nearest);
    for (std::size_t i = 0; i < group.queries.size(); ++i) {
      const std::uint32_t row = group.queries[i], train = nearest.best_train[i];
      if (train == Neighbours::kNone) continue;
      result_.train[row] = group.trains[train];
      result_.distance[row] = Metric::distance(nearest.best[i]);
      if (nearest.second[i] < kFarDistance<Distance>)
        result_.second_distance[row] = Metric::distance(nearest.second[i]);
    }
    if (search_.nearest_query) keepMinima(group, minima);
  }

  /// Replaces second neighbours by nearer ones of the background.
  void compareWithBackground(const CandidateGroup& group, Nearest<Distance>& nearest) {
    std::vector<double> centre_x(nearest.best.size()), centre_y(centre_x);
    for (std::size_t i = 0; i < group.queries.size(); ++i) {
      if (nearest.best_train[i] == Neighbours::kNone) continue;
      const cv::Point2f place = (*search_.train_keypoints)[group.trains[nearest.best_train[i]]].pt;
      centre_x[i] = place.x;
      centre_y[i] = place.y;
    }
    constexpr double kSamePlace = 1e-3;  // px
    const NearFeatures near{background_x_.data(), background_y_.data(), centre_x.data(), centre_y.data(),
                            std::max(kSamePlace, search_.second_radius)};
    Nearest<Distance> others(nearest.best.size());
    // No distance is smaller, so all trains can become second.
    std::fill(others.best.begin(), others.best.end(), Distance{-1});
    others.second = nearest.second;
    compare<Metric>(queries_, group.queries, background_, nullptr, &near, 1, 1, others, nullptr);
    nearest.second = others.second;
  }

  /// Of equally near queries, the one with the lowest row remains.
  void keepMinima(const CandidateGroup& group, const TrainMinima<Distance>& minima) {
    const std::lock_guard<std::mutex> lock(merging_);
    for (std::size_t i = 0; i < group.trains.size(); ++i) {
      if (minima.query[i] == Neighbours::kNone) continue;
      const std::uint32_t train = group.trains[i], query = group.queries[minima.query[i]];
      if (minima.best[i] > minima_.best[train]) continue;
      if (minima.best[i] == minima_.best[train] && query > minima_.query[train]) continue;
      minima_.best[train] = minima.best[i];
      minima_.query[train] = query;
    }
  }

  const cv::Mat &queries_, &trains_;
  const NeighbourSearch& search_;
  PackedTrains<Metric> background_;
  std::vector<double> background_x_, background_y_;
  std::mutex merging_;
  TrainMinima<Distance> minima_;
  Neighbours result_;
};

}  // namespace

Neighbours findNeighbours(const cv::Mat& queries, const cv::Mat& trains, const NeighbourSearch& search) {
  if (queries.type() == CV_8U && search.bytes == NeighbourSearch::Bytes::kBits)
    return find<BitRows>(queries, allRows(queries), trains, allRows(trains), search);
  Content left, right;
  forEachBlock(2, 1, search.threads, [&](std::size_t side, std::size_t) {
    (side == 0 ? left : right) = contentOf(side == 0 ? queries : trains);
  });
  if (!haveExactProducts(left, right, queries.cols)) {
    return find<FloatRows>(asFloats(queries), left.rows, asFloats(trains), right.rows, search);
  }
  const WholeNumberForm form = kernels().descriptors.whole_number_form;
  const std::uint32_t squares = std::max(left.squares, right.squares);
  if (form == WholeNumberForm::kPairs || !CoarseTrains::possible(queries.cols, squares)) {
    return find<PairRows>(left.bytes, left.rows, right.bytes, right.rows, search);
  }
  const CoarseTrains coarse(right.bytes, right.rows, squares, search.ratio);
  return find<ByteSquareRows>(left.bytes, left.rows, right.bytes, right.rows, search, &coarse);
}

Neighbours findNeighboursAmong(const cv::Mat& queries, const cv::Mat& trains,
                               const std::vector<CandidateGroup>& groups, const Rows& background,
                               const NeighbourSearch& search) {
  if (queries.type() == CV_8U)
    return AmongCandidates<BitRows>(queries, trains, background, search).run(groups);
  const Content left = contentOf(queries), right = contentOf(trains);
  if (haveExactProducts(left, right, queries.cols))
    return AmongCandidates<PairRows>(left.bytes, right.bytes, background, search).run(groups);
  return AmongCandidates<FloatRows>(queries, trains, background, search).run(groups);
}

}  // namespace corrsel::core
