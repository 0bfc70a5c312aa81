#pragma once

// Nearest and second nearest descriptors. Every lane is a train and every word of a query is broadcast to all
// lanes, so that nothing is added across lanes.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

typedef std::uint32_t WordV __attribute__((vector_size(kWidth * 4)));

inline WordV load(const std::uint32_t* p) {
  WordV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void store(std::uint32_t* p, WordV v) { __builtin_memcpy(p, &v, sizeof v); }

inline WordV splat(std::uint32_t word) { return word - WordV{}; }

/// Squared differences of whole numbers, expanded: adds the dot product of two pairs of 16-bit numbers.
struct WholeNumbers {
  static constexpr std::size_t kFlushedWords = static_cast<std::size_t>(-1);
  typedef std::int32_t Distance;
  typedef IntV DistanceV;

  struct Sum {
    IntV value;
    void add(WordV a, WordV b) { value = addProducts(value, (IntV)a, (IntV)b); }
    void flush() {}
  };
};

/// Bits that differ. Without an instruction that counts the bits of a lane, those of bytes are added up.
struct Bits {
  static constexpr std::size_t kFlushedWords = 31;  ///< a byte holds the bits of so many bytes
  typedef std::int32_t Distance;
  typedef IntV DistanceV;

#if defined(__AVX512VPOPCNTDQ__)
  struct Sum {
    IntV value;
    void add(WordV a, WordV b) { value += (IntV)_mm512_popcnt_epi32((__m512i)(a ^ b)); }
    void flush() {}
  };
#else
  typedef std::uint8_t ByteV __attribute__((vector_size(kWidth * 4)));

  /// Bits of every byte.
  static ByteV bitsOfBytes(WordV v) {
#if defined(__AVX512F__)
    const __m512i table = _mm512_set4_epi32(0x04030302, 0x03020201, 0x03020201, 0x02010100);
    const __m512i low = (__m512i)(v & 0x0f0f0f0fU), high = (__m512i)((v >> 4) & 0x0f0f0f0fU);
    return (ByteV)_mm512_shuffle_epi8(table, low) + (ByteV)_mm512_shuffle_epi8(table, high);
#elif defined(__AVX2__)
    const __m256i table =
        _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
    const __m256i low = (__m256i)(v & 0x0f0f0f0fU), high = (__m256i)((v >> 4) & 0x0f0f0f0fU);
    return (ByteV)_mm256_shuffle_epi8(table, low) + (ByteV)_mm256_shuffle_epi8(table, high);
#elif defined(__ARM_NEON) && !defined(__SSE2__)
    return (ByteV)vcntq_u8((uint8x16_t)v);
#else
    v = v - ((v >> 1) & 0x55555555U);
    v = (v & 0x33333333U) + ((v >> 2) & 0x33333333U);
    return (ByteV)((v + (v >> 4)) & 0x0f0f0f0fU);
#endif
  }

  /// Sums of the four bytes of every lane.
  static IntV sumsOfBytes(ByteV v) {
#if defined(__AVX512F__)
    const __m512i pairs = _mm512_maddubs_epi16((__m512i)v, _mm512_set1_epi8(1));
    return (IntV)_mm512_madd_epi16(pairs, _mm512_set1_epi16(1));
#elif defined(__AVX2__)
    const __m256i pairs = _mm256_maddubs_epi16((__m256i)v, _mm256_set1_epi8(1));
    return (IntV)_mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
#else
    const WordV pairs = ((WordV)v & 0x00ff00ffU) + (((WordV)v >> 8) & 0x00ff00ffU);
    return (IntV)((pairs & 0xffffU) + (pairs >> 16));
#endif
  }

  struct Sum {
    IntV value;
    ByteV bytes = {};
    void add(WordV a, WordV b) { bytes += bitsOfBytes(a ^ b); }
    void flush() {
      value += sumsOfBytes(bytes);
      bytes = ByteV{};
    }
  };
#endif
};

struct Floats {
  static constexpr std::size_t kFlushedWords = static_cast<std::size_t>(-1);
  typedef float Distance;
  typedef FloatV DistanceV;

  struct Sum {
    FloatV value;
    void add(WordV a, WordV b) {
      const FloatV difference = (FloatV)a - (FloatV)b;
      value += difference * difference;
    }
    void flush() {}
  };
};

// Queries that are compared at a time: as many as leave their sums in registers.
#if defined(__AVX512F__)
constexpr std::size_t kQueriesAtATime = 8;
#elif defined(__AVX2__)
constexpr std::size_t kQueriesAtATime = 4;
#else
constexpr std::size_t kQueriesAtATime = 2;
#endif

inline bool isNear(const NearFeatures& near, std::size_t query, std::size_t train) {
  const double dx = near.x[train] - near.centre_x[query], dy = near.y[train] - near.centre_y[query];
  return dx * dx + dy * dy < near.radius * near.radius;
}

/// Updates the two nearest trains of a query with another train. Trains are visited in their order.
template <class Distance>
inline void compete(const NearestBlock<Distance>& block, std::size_t query, std::size_t train,
                    Distance distance) {
  if (!(distance < block.second[query])) return;
  if (block.near != nullptr && isNear(*block.near, query, train)) return;
  if (distance < block.best[query]) {
    block.second[query] = block.best[query];
    block.second_train[query] = block.best_train[query];
    block.best[query] = distance;
    block.best_train[query] = static_cast<std::uint32_t>(train);
  } else {
    block.second[query] = distance;
    block.second_train[query] = static_cast<std::uint32_t>(train);
  }
}

/// Distances of kQueries queries and a group of trains, from the offsets on.
template <class Metric, std::size_t kQueries>
inline void addDistances(const NearestBlock<typename Metric::Distance>& block, const std::uint32_t* queries,
                         const std::uint32_t* trains,
                         typename Metric::DistanceV (&distances)[kQueries][kParts]) {
  typename Metric::Sum sums[kQueries][kParts];
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) sums[q][part].value = distances[q][part];
  }
  for (std::size_t word = 0; word < block.words;) {
    const std::size_t rest = block.words - word;
    const std::size_t end = word + (rest < Metric::kFlushedWords ? rest : Metric::kFlushedWords);
    for (; word < end; ++word) {
      WordV train[kParts];
#pragma GCC unroll 4
      for (std::size_t part = 0; part < kParts; ++part)
        train[part] = load(trains + word * kLanes + part * kWidth);
#pragma GCC unroll 8
      for (std::size_t q = 0; q < kQueries; ++q) {
        const WordV value = splat(queries[q * block.words + word]);
#pragma GCC unroll 4
        for (std::size_t part = 0; part < kParts; ++part) sums[q][part].add(value, train[part]);
      }
    }
#pragma GCC unroll 8
    for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 4
      for (std::size_t part = 0; part < kParts; ++part) sums[q][part].flush();
    }
  }
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) distances[q][part] = sums[q][part].value;
  }
}

/// Updates the nearest trains of queries with a group of trains, and the nearest queries of these trains.
template <class Distance, class DistanceV, std::size_t kQueries>
inline void takeDistances(const NearestBlock<Distance>& block, std::size_t query, std::size_t first_train,
                          const DistanceV (&distances)[kQueries][kParts]) {
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
    const DistanceV second = splat(block.second[query + q]);
    IntV closer = distances[q][0] < second;
#pragma GCC unroll 4
    for (std::size_t part = 1; part < kParts; ++part) closer |= distances[q][part] < second;
    if (anyTrue(closer)) {
      Distance lanes[kLanes];
      for (std::size_t part = 0; part < kParts; ++part) store(lanes + part * kWidth, distances[q][part]);
      for (std::size_t k = 0; k < kLanes; ++k) compete(block, query + q, first_train + k, lanes[k]);
    }
  }
  if (block.train_best == nullptr) return;
#pragma GCC unroll 4
  for (std::size_t part = 0; part < kParts; ++part) {
    Distance* const best = block.train_best + first_train + part * kWidth;
    std::uint32_t* const best_query = block.train_best_query + first_train + part * kWidth;
    DistanceV nearest = load(best);
    WordV index = load(best_query);
#pragma GCC unroll 8
    for (std::size_t q = 0; q < kQueries; ++q) {
      const IntV closer = distances[q][part] < nearest;
      nearest = closer ? distances[q][part] : nearest;
      index = closer ? splat(block.first_query + static_cast<std::uint32_t>(query + q)) : index;
    }
    store(best, nearest);
    store(best_query, index);
  }
}

/// Compares kQueries queries with a group of trains.
template <class Metric, std::size_t kQueries>
inline void compareGroup(const NearestBlock<typename Metric::Distance>& block, std::size_t query,
                         std::size_t first_train) {
  typename Metric::DistanceV distances[kQueries][kParts];
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) {
      distances[q][part] =
          load(block.train_offset + first_train + part * kWidth) + splat(block.query_offset[query + q]);
    }
  }
  addDistances<Metric>(block, block.queries + query * block.words, block.trains + first_train * block.words,
                       distances);
  takeDistances(block, query, first_train, distances);
}

#if defined(__AVX2__)
/// Bit k is set where lane k of a mask is.
inline unsigned bitsOf(IntV mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask((__m512i)mask);
#else
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
#endif
}
#endif

#if defined(__AVX512VNNI__)
constexpr WholeNumberForm kWholeNumberForm = WholeNumberForm::kBytes;

// Sums of so many queries and groups of trains are in registers, so that every load serves four products.
constexpr std::size_t kByteQueries = 4, kByteGroups = 4;

/// Smallest sum, less one, from which follows that a train may be closer to a query than `distance`.
inline std::int32_t byteLimit(std::int32_t query_offset, std::int32_t distance) {
  return (query_offset - distance - 1) >> 1;
}

/// Updates the nearest trains of a query with groups of trains, and the nearest queries of these trains. Most
/// calls of compareBytes() do not need it, so it is not inlined.
/// @param sums  as in compareBytes(), [group][lane]
template <std::size_t kGroups, bool kForTrains>
__attribute__((noinline)) void takeSums(const NearestBlock<std::int32_t>& block, std::size_t query,
                                        std::size_t first_train, const std::int32_t* sums) {
  const std::int32_t query_offset = block.query_offset[query];
  for (std::size_t g = 0; g < kGroups; ++g) {
    const std::size_t first = first_train + g * kLanes;
    const IntV odd = load(block.train_offset + first) & 1;
    const IntV distances = splat(query_offset) - 2 * load(sums + g * kLanes) - odd;
    IntV closer = distances < splat(block.second[query]);
    if (kForTrains) closer |= distances < load(block.train_best + first);
    if (!anyTrue(closer)) continue;
    std::int32_t lanes[kLanes];
    store(lanes, distances);
    for (unsigned bits = bitsOf(closer); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(__builtin_ctz(bits));
      const std::size_t train = first + lane;
      const std::int32_t distance = lanes[lane];
      compete(block, query, train, distance);
      if (!kForTrains || !(distance < block.train_best[train])) continue;
      block.train_best[train] = distance;
      block.train_best_query[train] = block.first_query + static_cast<std::uint32_t>(query);
    }
  }
}

/// Compares kByteQueries queries with kGroups groups of trains.
///
/// The sums are s = q t' - ceil(|t|^2 / 2), so the distance is the query's offset - 2 s - (|t|^2 mod 2). One
/// comparison of s with a limit per query (and one per train) excludes almost all pairs. Pairs whose distance
/// is one too large may pass.
template <std::size_t kGroups, bool kForTrains>
inline void compareBytes(const NearestBlock<std::int32_t>& block, std::size_t query,
                         std::size_t first_train) {
  IntV sums[kByteQueries][kGroups];
#pragma GCC unroll 4
  for (std::size_t g = 0; g < kGroups; ++g) {
    const IntV start = -((load(block.train_offset + first_train + g * kLanes) + 1) >> 1);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kByteQueries; ++q) sums[q][g] = start;
  }
  const std::uint32_t* const queries = block.queries + query * block.words;
  const std::uint32_t* const trains = block.trains + first_train * block.words;
  for (std::size_t word = 0; word < block.words; ++word) {
    WordV train[kGroups];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) train[g] = load(trains + (g * block.words + word) * kLanes);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kByteQueries; ++q) {
      const WordV value = splat(queries[q * block.words + word]);
#pragma GCC unroll 4
      for (std::size_t g = 0; g < kGroups; ++g)
        sums[q][g] = (IntV)_mm512_dpbusd_epi32((__m512i)sums[q][g], (__m512i)value, (__m512i)train[g]);
    }
  }
  // What a train's limit is without the offset of the query. Both halves are rounded down.
  IntV train_limit[kGroups];
#pragma GCC unroll 4
  for (std::size_t g = 0; kForTrains && g < kGroups; ++g)
    train_limit[g] = (-load(block.train_best + first_train + g * kLanes) - 1) >> 1;
#pragma GCC unroll 4
  for (std::size_t q = 0; q < kByteQueries; ++q) {
    const std::int32_t query_offset = block.query_offset[query + q];
    const IntV limit = splat(byteLimit(query_offset, block.second[query + q]));
    IntV closer = {};
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) {
      closer |= sums[q][g] > limit;
      if (kForTrains) closer |= sums[q][g] > train_limit[g] + splat(query_offset >> 1);
    }
    if (!anyTrue(closer)) continue;
    std::int32_t lanes[kGroups * kLanes];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) store(lanes + g * kLanes, sums[q][g]);
    takeSums<kGroups, kForTrains>(block, query + q, first_train, lanes);
  }
}

template <bool kForTrains>
void bytesKernel(const NearestBlock<std::int32_t>& block) {
  static_assert(NearestBlock<std::int32_t>::kQueries % kByteQueries == 0, "whole groups of queries");
  std::size_t group = 0;
  for (; group + kByteGroups <= block.groups; group += kByteGroups) {
    for (std::size_t query = 0; query < block.query_count; query += kByteQueries)
      compareBytes<kByteGroups, kForTrains>(block, query, group * kLanes);
  }
  for (; group < block.groups; ++group) {
    for (std::size_t query = 0; query < block.query_count; query += kByteQueries)
      compareBytes<1, kForTrains>(block, query, group * kLanes);
  }
}
#elif defined(__AVX2__)
constexpr WholeNumberForm kWholeNumberForm = WholeNumberForm::kPairsAndCoarse;

// Groups of trains that give the queries a first limit.
constexpr std::size_t kFirstGroups = 4;

/// Sums of the products of unsigned and signed bytes, two by two. @pre they fit
inline WordV multiplyBytes(WordV a, WordV b) {
#if defined(__AVX512F__)
  return (WordV)_mm512_maddubs_epi16((__m512i)a, (__m512i)b);
#else
  return (WordV)_mm256_maddubs_epi16((__m256i)a, (__m256i)b);
#endif
}

inline WordV addShorts(WordV a, WordV b) {
#if defined(__AVX512F__)
  return (WordV)_mm512_add_epi16((__m512i)a, (__m512i)b);
#else
  return (WordV)_mm256_add_epi16((__m256i)a, (__m256i)b);
#endif
}

/// Keeps compilers from reordering the additions, which would need too many registers.
inline void keepOrder(WordV& v) {
#if defined(__AVX512F__)
  asm("" : "+v"(v));
#else
  asm("" : "+x"(v));
#endif
}

inline std::int32_t largestOf(IntV v) {
  std::int32_t result = v[0];
  for (int k = 1; k < kWidth; ++k) result = v[k] > result ? v[k] : result;
  return result;
}

/// Smallest coarse distance, rounded up, from which follows that the distance is not below `distance`.
inline std::int32_t coarseLimit(std::int32_t distance, double error) {
  const double root = __builtin_sqrt(static_cast<double>(distance)) + error;
  return static_cast<std::int32_t>(root * root) + 2;
}

inline IntV coarseLimit(IntV distance, double error) {
  const FloatV root = squareRoot(toFloat(distance)) + static_cast<float>(error);
  return truncate(root * root * 1.000001F) + 2;  // more than all roundings together
}

/// Distance of a query and a train, both rows of words.
inline std::int32_t exactDistance(const NearestBlock<std::int32_t>& block, std::size_t query,
                                  std::size_t train) {
  const std::uint32_t* const a = block.queries + query * block.words;
  const std::uint32_t* const b = block.trains + train * block.words;
  // Two sums: one addition need not wait for the other.
  WholeNumbers::Sum even = {}, odd = {};
  std::size_t word = 0;
  for (; word + 2 * kWidth <= block.words; word += 2 * kWidth) {
    even.add(load(a + word), load(b + word));
    odd.add(load(a + word + kWidth), load(b + word + kWidth));
  }
  if (word + kWidth <= block.words) {
    even.add(load(a + word), load(b + word));
    word += kWidth;
  }
  std::int32_t result = block.query_offset[query] + block.train_offset[train] + sum(even.value + odd.value);
  for (; word < block.words; ++word) {
    const auto low = [](std::uint32_t pair) { return static_cast<std::int16_t>(pair & 0xffffU); };
    const auto high = [](std::uint32_t pair) { return static_cast<std::int16_t>(pair >> 16); };
    result += low(a[word]) * low(b[word]) + high(a[word]) * high(b[word]);
  }
  return result;
}

/// Offset of a train, or of a padding row, in the form that coarseSums() reads.
inline IntV shortOffset(IntV offset) {
  const IntV largest = splat(CoarseNumbers::kLargestSquares);
  return (offset < largest ? offset : largest) >> 4;
}

/// Queries times a group of trains, less the trains' short offsets: in the upper halves of the lanes. These
/// fit, see CoarseNumbers::kLargestSquares; intermediate values may overflow.
inline void coarseSums(const CoarseNumbers& coarse, std::size_t query, std::size_t first_train,
                       const IntV (&offsets)[kParts], IntV (&results)[kQueriesAtATime][kParts]) {
  const std::uint32_t* const queries = coarse.queries + query * coarse.words;
  const std::uint32_t* const trains = coarse.trains + first_train * coarse.words;
  WordV sums[kQueriesAtATime][kParts];
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) sums[q][part] = -((WordV)offsets[part] << 16);
  }
  for (std::size_t first = 0; first < coarse.words; first += CoarseNumbers::kWords) {
#pragma GCC unroll 4
    for (std::size_t word = first; word < first + CoarseNumbers::kWords; ++word) {
      WordV train[kParts];
#pragma GCC unroll 4
      for (std::size_t part = 0; part < kParts; ++part) {
        train[part] = load(trains + word * kLanes + part * kWidth);
        keepOrder(train[part]);  // in a register for all queries
      }
#pragma GCC unroll 8
      for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
        const WordV value = splat(queries[q * coarse.words + word]);
#pragma GCC unroll 4
        for (std::size_t part = 0; part < kParts; ++part) {
          sums[q][part] = addShorts(sums[q][part], multiplyBytes(value, train[part]));
          keepOrder(sums[q][part]);
        }
      }
    }
  }
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part)
      results[q][part] = (IntV)(sums[q][part] + (sums[q][part] << 16));
  }
}

/// Lower bound of the sums of trains that are closer to a query than a coarse distance.
inline std::int32_t sumLimit(std::int32_t query_offset, std::int32_t distance) {
  // distance > query_offset + train_offset - 16 product. Both quotients are rounded down, so that a few
  // trains too many pass.
  const std::int32_t limit = (query_offset - distance) >> 4;
  if (limit < -(1 << 15)) return -0x7fff0001;
  return (limit < (1 << 15) - 1 ? limit : (1 << 15) - 1) * (1 << 16) + 0xffff;
}

/// Limits of the queries, from their second distances and from upper bounds of these: the nearest trains of
/// two sets of trains are two trains.
inline void limitQueries(const NearestBlock<std::int32_t>& block) {
  const CoarseNumbers& coarse = *block.coarse;
  for (std::size_t query = 0; query < block.query_count; query += kQueriesAtATime) {
    IntV nearest[kQueriesAtATime][2];
    for (auto& of_query : nearest) of_query[0] = of_query[1] = splat(-0x7fffffff);
    for (std::size_t group = 0; group < block.groups && group < kFirstGroups; ++group) {
      IntV offsets[kParts], sums[kQueriesAtATime][kParts];
      for (std::size_t part = 0; part < kParts; ++part)
        offsets[part] = shortOffset(load(coarse.train_offset + group * kLanes + part * kWidth));
      coarseSums(coarse, query, group * kLanes, offsets, sums);
      for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
        for (std::size_t part = 0; part < kParts; ++part) {
          IntV& largest = nearest[q][group % 2];
          largest = sums[q][part] > largest ? sums[q][part] : largest;
        }
      }
    }
    for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
      const std::int32_t offset = coarse.query_offset[query + q];
      std::int32_t limit = coarseLimit(block.second[query + q], coarse.error);
      // Trains that are near others do not count.
      if (block.near == nullptr) {
        const std::int32_t first = largestOf(nearest[q][0]) >> 16, second = largestOf(nearest[q][1]) >> 16;
        const std::int32_t sum = first < second ? first : second;
        if (sum > -CoarseNumbers::kLargestSquares / 16) {
          // One error from the coarse to the true distance, another one back; and 16 from rounding.
          const std::int32_t bound = coarseLimit(offset - 16 * sum + 16, 2 * coarse.error);
          limit = bound < limit ? bound : limit;
        }
      }
      const bool padding = offset == kFarDistance<std::int32_t>;
      coarse.limit[query + q] = padding ? sumLimit(0, -kFarDistance<std::int32_t>) : sumLimit(offset, limit);
    }
  }
}

/// Prefetches the rows of a group of trains, some of which will be compared.
inline void prefetchRows(const NearestBlock<std::int32_t>& block, std::size_t first_train) {
  if (first_train >= block.groups * kLanes) return;
  const std::uint32_t* const rows = block.trains + first_train * block.words;
  for (std::size_t word = 0; word < kLanes * block.words; word += 16) __builtin_prefetch(rows + word);
}

template <bool kForTrains>
void filteredKernel(const NearestBlock<std::int32_t>& block) {
  const CoarseNumbers& coarse = *block.coarse;
  limitQueries(block);
  for (std::size_t group = 0; group < block.groups; ++group) {
    const std::size_t first_train = group * kLanes;
    IntV offsets[kParts], train_limit[kParts];
    for (std::size_t part = 0; part < kParts; ++part)
      offsets[part] = shortOffset(load(coarse.train_offset + first_train + part * kWidth));
    const auto limitTrains = [&] {
      for (std::size_t part = 0; part < kParts; ++part) {
        const std::size_t train = first_train + part * kWidth;
        train_limit[part] = coarseLimit(load(block.train_best + train), coarse.error) >> 4;
      }
    };
    if (kForTrains) limitTrains();
    prefetchRows(block, first_train + kLanes);
    for (std::size_t query = 0; query < block.query_count; query += kQueriesAtATime) {
      IntV sums[kQueriesAtATime][kParts];
      coarseSums(coarse, query, first_train, offsets, sums);
#pragma GCC unroll 8
      for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
        const IntV limit = splat(coarse.limit[query + q]);
        IntV near[kParts];
        IntV any = {};
#pragma GCC unroll 4
        for (std::size_t part = 0; part < kParts; ++part) {
          near[part] = sums[q][part] > limit;
          if (kForTrains) {
            // One less for the quotients, as all are rounded down.
            const IntV least = splat((coarse.query_offset[query + q] >> 4) - 1) - train_limit[part];
            near[part] |= (sums[q][part] >> 16) > least;
          }
          any |= near[part];
        }
        if (!anyTrue(any)) continue;
        unsigned closer = 0;
        for (std::size_t part = 0; part < kParts; ++part) closer |= bitsOf(near[part]) << (part * kWidth);
        const std::int32_t second = block.second[query + q];
        bool trains_closer = false;
        for (; closer != 0; closer &= closer - 1) {
          const std::size_t train = first_train + static_cast<std::size_t>(__builtin_ctz(closer));
          const std::int32_t distance = exactDistance(block, query + q, train);
          compete(block, query + q, train, distance);
          if (!kForTrains || !(distance < block.train_best[train])) continue;
          block.train_best[train] = distance;
          block.train_best_query[train] = block.first_query + static_cast<std::uint32_t>(query + q);
          trains_closer = true;
        }
        if (block.second[query + q] != second) {
          const std::int32_t own =
              sumLimit(coarse.query_offset[query + q], coarseLimit(block.second[query + q], coarse.error));
          coarse.limit[query + q] = own > coarse.limit[query + q] ? own : coarse.limit[query + q];
        }
        if (trains_closer) limitTrains();
      }
    }
  }
}
#else
constexpr WholeNumberForm kWholeNumberForm = WholeNumberForm::kPairs;
#endif

template <class Metric>
void nearestKernel(const NearestBlock<typename Metric::Distance>& block) {
  typedef NearestBlock<typename Metric::Distance> Block;
  static_assert(Block::kTrains == kLanes, "one lane per train");
  static_assert(Block::kQueries % kQueriesAtATime == 0, "whole groups of queries");
  for (std::size_t group = 0; group < block.groups; ++group) {
    for (std::size_t query = 0; query < block.query_count; query += kQueriesAtATime)
      compareGroup<Metric, kQueriesAtATime>(block, query, group * kLanes);
  }
}

void wholeNumbersKernel(const NearestBlock<std::int32_t>& block) {
#if defined(__AVX512VNNI__)
  return block.train_best == nullptr ? bytesKernel<false>(block) : bytesKernel<true>(block);
#else
#if defined(__AVX2__)
  if (block.coarse != nullptr)
    return block.train_best == nullptr ? filteredKernel<false>(block) : filteredKernel<true>(block);
#endif
  nearestKernel<WholeNumbers>(block);
#endif
}

}  // namespace
}  // namespace corrsel::core
