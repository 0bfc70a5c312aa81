#pragma once

// Nearest and second nearest descriptors. Every lane is a train and every word of a query is broadcast to all
// lanes, so that nothing is added across lanes.

#include <type_traits>

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

/// The second smallest of the distances of a vector. NaN does not count.
template <class Distance>
inline Distance secondSmallest(const Distance (&lanes)[kWidth]) {
  Distance first = kFarDistance<Distance>, second = first;
  for (const Distance lane : lanes) {
    const Distance larger = first > lane ? first : lane;  // NaN is never smaller
    second = larger < second ? larger : second;
    first = lane < first ? lane : first;
  }
  return second;
}

// Of more lanes than these, only the two nearest can remain, so the others need not compete.
constexpr std::size_t kManyCloser = 3;

/// Updates the nearest trains of queries with a group of trains, and the nearest queries of these trains.
template <class Distance, class DistanceV, std::size_t kQueries>
inline void takeDistances(const NearestBlock<Distance>& block, std::size_t query, std::size_t first_train,
                          const DistanceV (&distances)[kQueries][kParts]) {
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueries; ++q) {
    const DistanceV second = splat(block.second[query + q]);
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) {
      const IntV closer = distances[q][part] < second;
      if (!anyTrue(closer)) continue;
      Distance lanes[kWidth];
      std::int32_t numbers[kWidth];
      store(lanes, distances[q][part]);
      std::size_t count = keep(closer, laneNumbers(), numbers);
      if (count > kManyCloser && block.near == nullptr) {
        const IntV nearest = distances[q][part] <= splat(secondSmallest(lanes));
        count = keep(closer & nearest, laneNumbers(), numbers);
      }
      for (std::size_t k = 0; k < count; ++k) {
        const auto lane = static_cast<std::size_t>(numbers[k]);
        compete(block, query + q, first_train + part * kWidth + lane, lanes[lane]);
      }
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
constexpr WholeNumberForm kWholeNumberForm = WholeNumberForm::kCoarse;

inline __m256i load256(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
inline void store256(void* p, __m256i v) { _mm256_storeu_si256(static_cast<__m256i*>(p), v); }

#if defined(__AVX512VNNI__)
// Sums of so many queries and groups of trains are in registers, so that every load serves four products.
constexpr std::size_t kCoarseQueries = 4, kCoarseGroups = 4;

/// Coarse sums of kCoarseQueries queries and some groups of trains: q' t' - |t'|^2 / 4 + bias. What does not
/// fit into 16 bits becomes the smallest number.
/// @param queries  of the first query, in its group
/// @param offsets  CoarseNumbers::train_offset
template <std::size_t kGroups>
inline void coarseSums(const std::uint32_t* queries, const std::uint32_t* trains, std::size_t words,
                       const std::int32_t* offsets, std::int32_t bias, std::int16_t* results,
                       std::size_t stride) {
  IntV sums[kCoarseQueries][kGroups];
#pragma GCC unroll 4
  for (std::size_t g = 0; g < kGroups; ++g) {
    const IntV start = splat(bias) - load(offsets + g * kLanes);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kCoarseQueries; ++q) sums[q][g] = start;
  }
  for (std::size_t word = 0; word < words; ++word) {
    WordV train[kGroups];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) train[g] = load(trains + (g * words + word) * kLanes);
#pragma GCC unroll 4
    for (std::size_t q = 0; q < kCoarseQueries; ++q) {
      const WordV value = splat(queries[word * CoarseNumbers::kQueries + q]);
#pragma GCC unroll 4
      for (std::size_t g = 0; g < kGroups; ++g)
        sums[q][g] = (IntV)_mm512_dpbusd_epi32((__m512i)sums[q][g], (__m512i)value, (__m512i)train[g]);
    }
  }
#pragma GCC unroll 4
  for (std::size_t q = 0; q < kCoarseQueries; ++q) {
#pragma GCC unroll 4
    for (std::size_t g = 0; g < kGroups; ++g) {
      const __m256i saturated = _mm512_maskz_cvtsepi32_epi16(static_cast<__mmask16>(-1), (__m512i)sums[q][g]);
      store256(results + q * stride + g * kLanes, saturated);
    }
  }
}

/// Coarse sums of some queries of a group of queries and all trains.
/// @param queries  in groups of CoarseNumbers::kQueries
inline void allCoarseSums(const NearestBlock<std::int32_t>& block, const std::uint32_t* queries,
                          std::size_t count, std::int32_t bias, std::size_t stride) {
  const CoarseNumbers& coarse = *block.coarse;
  const std::size_t words = coarse.projection->words;
  const auto compare = [&](std::size_t group, auto groups) {
    for (std::size_t query = 0; query < count; query += kCoarseQueries) {
      coarseSums<decltype(groups)::value>(queries + query, coarse.trains + group * kLanes * words, words,
                                          coarse.train_offset + group * kLanes, bias,
                                          coarse.sums + query * stride + group * kLanes, stride);
    }
  };
  std::size_t group = 0;
  for (; group + kCoarseGroups <= block.groups; group += kCoarseGroups)
    compare(group, std::integral_constant<std::size_t, kCoarseGroups>{});
  for (; group < block.groups; ++group) compare(group, std::integral_constant<std::size_t, 1>{});
}
#else
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

/// Coarse sums of kQueriesAtATime queries and a group of trains: q' t' - |t'|^2 / 4 + bias. What does not fit
/// into 16 bits is too small and wraps around to large values, which only costs an exact comparison.
/// @param queries  of the first query, in its group
/// @param start    per train: bias - CoarseNumbers::train_offset, in the upper half of each lane
__attribute__((noinline)) void coarseSums(const std::uint32_t* queries, const std::uint32_t* trains,
                                          std::size_t words, const WordV (&start)[kParts],
                                          std::int16_t* results, std::size_t stride) {
  WordV sums[kQueriesAtATime][kParts];
#pragma GCC unroll 8
  for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
#pragma GCC unroll 4
    for (std::size_t part = 0; part < kParts; ++part) sums[q][part] = start[part];
  }
  for (std::size_t first = 0; first < words; first += 2) {
#pragma GCC unroll 2
    for (std::size_t word = first; word < first + 2; ++word) {
      WordV train[kParts];
#pragma GCC unroll 4
      for (std::size_t part = 0; part < kParts; ++part) {
        train[part] = load(trains + word * kLanes + part * kWidth);
        keepOrder(train[part]);  // in a register for all queries
      }
#pragma GCC unroll 8
      for (std::size_t q = 0; q < kQueriesAtATime; ++q) {
        const WordV value = splat(queries[word * CoarseNumbers::kQueries + q]);
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
    // Both halves of a lane are added.
#if defined(__AVX512F__)
    const IntV lanes = (IntV)(sums[q][0] + (sums[q][0] << 16)) >> 16;
    store256(results + q * stride, _mm512_maskz_cvtepi32_epi16(static_cast<__mmask16>(-1), (__m512i)lanes));
#else
    const __m256i added = _mm256_hadd_epi16((__m256i)sums[q][0], (__m256i)sums[q][1]);
    store256(results + q * stride, _mm256_permute4x64_epi64(added, _MM_SHUFFLE(3, 1, 2, 0)));
#endif
  }
}

/// Coarse sums of some queries of a group of queries and all trains.
/// @param queries  in groups of CoarseNumbers::kQueries
inline void allCoarseSums(const NearestBlock<std::int32_t>& block, const std::uint32_t* queries,
                          std::size_t count, std::int32_t bias, std::size_t stride) {
  const CoarseNumbers& coarse = *block.coarse;
  const std::size_t words = coarse.projection->words;
  for (std::size_t group = 0; group < block.groups; ++group) {
    WordV start[kParts];
    for (std::size_t part = 0; part < kParts; ++part) {
      const IntV offset = load(coarse.train_offset + group * kLanes + part * kWidth);
      start[part] = (WordV)(splat(bias) - offset) << 16;
    }
    for (std::size_t query = 0; query < count; query += kQueriesAtATime) {
      coarseSums(queries + query, coarse.trains + group * kLanes * words, words, start,
                 coarse.sums + query * stride + group * kLanes, stride);
    }
  }
}
#endif

/// Distance of a query and a train, both rows of bytes.
inline std::int32_t exactDistance(const NearestBlock<std::int32_t>& block, std::size_t query,
                                  std::size_t train) {
  const std::uint32_t* const a = block.queries + query * block.words;
  const std::uint32_t* const b = block.trains + train * block.words;
  IntV squares = {};
  for (std::size_t word = 0; word < block.words; word += kWidth / 2) {
#if defined(__AVX512F__)
    const __m512i difference =
        _mm512_sub_epi16(_mm512_cvtepu8_epi16(load256(a + word)), _mm512_cvtepu8_epi16(load256(b + word)));
#else
    const auto widened = [](const std::uint32_t* p) {
      __m128i bytes;
      __builtin_memcpy(&bytes, p, sizeof bytes);
      return _mm256_cvtepu8_epi16(bytes);
    };
    const __m256i difference = _mm256_sub_epi16(widened(a + word), widened(b + word));
#endif
    squares = addProducts(squares, (IntV)difference, (IntV)difference);
  }
  return block.query_offset[query] + block.train_offset[train] + sum(squares);
}

/// The square of a coarse distance, rounded up, from which follows that the distance is not below `distance`.
/// @param scale  from distances of descriptors to coarse ones
inline std::int32_t coarseLimit(std::int32_t distance, double scale, double error) {
  const double root = __builtin_sqrt(static_cast<double>(distance)) * scale + error;
  return root < 3e4 ? static_cast<std::int32_t>(root * root) + 2 : 1 << 30;
}

inline std::int16_t toShort(std::int32_t value) {
  return static_cast<std::int16_t>(value < -0x8000 ? -0x8000 : value > 0x7fff ? 0x7fff : value);
}

/// The first train with the largest coarse sum among every second group.
inline std::size_t largestSum(const std::int16_t* sums, std::size_t first_group, std::size_t groups) {
  __m256i largest = _mm256_set1_epi16(-0x8000);
  for (std::size_t group = first_group; group < groups; group += 2)
    largest = _mm256_max_epi16(largest, load256(sums + group * kLanes));
  std::int16_t lanes[kLanes];
  store256(lanes, largest);
  std::int16_t value = lanes[0];
  for (const std::int16_t lane : lanes) value = lane > value ? lane : value;
  const __m256i wanted = _mm256_set1_epi16(value);
  for (std::size_t group = first_group;; group += 2) {
    const auto equal = static_cast<unsigned>(
        _mm256_movemask_epi8(_mm256_cmpeq_epi16(load256(sums + group * kLanes), wanted)));
    if (equal != 0) return group * kLanes + static_cast<std::size_t>(__builtin_ctz(equal)) / 2;
  }
}

/// Limits of the trains, from their best distances.
inline void limitTrains(const NearestBlock<std::int32_t>& block, double scale, double error) {
  const std::size_t trains = block.groups * kLanes;
  for (std::size_t train = 0; train < trains; ++train) {
    const bool padding = block.train_offset[train] == kFarDistance<std::int32_t>;
    block.coarse->train_limit[train] =
        toShort(padding ? -0x8000 : coarseLimit(block.train_best[train], scale, error));
  }
}

/// Two trains of a query with large sums, which are probably its nearest.
struct LikelyNearest {
  std::size_t train;             ///< the nearer one
  std::int32_t smaller, larger;  ///< distances
};

/// @pre at least two groups
inline LikelyNearest likelyNearest(const NearestBlock<std::int32_t>& block, std::size_t query,
                                   const std::int16_t* sums) {
  const std::size_t even = largestSum(sums, 0, block.groups), odd = largestSum(sums, 1, block.groups);
  const std::int32_t first = exactDistance(block, query, even), second = exactDistance(block, query, odd);
  return first < second ? LikelyNearest{even, first, second} : LikelyNearest{odd, second, first};
}

/// One bit for each lane of two groups that is not excluded; lanes of ones are.
inline unsigned notExcluded(__m256i first, __m256i second) {
  const unsigned mixed = ~static_cast<unsigned>(_mm256_movemask_epi8(_mm256_packs_epi16(first, second)));
  // packs interleaves them: 8 trains of the first group, 8 of the second, and so on.
  return (mixed & 0xff0000ffU) | (mixed >> 8 & 0xff00U) | (mixed & 0xff00U) << 8;
}

/// The distance from which on a train cannot decide about a query: that of the second nearest one so far, or
/// the one against which the nearest one so far passes the test of ratios.
inline std::int32_t limitOf(const NearestBlock<std::int32_t>& block, std::int32_t nearest,
                            std::int32_t second) {
  const double ratio = block.coarse->ratio;
  if (!(ratio < 1) || nearest >= ratio * ratio * second) return second;
  // Slightly larger than exact numbers, because the test is one of rounded roots.
  return static_cast<std::int32_t>(nearest / (ratio * ratio) * (1 + 1e-6)) + 2;
}

/// Whether a query fails the test of ratios, as far as two trains and the coarse sums of the others show it.
/// Let b be the smaller one of both distances and a that of any other train. If b fails against the larger
/// one and every a fails against b, whichever distances are the smallest ones fail.
/// @param lowestSum  of trains below a distance
template <class LowestSum>
inline bool failsRatio(const NearestBlock<std::int32_t>& block, std::size_t query, const std::int16_t* sums,
                       const LikelyNearest& likely, const LowestSum& lowestSum) {
  const double ratio = block.coarse->ratio;
  const auto root = [](std::int32_t distance) { return __builtin_sqrtf(static_cast<float>(distance)); };
  if (!(root(likely.smaller) >= ratio * root(likely.larger))) return false;
  // Slightly larger than exact numbers, because the test is one of rounded roots.
  const auto limit = static_cast<std::int32_t>(ratio * ratio * likely.smaller * (1 + 1e-6)) + 2;
  const __m256i lowest = lowestSum(limit);
  for (std::size_t first = 0; first < block.groups * kLanes; first += 2 * kLanes) {
    unsigned bits = notExcluded(_mm256_cmpgt_epi16(lowest, load256(sums + first)),
                                _mm256_cmpgt_epi16(lowest, load256(sums + first + kLanes)));
    if (first + kLanes == block.groups * kLanes) bits &= 0xffffU;
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t train = first + static_cast<std::size_t>(__builtin_ctz(bits));
      if (exactDistance(block, query, train) < limit) return false;
    }
  }
  return true;
}

/// The distance from which on a train cannot decide about a query, or -1 where the query fails the test of
/// ratios; then its neighbours are set.
template <class LowestSum>
inline std::int32_t firstLimit(const NearestBlock<std::int32_t>& block, std::size_t query,
                               const std::int16_t* sums, const LowestSum& lowestSum) {
  const std::int32_t limit = block.second[query];
  if (block.near != nullptr || block.groups <= 1) return limit;
  const LikelyNearest likely = likelyNearest(block, query, sums);
  if (block.coarse->ratio < 1 && failsRatio(block, query, sums, likely, lowestSum)) {
    block.best[query] = likely.smaller;
    block.second[query] = likely.larger;
    block.best_train[query] = static_cast<std::uint32_t>(likely.train);
    return -1;
  }
  return limitOf(block, likely.smaller, likely.larger < limit ? likely.larger + 1 : limit);
}

/// Compares a query with the trains that its coarse sums do not exclude.
/// @param sums   of the query
/// @param bias, scale, error  as in filteredKernel()
template <bool kForTrains>
__attribute__((noinline)) void compareNear(const NearestBlock<std::int32_t>& block, std::size_t query,
                                           const std::int16_t* sums, std::int32_t bias, double scale,
                                           double error) {
  const CoarseNumbers& coarse = *block.coarse;
  const std::int32_t offset = coarse.query_offset[query];
  const double own_error =
      coarse.train_error +
      __builtin_sqrt(static_cast<double>(coarse.query_error[query])) / (2.0 * coarse.projection->step);
  const bool fits = offset + bias <= 0x7fff;
  const auto lowestSum = [&](std::int32_t distance) {
    return _mm256_set1_epi16(fits ? toShort(offset - coarseLimit(distance, scale, own_error) + bias)
                                  : static_cast<std::int16_t>(-0x8000));
  };
  std::int32_t limit = firstLimit(block, query, sums, lowestSum);
  if (limit < 0) return;
  __m256i lowest = lowestSum(limit);
  const __m256i lowest_of_trains =
      _mm256_set1_epi16(fits ? toShort(offset + bias) : static_cast<std::int16_t>(-0x8000));
  // Lanes of ones where a train is excluded.
  const auto excluded = [&](std::size_t train) {
    const __m256i sum = load256(sums + train);
    const __m256i result = _mm256_cmpgt_epi16(lowest, sum);
    if (!kForTrains) return result;
    const __m256i raised = _mm256_adds_epi16(sum, load256(coarse.train_limit + train));
    return _mm256_and_si256(result, _mm256_cmpgt_epi16(lowest_of_trains, raised));
  };
  // Trains whose rows are on their way to the cache.
  constexpr std::size_t kMaxWaiting = 32;
  std::size_t waiting[kMaxWaiting + 2 * kLanes], waiting_count = 0;
  const auto compareWaiting = [&] {
    for (std::size_t i = 0; i < waiting_count; ++i) {
      const std::size_t train = waiting[i];
      const std::int32_t distance = exactDistance(block, query, train);
      compete(block, query, train, distance);
      if (!kForTrains || !(distance < block.train_best[train])) continue;
      block.train_best[train] = distance;
      block.train_best_query[train] = block.first_query + static_cast<std::uint32_t>(query);
      coarse.train_limit[train] = toShort(coarseLimit(distance, scale, error));
    }
    waiting_count = 0;
    const std::int32_t nearer = limitOf(block, block.best[query], block.second[query]);
    if (!(nearer < limit)) return;
    limit = nearer;
    lowest = lowestSum(limit);
  };
  const std::size_t trains = block.groups * kLanes;
  for (std::size_t first = 0; first < trains; first += 2 * kLanes) {
    unsigned bits = notExcluded(excluded(first), excluded(first + kLanes));
    if (first + kLanes == trains) bits &= 0xffffU;
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t train = first + static_cast<std::size_t>(__builtin_ctz(bits));
      for (std::size_t word = 0; word < block.words; word += 16)
        __builtin_prefetch(block.trains + train * block.words + word);
      waiting[waiting_count++] = train;
    }
    if (waiting_count >= kMaxWaiting) compareWaiting();
  }
  compareWaiting();
}

/// Compares all queries with the trains that coarse numbers do not exclude. Of 16 queries at a time, first
/// the coarse sums with all trains are computed, without branches. The trains with the largest sums are
/// probably near, so their distances give the query a limit; then the sums are searched for trains within the
/// limit.
template <bool kForTrains>
void filteredKernel(const NearestBlock<std::int32_t>& block) {
  const CoarseNumbers& coarse = *block.coarse;
  const std::size_t words = coarse.projection->words;
  const double steps = 2.0 * coarse.projection->step;
  // From distances of descriptors to those of coarse numbers, and the largest error of these.
  const double scale = __builtin_sqrt(static_cast<double>(coarse.projection->size)) / steps;
  double error = 0;
  for (std::size_t query = 0; query < block.query_count; ++query) {
    const double own = coarse.query_error[query];
    error = own > error ? own : error;
  }
  error = __builtin_sqrt(error) / steps + coarse.train_error;
  if (kForTrains) limitTrains(block, scale, error);
  const std::size_t stride = (block.groups + block.groups % 2) * kLanes;
  for (std::size_t first = 0; first < block.query_count; first += CoarseNumbers::kQueries) {
    const std::size_t rest = block.query_count - first;
    const std::size_t count = rest < CoarseNumbers::kQueries ? rest : CoarseNumbers::kQueries;
    std::int32_t largest = 0;
    for (std::size_t query = first; query < first + count; ++query) {
      const std::int32_t offset = coarse.query_offset[query];
      if (offset > largest && offset <= 0x7fff) largest = offset;
    }
    const std::int32_t bias = 0x7fff - largest;  // no sum is above |q'|^2
    allCoarseSums(block, coarse.queries + first * words, count, bias, stride);
    for (std::size_t query = 0; query < count; ++query) {
      if (block.query_offset[first + query] == kFarDistance<std::int32_t>) continue;
      compareNear<kForTrains>(block, first + query, coarse.sums + query * stride, bias, scale, error);
    }
  }
}

void transformKernel(const std::uint8_t* const* descriptors, std::size_t columns, std::size_t size,
                     std::int16_t* products) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::size_t given = descriptors[lane] == nullptr ? 0 : columns;
    for (std::size_t column = 0; column < given; ++column)
      products[column * kLanes + lane] = descriptors[lane][column];
    for (std::size_t column = given; column < size; ++column) products[column * kLanes + lane] = 0;
  }
  for (std::size_t half = 1; half < size; half *= 2) {
    for (std::size_t first = 0; first < size; first += 2 * half) {
      for (std::size_t row = first; row < first + half; ++row) {
        std::int16_t *const upper = products + row * kLanes, *const lower = upper + half * kLanes;
        const __m256i a = load256(upper), b = load256(lower);
        store256(upper, _mm256_add_epi16(a, b));
        store256(lower, _mm256_sub_epi16(a, b));
      }
    }
  }
}

void projectKernel(const std::uint8_t* const* descriptors, std::size_t columns, const Projection& projection,
                   bool as_queries, std::uint32_t* words, std::int32_t* offsets, std::uint16_t* errors) {
  std::int16_t products[Projection::kMaxSize * kLanes];
  transformKernel(descriptors, columns, projection.size, products);
  const std::int32_t step = as_queries ? 2 * projection.step : projection.step;
  const __m256i largest = _mm256_set1_epi16(static_cast<std::int16_t>(126 * projection.step));
  const __m256i smallest = _mm256_sub_epi16(_mm256_setzero_si256(), largest);
  const __m256i steps = _mm256_set1_epi16(static_cast<std::int16_t>(step));
  const __m256i inverse = _mm256_set1_epi16(static_cast<std::int16_t>((32768 + step / 2) / step));
  const __m256i shift = _mm256_set1_epi16(as_queries ? 64 : 0), low = _mm256_set1_epi16(0xff);
  __m256i sum = _mm256_setzero_si256(), error = sum, squares[2] = {sum, sum};
  for (std::size_t word = 0; word < projection.words; ++word) {
    __m256i numbers[4], bytes[4];
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t row = 4 * word + k;
      const __m256i mean = _mm256_set1_epi16(projection.means[row]);
      __m256i y = _mm256_subs_epi16(load256(products + projection.rows[row] * kLanes), mean);
      y = _mm256_max_epi16(_mm256_min_epi16(y, largest), smallest);
      numbers[k] = _mm256_mulhrs_epi16(y, inverse);
      const __m256i rest = _mm256_sub_epi16(y, _mm256_mullo_epi16(numbers[k], steps));
      error = _mm256_adds_epu16(error, _mm256_mullo_epi16(rest, rest));
      sum = _mm256_add_epi16(sum, numbers[k]);
      bytes[k] = _mm256_and_si256(_mm256_add_epi16(numbers[k], shift), low);
    }
    for (std::size_t k = 0; k < 4; k += 2) {
      const __m256i first = _mm256_unpacklo_epi16(numbers[k], numbers[k + 1]);
      const __m256i last = _mm256_unpackhi_epi16(numbers[k], numbers[k + 1]);
      squares[0] = _mm256_add_epi32(squares[0], _mm256_madd_epi16(first, first));
      squares[1] = _mm256_add_epi32(squares[1], _mm256_madd_epi16(last, last));
    }
    const __m256i pairs[2] = {_mm256_or_si256(bytes[0], _mm256_slli_epi16(bytes[1], 8)),
                              _mm256_or_si256(bytes[2], _mm256_slli_epi16(bytes[3], 8))};
    const __m256i first = _mm256_unpacklo_epi16(pairs[0], pairs[1]);
    const __m256i last = _mm256_unpackhi_epi16(pairs[0], pairs[1]);
    store256(words + word * kLanes, _mm256_permute2x128_si256(first, last, 0x20));
    store256(words + word * kLanes + 8, _mm256_permute2x128_si256(first, last, 0x31));
  }
  store256(errors, error);
  const __m256i sums[2] = {_mm256_cvtepi16_epi32(_mm256_castsi256_si128(sum)),
                           _mm256_cvtepi16_epi32(_mm256_extracti128_si256(sum, 1))};
  for (int half = 0; half < 2; ++half) {
    const __m256i own = half == 0 ? _mm256_permute2x128_si256(squares[0], squares[1], 0x20)
                                  : _mm256_permute2x128_si256(squares[0], squares[1], 0x31);
    const __m256i of_train = _mm256_add_epi32(_mm256_srli_epi32(own, 2), _mm256_slli_epi32(sums[half], 6));
    store256(offsets + 8 * half, as_queries ? own : of_train);
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
#if defined(__AVX2__)
  if (block.coarse != nullptr)
    return block.train_best == nullptr ? filteredKernel<false>(block) : filteredKernel<true>(block);
#endif
  nearestKernel<WholeNumbers>(block);
}

#if defined(__AVX2__)
constexpr DescriptorKernels kDescriptorKernels = {wholeNumbersKernel,  kWholeNumberForm,
                                                  transformKernel,     projectKernel,
                                                  nearestKernel<Bits>, nearestKernel<Floats>};
#else
constexpr DescriptorKernels kDescriptorKernels = {wholeNumbersKernel,  kWholeNumberForm,     nullptr, nullptr,
                                                  nearestKernel<Bits>, nearestKernel<Floats>};
#endif

}  // namespace
}  // namespace corrsel::core
