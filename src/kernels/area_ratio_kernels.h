#pragma once

// Costs of matches from the areas of triangles with their neighbours. Every lane is a match.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr int kHalfWidth = kWidth / 2;
typedef float HalfFloatV __attribute__((vector_size(kHalfWidth * 4)));
typedef std::int32_t HalfIntV __attribute__((vector_size(kHalfWidth * 4)));
typedef double HalfDoubleV __attribute__((vector_size(kHalfWidth * 8)));

inline FloatV saturate(const SaturationTable& table, FloatV z) {
  const IntV inside = z < static_cast<float>(SaturationTable::kMax);  // false for NaN
  const FloatV place = (inside ? z : FloatV{}) * static_cast<float>(SaturationTable::kPerUnit);
  const IntV index = truncate(place);
  FloatV value{}, step{};
  gatherPairs(table.values, index, value, step);
  value = value + step * (place - toFloat(index));
  return inside ? value : splat(1.0F);
}

/// The vectors of scratch memory: columns of kWidth lanes.
struct AreaRatioScratch {
  float *left_x, *left_y, *right_x, *right_y;  // of the candidates
  float *x, *y;                                // of the neighbours, relative to the match
  float *area, *inverse;                       // of the left image, behind them those of the right one
  float* deviations;

  AreaRatioScratch(const AreaRatioRule& rule, float* memory) {
    const int candidates = rule.candidates, k = rule.neighbours, pairs = k * (k - 1) / 2;
    const auto take = [&memory](int columns) {
      float* const column = memory;
      memory += columns * kWidth;
      return column;
    };
    left_x = take(candidates);
    left_y = take(candidates);
    right_x = take(candidates);
    right_y = take(candidates);
    x = take(2 * k);
    y = take(2 * k);
    area = take(2 * pairs);
    inverse = take(2 * pairs);
    deviations = take(pairs * (k - 2) / 3);
  }
};

/// The agreement of the motion (x, y) with that of a candidate.
inline FloatV agreementOf(FloatV x, FloatV y, FloatV other_x, FloatV other_y, float squared_floor) {
  const FloatV dx = x - other_x, dy = y - other_y, difference = dx * dx + dy * dy;
  const FloatV own = x * x + y * y, other = other_x * other_x + other_y * other_y;
  const FloatV shorter = other < own ? other : own, longer = own < other ? other : own;
  const FloatV dot = x * other_x + y * other_y;
  const FloatV agreement = dot / squareRoot(shorter * longer) / 2.0F + shorter / longer;
  const FloatV small = shorter <= squared_floor ? squareRoot(squared_floor / difference) : agreement;
  return difference <= squared_floor ? splat(1.5F) : small;
}

/// Finds the candidates with the largest agreement; equal ones keep their order.
inline void chooseNeighbours(const AreaRatioScratch& work, const AreaRatioRule& rule, FloatV motion_x,
                             FloatV motion_y, IntV* chosen) {
  FloatV best[AreaRatioRule::kMaxNeighbours];
  const int k = rule.neighbours;
  for (int s = 0; s < rule.candidates; ++s) {
    const FloatV x = load(work.right_x + s * kWidth) - load(work.left_x + s * kWidth);
    const FloatV y = load(work.right_y + s * kWidth) - load(work.left_y + s * kWidth);
    const FloatV agreement = agreementOf(motion_x, motion_y, x, y, rule.squared_floor);
    const IntV number = splat(static_cast<std::int32_t>(s));
    int place = s < k ? s : k - 1;
    IntV moves = s < k ? ~IntV{} : agreement > best[place];
    if (!anyTrue(moves)) continue;
    for (; place > 0; --place) {
      const IntV further = moves & (agreement > best[place - 1]);
      best[place] = further ? best[place - 1] : moves ? agreement : best[place];
      chosen[place] = further ? chosen[place - 1] : moves ? number : chosen[place];
      moves = further;
    }
    best[0] = moves ? agreement : best[0];
    chosen[0] = moves ? number : chosen[0];
  }
}

/// Writes the deviations of all triples of neighbours.
inline void compareAreas(const AreaRatioScratch& work, const AreaRatioRule& rule) {
  const int k = rule.neighbours, pairs = k * (k - 1) / 2;
  for (int image = 0; image < 2; ++image) {
    const float *const x = work.x + image * k * kWidth, *const y = work.y + image * k * kWidth;
    float* area = work.area + image * pairs * kWidth;
    float* inverse = work.inverse + image * pairs * kWidth;
    for (int a = 0; a < k; ++a) {
      const FloatV ax = load(x + a * kWidth), ay = load(y + a * kWidth);
      for (int b = a + 1; b < k; ++b, area += kWidth, inverse += kWidth) {
        const FloatV value = absolute(ax * load(y + b * kWidth) - load(x + b * kWidth) * ay);
        store(area, value);
        store(inverse, 1.0F / value);
      }
    }
  }
  const SaturationTable& table = *rule.saturation;
  const auto first = [k](int a) { return a * k - a * (a + 1) / 2 - a - 1; };  // place of the pair (a, 0)
  const float *const left = work.area, *const right = left + pairs * kWidth;
  const float *const left_inverse = work.inverse, *const right_inverse = left_inverse + pairs * kWidth;
  float* out = work.deviations;
  for (int a = 0; a < k; ++a) {
    for (int b = a + 1; b < k; ++b) {
      const FloatV l1 = load(left + (first(a) + b) * kWidth), r1 = load(right + (first(a) + b) * kWidth);
      for (int c = b + 1; c < k; ++c, out += kWidth) {
        const int bc = (first(b) + c) * kWidth, ac = (first(a) + c) * kWidth;
        // Without an area, the ratio is infinite or NaN, and the deviation 1.
        const FloatV l3 = load(left_inverse + ac), r3 = load(right_inverse + ac);
        store(out, saturate(table, absolute(l1 * load(left_inverse + bc) - r1 * load(right_inverse + bc))) +
                       saturate(table, absolute(l1 * l3 - r1 * r3)) +
                       saturate(table, absolute(load(left + bc) * l3 - load(right + bc) * r3)));
      }
    }
  }
}

/// The mean of the smallest deviations.
inline void meanOfSmallest(const AreaRatioScratch& work, const AreaRatioRule& rule, float* result) {
  const int k = rule.neighbours, count = k * (k - 1) * (k - 2) / 6;
  const std::int32_t kept = rule.kept;
  const auto countWithin = [&work, count](FloatV limit) {
    IntV within = {};
    for (int t = 0; t < count; ++t) within -= load(work.deviations + t * kWidth) <= limit;
    return within;
  };
  // At least `kept` deviations are at most `high`, and no more of them at most `low`, unless that is 0.
  FloatV low = {};
  IntV below = countWithin(low);  // deviations that are at most `low`
  FloatV high = below >= kept ? low : splat(3.0F);
  for (;;) {
    const FloatV middle = low + (high - low) * 0.5F;
    const IntV open = (middle > low) & (middle < high);
    if (!anyTrue(open)) break;
    const IntV within = countWithin(middle);
    const IntV raises = open & (within <= kept), lowers = open & (within >= kept);
    low = raises ? middle : low;
    below = raises ? within : below;
    high = lowers ? middle : high;
  }
  // All deviations between both are equal to `high`.
  for (int half = 0; half < 2; ++half) {
    HalfFloatV most, equal;
    HalfIntV smaller;
    __builtin_memcpy(&most, (const char*)&low + half * sizeof most, sizeof most);
    __builtin_memcpy(&equal, (const char*)&high + half * sizeof equal, sizeof equal);
    __builtin_memcpy(&smaller, (const char*)&below + half * sizeof smaller, sizeof smaller);
    HalfDoubleV sum = {};
    for (int t = 0; t < count; ++t) {
      HalfFloatV deviation;
      __builtin_memcpy(&deviation, work.deviations + t * kWidth + half * kHalfWidth, sizeof deviation);
      sum += __builtin_convertvector(deviation <= most ? deviation : HalfFloatV{}, HalfDoubleV);
    }
    sum += __builtin_convertvector(equal, HalfDoubleV) * __builtin_convertvector(kept - smaller, HalfDoubleV);
    const HalfFloatV mean = __builtin_convertvector(sum / static_cast<double>(kept), HalfFloatV);
    __builtin_memcpy(result + half * kHalfWidth, &mean, sizeof mean);
  }
}

void areaRatioKernel(const MatchColumns& m, const std::uint32_t* lists, std::size_t stride,
                     const AreaRatioRule& rule, float* scratch, float* costs) {
  const AreaRatioScratch work(rule, scratch);
  const int k = rule.neighbours;
  for (std::size_t begin = 0; begin < m.size; begin += kWidth) {
    float own[4][kWidth];
    std::size_t match[kWidth];
    for (int lane = 0; lane < kWidth; ++lane) {
      // The lanes behind the last match repeat it.
      const std::size_t i = begin + static_cast<std::size_t>(lane);
      match[lane] = i < m.size ? i : m.size - 1;
      own[0][lane] = m.left_x[match[lane]];
      own[1][lane] = m.left_y[match[lane]];
      own[2][lane] = m.right_x[match[lane]];
      own[3][lane] = m.right_y[match[lane]];
      const std::uint32_t* const list = lists + match[lane] * stride;
      for (int s = 0; s < rule.candidates; ++s) {
        work.left_x[s * kWidth + lane] = m.left_x[list[s]];
        work.left_y[s * kWidth + lane] = m.left_y[list[s]];
        work.right_x[s * kWidth + lane] = m.right_x[list[s]];
        work.right_y[s * kWidth + lane] = m.right_y[list[s]];
      }
    }
    const FloatV left_x = load(own[0]), left_y = load(own[1]);
    const FloatV right_x = load(own[2]), right_y = load(own[3]);
    IntV chosen[AreaRatioRule::kMaxNeighbours];
    chooseNeighbours(work, rule, right_x - left_x, right_y - left_y, chosen);
    const IntV lanes = laneNumbers();
    for (int a = 0; a < k; ++a) {
      const IntV at = chosen[a] * kWidth + lanes;
      store(work.x + a * kWidth, gather(work.left_x, at) - left_x);
      store(work.y + a * kWidth, gather(work.left_y, at) - left_y);
      store(work.x + (k + a) * kWidth, gather(work.right_x, at) - right_x);
      store(work.y + (k + a) * kWidth, gather(work.right_y, at) - right_y);
    }
    compareAreas(work, rule);
    float means[kWidth];
    meanOfSmallest(work, rule, means);
    for (int lane = 0; lane < kWidth; ++lane) costs[match[lane]] = means[lane];
  }
}

}  // namespace
}  // namespace corrsel::core
