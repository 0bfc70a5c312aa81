#include "features/parts/affine_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

/// Positions of samples in px of a level: the centre, and the steps along rows and columns of the patch.
struct Placement {
  double x, y, across_x, across_y, down_x, down_y;
};

std::int32_t fixedPoint(double px) { return static_cast<std::int32_t>(std::lrint(px * 65536)); }

Placement placementOf(const ScaleLevel& level, const AffineFrame& frame, double spacing) {
  const double scale = spacing / level.step;
  Placement place;
  place.x = (frame[2] - level.offset) / level.step;
  place.y = (frame[5] - level.offset) / level.step;
  place.across_x = frame[0] * scale;
  place.across_y = frame[3] * scale;
  place.down_x = frame[1] * scale;
  place.down_y = frame[4] * scale;
  return place;
}

/// Where samples lie. kLarge: the image or the frame is too large for the positions of the kernels.
enum class Range { kInside, kBorder, kLarge };

Range gridOf(const ScaleLevel& level, const Placement& place, PatchGrid& grid) {
  constexpr int kHalf = Patch::kHalf, kMax = PatchGrid::kMax;
  const double reach_x = kHalf * (std::abs(place.across_x) + std::abs(place.down_x));
  const double reach_y = kHalf * (std::abs(place.across_y) + std::abs(place.down_y));
  const bool inside = place.x - reach_x >= 1 && place.y - reach_y >= 1 &&
                      place.x + reach_x < level.width - 2 && place.y + reach_y < level.height - 2;
  // Positions are relative to a pixel nearby, or to the first pixel where they are clamped.
  const int origin_x = inside ? static_cast<int>(place.x - reach_x) - 1 : 0;
  const int origin_y = inside ? static_cast<int>(place.y - reach_y) - 1 : 0;
  const double x = place.x - origin_x, y = place.y - origin_y;
  // Written such that a frame that is not finite is large.
  const bool small = std::abs(x) + 2 * reach_x < kMax && std::abs(y) + 2 * reach_y < kMax &&
                     level.stride < kMax && (inside || (level.width < kMax && level.height < kMax));
  if (!small) return Range::kLarge;
  grid.pixels = level.pixels + origin_y * level.stride + origin_x;
  grid.stride = level.stride;
  grid.width = level.width;
  grid.height = level.height;
  grid.across_x = fixedPoint(place.across_x);
  grid.across_y = fixedPoint(place.across_y);
  grid.down_x = fixedPoint(place.down_x);
  grid.down_y = fixedPoint(place.down_y);
  grid.x = fixedPoint(x) - kHalf * (grid.across_x + grid.down_x);
  grid.y = fixedPoint(y) - kHalf * (grid.across_y + grid.down_y);
  return inside ? Range::kInside : Range::kBorder;
}

/// The same samples as the kernels', for images and frames that are too large for their positions.
int sampleLarge(const ScaleLevel& level, const Placement& place, Patch& patch) {
  int outside = 0;
  for (int r = 0; r < Patch::kSide; ++r) {
    float* const row = patch.values + std::ptrdiff_t{r} * Patch::kPitch;
    for (int c = 0; c < Patch::kSide; ++c) {
      const double i = c - Patch::kHalf, j = r - Patch::kHalf;
      const double x = place.x + i * place.across_x + j * place.down_x;
      const double y = place.y + i * place.across_y + j * place.down_y;
      const double px = std::clamp(x, 0.0, level.width - 1.0), py = std::clamp(y, 0.0, level.height - 1.0);
      outside += px == x && py == y ? 0 : 1;
      // In the last column and row the pixel before has the weight 0.
      const int left = std::min(static_cast<int>(px), level.width - 2);
      const int top = std::min(static_cast<int>(py), level.height - 2);
      const std::int16_t* const upper = level.pixels + top * level.stride + left;
      const std::int16_t* const lower = upper + level.stride;
      const double u = px - left, v = py - top;
      row[c] = static_cast<float>(
          ((1 - v) * ((1 - u) * upper[0] + u * upper[1]) + v * ((1 - u) * lower[0] + u * lower[1])) /
          kGreyUnit);
    }
    std::fill(row + Patch::kSide, row + Patch::kPitch, row[Patch::kSide - 1]);
  }
  std::fill_n(patch.values + std::ptrdiff_t{Patch::kSide} * Patch::kPitch, Patch::kBeyond, 0.0F);
  return outside;
}

}  // namespace

const ScaleLevel& levelFor(const std::vector<ScaleLevel>& levels, double sigma) {
  const auto next =
      std::upper_bound(levels.begin() + 1, levels.end(), sigma,
                       [](double value, const ScaleLevel& level) { return value < level.sigma; });
  return *(next - 1);
}

HalfAxes halfAxes(const AffineFrame& a) {
  const double sum = std::hypot(double{a[0]} + a[4], double{a[3]} - a[1]) / 2;
  const double difference = std::hypot(double{a[0]} - a[4], double{a[3]} + a[1]) / 2;
  return {std::abs(sum - difference), sum + difference};
}

int samplePatch(const ScaleLevel& level, const AffineFrame& frame, double spacing, Patch& patch) {
  const Placement place = placementOf(level, frame, spacing);
  PatchGrid grid;
  switch (gridOf(level, place, grid)) {
    case Range::kInside:
      kernels().patches.sample(grid, patch);
      return 0;
    case Range::kBorder:
      return kernels().patches.sample_clamped(grid, patch);
    case Range::kLarge:
      break;
  }
  return sampleLarge(level, place, patch);
}

void filterPatch(const ScaleLevel& level, const AffineFrame& frame, double spacing,
                 const PatchFilters& filters, float* sums) {
  PatchGrid grid;
  if (gridOf(level, placementOf(level, frame, spacing), grid) == Range::kInside &&
      grid.across_x <= PatchKernels::kMaxUpright &&
      level.stride - level.width >= PatchKernels::kUprightSlack) {
    kernels().patches.filter_upright(grid, filters, sums);
    return;
  }
  Patch patch;
  samplePatch(level, frame, spacing, patch);
  kernels().patches.filter(patch, filters, sums);
}

PatchWeights gaussianWindow(double sigma) {
  PatchWeights weights = {};
  constexpr int kMiddle = Patch::kInner / 2;
  for (int r = 0; r < Patch::kInner; ++r) {
    for (int c = 0; c < Patch::kInner; ++c) {
      const int distance2 = (r - kMiddle) * (r - kMiddle) + (c - kMiddle) * (c - kMiddle);
      weights.values[r * Patch::kPitch + c] = static_cast<float>(std::exp(-distance2 / (2 * sigma * sigma)));
    }
  }
  return weights;
}

}  // namespace corrsel::core
