#pragma once

// Vectors of unsigned whole numbers of 8 and 16 bits, for the kernels on pixels. Included like simd.h.

#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr int kBytes = kWidth * 4;  ///< 8-bit lanes of a vector

typedef std::uint8_t ByteV __attribute__((vector_size(kBytes)));
typedef std::uint16_t UShortV __attribute__((vector_size(kBytes)));

inline ByteV loadBytes(const std::uint8_t* p) {
  ByteV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void storeBytes(std::uint8_t* p, ByteV v) { __builtin_memcpy(p, &v, sizeof v); }

inline UShortV load(const std::uint16_t* p) {
  UShortV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void store(std::uint16_t* p, UShortV v) { __builtin_memcpy(p, &v, sizeof v); }

inline ByteV splatByte(int value) { return static_cast<std::uint8_t>(value) - ByteV{}; }

inline ByteV minimum(ByteV a, ByteV b) {
#if defined(__AVX512F__)
  return (ByteV)_mm512_min_epu8((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (ByteV)_mm256_min_epu8((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (ByteV)_mm_min_epu8((__m128i)a, (__m128i)b);
#else
  return a < b ? a : b;
#endif
}

inline ByteV maximum(ByteV a, ByteV b) {
#if defined(__AVX512F__)
  return (ByteV)_mm512_max_epu8((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (ByteV)_mm256_max_epu8((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (ByteV)_mm_max_epu8((__m128i)a, (__m128i)b);
#else
  return a > b ? a : b;
#endif
}

/// max(a - b, 0)
inline ByteV excess(ByteV a, ByteV b) {
#if defined(__AVX512F__)
  return (ByteV)_mm512_subs_epu8((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
  return (ByteV)_mm256_subs_epu8((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
  return (ByteV)_mm_subs_epu8((__m128i)a, (__m128i)b);
#else
  return maximum(a, b) - b;
#endif
}

/// One bit per lane that is not zero, the first lane lowest.
inline std::uint64_t nonZeroBits(ByteV v) {
#if defined(__AVX512F__)
  return _mm512_test_epi8_mask((__m512i)v, (__m512i)v);
#elif defined(__AVX2__)
  const __m256i zero = _mm256_cmpeq_epi8((__m256i)v, _mm256_setzero_si256());
  return static_cast<std::uint32_t>(~_mm256_movemask_epi8(zero));
#elif defined(__SSE2__)
  const __m128i zero = _mm_cmpeq_epi8((__m128i)v, _mm_setzero_si128());
  return static_cast<std::uint64_t>(~_mm_movemask_epi8(zero) & 0xffff);
#else
  std::uint64_t bits = 0;
  for (int k = 0; k < kBytes; ++k) bits |= static_cast<std::uint64_t>(v[k] != 0) << k;
  return bits;
#endif
}

inline bool anyNonZero(ByteV v) {
#if defined(__ARM_NEON) && defined(__aarch64__)
  return vmaxvq_u8((uint8x16_t)v) != 0;
#else
  return nonZeroBits(v) != 0;
#endif
}

/// kShorts bytes as 16-bit numbers.
inline UShortV widen(const std::uint8_t* p) {
#if defined(__AVX512F__)
  return (UShortV)_mm512_cvtepu8_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
#elif defined(__AVX2__)
  return (UShortV)_mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
#elif defined(__SSE2__)
  return (UShortV)_mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)),
                                    _mm_setzero_si128());
#elif defined(__ARM_NEON)
  return (UShortV)vmovl_u8(vld1_u8(p));
#else
  UShortV v;
  for (int k = 0; k < kShorts; ++k) v[k] = p[k];
  return v;
#endif
}

/// Stores kShorts numbers as bytes. @pre they are below 256
inline void narrow(std::uint8_t* p, UShortV v) {
#if defined(__AVX512F__)
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm512_maskz_cvtepi16_epi8(~__mmask32{0}, (__m512i)v));
#elif defined(__AVX2__)
  const __m256i packed = _mm256_packus_epi16((__m256i)v, (__m256i)v);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p),
                   _mm256_castsi256_si128(_mm256_permute4x64_epi64(packed, _MM_SHUFFLE(3, 1, 2, 0))));
#elif defined(__SSE2__)
  _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_packus_epi16((__m128i)v, (__m128i)v));
#elif defined(__ARM_NEON)
  vst1_u8(p, vmovn_u16((uint16x8_t)v));
#else
  for (int k = 0; k < kShorts; ++k) p[k] = static_cast<std::uint8_t>(v[k]);
#endif
}

/// The product of every lane with a factor, divided by 2^16 and rounded down.
inline UShortV highProduct(UShortV v, std::uint16_t factor) {
#if defined(__AVX512F__)
  return (UShortV)_mm512_mulhi_epu16((__m512i)v, _mm512_set1_epi16(static_cast<short>(factor)));
#elif defined(__AVX2__)
  return (UShortV)_mm256_mulhi_epu16((__m256i)v, _mm256_set1_epi16(static_cast<short>(factor)));
#elif defined(__SSE2__)
  return (UShortV)_mm_mulhi_epu16((__m128i)v, _mm_set1_epi16(static_cast<short>(factor)));
#elif defined(__ARM_NEON)
  const uint16x8_t u = (uint16x8_t)v;
  const uint16x4_t low = vshrn_n_u32(vmull_n_u16(vget_low_u16(u), factor), 16);
  return (UShortV)vcombine_u16(low, vshrn_n_u32(vmull_n_u16(vget_high_u16(u), factor), 16));
#else
  for (int k = 0; k < kShorts; ++k) v[k] = static_cast<std::uint16_t>((std::uint32_t{v[k]} * factor) >> 16);
  return v;
#endif
}

/// The same of signed numbers.
inline ShortV highProduct(ShortV v, std::int16_t factor) {
#if defined(__AVX512F__)
  return (ShortV)_mm512_mulhi_epi16((__m512i)v, _mm512_set1_epi16(factor));
#elif defined(__AVX2__)
  return (ShortV)_mm256_mulhi_epi16((__m256i)v, _mm256_set1_epi16(factor));
#elif defined(__SSE2__)
  return (ShortV)_mm_mulhi_epi16((__m128i)v, _mm_set1_epi16(factor));
#elif defined(__ARM_NEON)
  const int16x8_t u = (int16x8_t)v;
  const int16x4_t low = vshrn_n_s32(vmull_n_s16(vget_low_s16(u), factor), 16);
  return (ShortV)vcombine_s16(low, vshrn_n_s32(vmull_n_s16(vget_high_s16(u), factor), 16));
#else
  for (int k = 0; k < kShorts; ++k) v[k] = static_cast<std::int16_t>((std::int32_t{v[k]} * factor) >> 16);
  return v;
#endif
}

}  // namespace
}  // namespace corrsel::core
