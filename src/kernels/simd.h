#pragma once

// Vectors of the width that the including file is compiled for. Included by the level_*.cpp files only, which
// are compiled for different processors: everything here and in the *_kernels.h files has internal linkage
// and uses no standard library templates, whose copies the linker would share between levels.

#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

namespace corrsel::core {
namespace {

#if defined(__AVX512F__)
constexpr int kWidth = 16;
#elif defined(__AVX2__)
constexpr int kWidth = 8;
#else
constexpr int kWidth = 4;
#endif

/// kWidth lanes. Arithmetic, comparisons (lanes of all ones or zeros) and mask ? a : b are the compiler's.
typedef float FloatV __attribute__((vector_size(kWidth * 4)));
typedef std::int32_t IntV __attribute__((vector_size(kWidth * 4)));

/// kDoubleWidth lanes.
constexpr int kDoubleWidth = kWidth / 2;
typedef double DoubleV __attribute__((vector_size(kWidth * 4)));
typedef std::int64_t LongV __attribute__((vector_size(kWidth * 4)));

/// 2 kWidth lanes.
typedef std::int16_t ShortV __attribute__((vector_size(kWidth * 4)));
constexpr int kShorts = 2 * kWidth;

/// Sums are kept in kLanes lanes at every level, so that they round alike: kParts vectors.
constexpr int kLanes = 16;
constexpr int kParts = kLanes / kWidth;

inline FloatV load(const float* p) {
  FloatV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline IntV load(const std::int32_t* p) {
  IntV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void store(float* p, FloatV v) { __builtin_memcpy(p, &v, sizeof v); }
inline void store(std::int32_t* p, IntV v) { __builtin_memcpy(p, &v, sizeof v); }

inline DoubleV load(const double* p) {
  DoubleV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline LongV load(const std::int64_t* p) {
  LongV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void store(double* p, DoubleV v) { __builtin_memcpy(p, &v, sizeof v); }
inline void store(std::int64_t* p, LongV v) { __builtin_memcpy(p, &v, sizeof v); }

inline ShortV load(const std::int16_t* p) {
  ShortV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void store(std::int16_t* p, ShortV v) { __builtin_memcpy(p, &v, sizeof v); }

inline FloatV splat(float value) { return value - FloatV{}; }
inline IntV splat(std::int32_t value) { return value - IntV{}; }
inline ShortV splat(std::int16_t value) { return value - ShortV{}; }

inline FloatV toFloat(IntV v) { return __builtin_convertvector(v, FloatV); }

/// Towards zero. @pre |v| < 2^31
inline IntV truncate(FloatV v) { return __builtin_convertvector(v, IntV); }
inline std::int32_t truncate(float v) { return static_cast<std::int32_t>(v); }

inline float minimum(float a, float b) { return a < b ? a : b; }
inline float maximum(float a, float b) { return a > b ? a : b; }
inline FloatV minimum(FloatV a, FloatV b) { return a < b ? a : b; }
inline FloatV maximum(FloatV a, FloatV b) { return a > b ? a : b; }
inline IntV minimum(IntV a, IntV b) { return a < b ? a : b; }
inline IntV maximum(IntV a, IntV b) { return a > b ? a : b; }
inline ShortV minimum(ShortV a, ShortV b) { return a < b ? a : b; }
inline ShortV maximum(ShortV a, ShortV b) { return a > b ? a : b; }

/// 0, 1, 2...
inline IntV laneNumbers() {
  constexpr std::int32_t kNumbers[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return load(kNumbers);
}

/// Writes the lanes of v whose mask is set to `out`, in their order. There must be room for all lanes.
/// @return their number
inline std::size_t keep(IntV mask, IntV v, void* out) {
#if defined(__AVX512F__)
  const __mmask16 bits = _mm512_movepi32_mask((__m512i)mask);
  const IntV kept = (IntV)_mm512_maskz_compress_epi32(bits, (__m512i)v);
  __builtin_memcpy(out, &kept, sizeof kept);
  return static_cast<std::size_t>(__builtin_popcount(bits));
#else
  std::int32_t set[kWidth], value[kWidth];
  store(set, mask);
  store(value, v);
  std::size_t count = 0;
  for (int k = 0; k < kWidth; ++k) {
    __builtin_memcpy(static_cast<std::int32_t*>(out) + count, value + k, sizeof *value);
    count += set[k] != 0 ? 1 : 0;
  }
  return count;
#endif
}

/// pairs[2 index] and pairs[2 index + 1] in every lane.
inline void gatherPairs(const float* pairs, IntV index, FloatV& first, FloatV& second) {
#if defined(__AVX512F__)
  const __m512i zero = _mm512_setzero_si512();
  __m256i halves[2];
  __builtin_memcpy(halves, &index, sizeof index);
  const __m512i low = _mm512_mask_i32gather_epi64(zero, static_cast<__mmask8>(-1), halves[0], pairs, 8);
  const __m512i high = _mm512_mask_i32gather_epi64(zero, static_cast<__mmask8>(-1), halves[1], pairs, 8);
  const __m512i even = (__m512i)(laneNumbers() * 2);
  first = (FloatV)_mm512_permutex2var_epi32(low, even, high);
  second = (FloatV)_mm512_permutex2var_epi32(low, (__m512i)((IntV)even + 1), high);
#else
  std::int32_t at[kWidth];
  store(at, index);
  for (int k = 0; k < kWidth; ++k) {
    first[k] = pairs[2 * at[k]];
    second[k] = pairs[2 * at[k] + 1];
  }
#endif
}

/// table[index] in every lane.
inline FloatV gather(const float* table, IntV index) {
#if defined(__AVX512F__)
  return (FloatV)_mm512_mask_i32gather_ps(_mm512_setzero_ps(), static_cast<__mmask16>(-1), (__m512i)index,
                                          table, 4);
#elif defined(__AVX2__)
  return (FloatV)_mm256_i32gather_ps(table, (__m256i)index, 4);
#else
  FloatV v;
  for (int k = 0; k < kWidth; ++k) v[k] = table[index[k]];
  return v;
#endif
}

inline FloatV absolute(FloatV v) { return (FloatV)((IntV)v & 0x7fffffff); }

/// Exactly rounded square roots.
inline FloatV squareRoot(FloatV v) {
#if defined(__AVX512F__)
  // Masked, because GCC 12 takes the plain form's undefined source for a mistake.
  return (FloatV)_mm512_maskz_sqrt_ps(static_cast<__mmask16>(-1), (__m512)v);
#elif defined(__AVX2__)
  return (FloatV)_mm256_sqrt_ps((__m256)v);
#elif defined(__SSE2__)
  return (FloatV)_mm_sqrt_ps((__m128)v);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (FloatV)vsqrtq_f32((float32x4_t)v);
#else
  for (int k = 0; k < kWidth; ++k) v[k] = __builtin_sqrtf(v[k]);
  return v;
#endif
}

inline DoubleV absolute(DoubleV v) { return (DoubleV)((LongV)v & 0x7fffffffffffffff); }

/// Exactly rounded square roots.
inline DoubleV squareRoot(DoubleV v) {
#if defined(__AVX512F__)
  return (DoubleV)_mm512_maskz_sqrt_pd(static_cast<__mmask8>(-1), (__m512d)v);
#elif defined(__AVX2__)
  return (DoubleV)_mm256_sqrt_pd((__m256d)v);
#elif defined(__SSE2__)
  return (DoubleV)_mm_sqrt_pd((__m128d)v);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (DoubleV)vsqrtq_f64((float64x2_t)v);
#else
  for (int k = 0; k < kDoubleWidth; ++k) v[k] = __builtin_sqrt(v[k]);
  return v;
#endif
}

/// One bit per lane in which a < b, the first lane lowest.
inline std::uint64_t lessBits(DoubleV a, DoubleV b) {
#if defined(__AVX512F__)
  return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
#elif defined(__AVX2__)
  return static_cast<std::uint64_t>(_mm256_movemask_pd((__m256d)(a < b)));
#elif defined(__SSE2__)
  return static_cast<std::uint64_t>(_mm_movemask_pd((__m128d)(a < b)));
#else
  std::uint64_t bits = 0;
  for (int k = 0; k < kDoubleWidth; ++k) bits |= static_cast<std::uint64_t>(a[k] < b[k]) << k;
  return bits;
#endif
}

/// The last lane first.
inline DoubleV reversed(DoubleV v) {
#if defined(__AVX512F__)
  const __m512i order = _mm512_set_epi64(0, 1, 2, 3, 4, 5, 6, 7);
  return (DoubleV)_mm512_maskz_permutexvar_pd(static_cast<__mmask8>(-1), order, (__m512d)v);
#elif defined(__AVX2__)
  return (DoubleV)_mm256_permute4x64_pd((__m256d)v, _MM_SHUFFLE(0, 1, 2, 3));
#else
  return DoubleV{v[1], v[0]};
#endif
}

/// sum + the dot product of the two signed 16-bit numbers in each lane. @pre the result fits
inline IntV addProducts(IntV sum, IntV a, IntV b) {
#if defined(__AVX512VNNI__)
  return (IntV)_mm512_dpwssd_epi32((__m512i)sum, (__m512i)a, (__m512i)b);
#elif defined(__AVX512F__)
  return sum + (IntV)_mm512_madd_epi16((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return sum + (IntV)_mm256_madd_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return sum + (IntV)_mm_madd_epi16((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  const int16x8_t p = (int16x8_t)a, q = (int16x8_t)b;
  const int32x4_t low = vmull_s16(vget_low_s16(p), vget_low_s16(q));
  return sum + (IntV)vpaddq_s32(low, vmull_high_s16(p, q));
#else
  // The lower numbers are moved up and back, which extends their sign.
  return sum + (a << 16 >> 16) * (b << 16 >> 16) + (a >> 16) * (b >> 16);
#endif
}

/// Whether a lane of a mask is set.
inline bool anyTrue(IntV mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask((__m512i)mask) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_ps((__m256)mask) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_ps((__m128)mask) != 0;
#else
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
#endif
}
inline bool anyTrue(bool mask) { return mask; }
inline bool anyTrue(ShortV mask) {
#if defined(__AVX512F__)
  return _mm512_movepi16_mask((__m512i)mask) != 0;
#elif defined(__AVX2__)
  return _mm256_movemask_epi8((__m256i)mask) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_epi8((__m128i)mask) != 0;
#else
  const IntV pairs = (IntV)mask;
  return (pairs[0] | pairs[1] | pairs[2] | pairs[3]) != 0;
#endif
}

/// Lanes of a and b in turn, a first: those of the lower and those of the upper half of each 128 bits.
inline ShortV interleaveLow(ShortV a, ShortV b) {
#if defined(__AVX512F__)
  return (ShortV)_mm512_unpacklo_epi16((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (ShortV)_mm256_unpacklo_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (ShortV)_mm_unpacklo_epi16((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (ShortV)vzip1q_s16((int16x8_t)a, (int16x8_t)b);
#else
  ShortV result{};
  for (int k = 0; k < 4; ++k) {
    result[2 * k] = a[k];
    result[2 * k + 1] = b[k];
  }
  return result;
#endif
}
inline ShortV interleaveHigh(ShortV a, ShortV b) {
#if defined(__AVX512F__)
  return (ShortV)_mm512_unpackhi_epi16((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (ShortV)_mm256_unpackhi_epi16((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (ShortV)_mm_unpackhi_epi16((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (ShortV)vzip2q_s16((int16x8_t)a, (int16x8_t)b);
#else
  ShortV result{};
  for (int k = 0; k < 4; ++k) {
    result[2 * k] = a[4 + k];
    result[2 * k + 1] = b[4 + k];
  }
  return result;
#endif
}
inline IntV interleaveLow(IntV a, IntV b) {
#if defined(__AVX512F__)
  return (IntV)_mm512_maskz_unpacklo_epi32(static_cast<__mmask16>(-1), (__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (IntV)_mm256_unpacklo_epi32((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (IntV)_mm_unpacklo_epi32((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (IntV)vzip1q_s32((int32x4_t)a, (int32x4_t)b);
#else
  IntV result{};
  for (int k = 0; k < 2; ++k) {
    result[2 * k] = a[k];
    result[2 * k + 1] = b[k];
  }
  return result;
#endif
}
inline IntV interleaveHigh(IntV a, IntV b) {
#if defined(__AVX512F__)
  return (IntV)_mm512_maskz_unpackhi_epi32(static_cast<__mmask16>(-1), (__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (IntV)_mm256_unpackhi_epi32((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (IntV)_mm_unpackhi_epi32((__m128i)a, (__m128i)b);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (IntV)vzip2q_s32((int32x4_t)a, (int32x4_t)b);
#else
  IntV result{};
  for (int k = 0; k < 2; ++k) {
    result[2 * k] = a[2 + k];
    result[2 * k + 1] = b[2 + k];
  }
  return result;
#endif
}

/// The reverse of interleaveLow() and interleaveHigh(): the lower 16 bits of each lane, in the order of the
/// lanes that were interleaved. @pre values from -2^15 to 2^15 - 1
inline ShortV narrow(IntV low, IntV high) {
#if defined(__AVX512F__)
  return (ShortV)_mm512_packs_epi32((__m512i)low, (__m512i)high);
#elif defined(__AVX2__)
  return (ShortV)_mm256_packs_epi32((__m256i)low, (__m256i)high);
#elif defined(__SSE2__)
  return (ShortV)_mm_packs_epi32((__m128i)low, (__m128i)high);
#elif defined(__ARM_NEON) && defined(__aarch64__)
  return (ShortV)vcombine_s16(vmovn_s32((int32x4_t)low), vmovn_s32((int32x4_t)high));
#else
  ShortV result{};
  for (int k = 0; k < 4; ++k) {
    result[k] = static_cast<std::int16_t>(low[k]);
    result[4 + k] = static_cast<std::int16_t>(high[k]);
  }
  return result;
#endif
}

/// Sum of the lanes. @pre it fits
inline std::int32_t sum(IntV v) {
#if defined(__AVX2__)
  __m256i parts[kWidth / 8];
  __builtin_memcpy(parts, &v, sizeof v);
  const __m256i eight = kWidth == 16 ? _mm256_add_epi32(parts[0], parts[kWidth / 8 - 1]) : parts[0];
  __m128i four = _mm_add_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
#elif defined(__SSE2__)
  __m128i four = (__m128i)v;
#endif
#if defined(__SSE2__)
  four = _mm_add_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
  four = _mm_add_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(2, 3, 0, 1)));
  return _mm_cvtsi128_si32(four);
#else
  return v[0] + v[1] + v[2] + v[3];
#endif
}

}  // namespace
}  // namespace corrsel::core
