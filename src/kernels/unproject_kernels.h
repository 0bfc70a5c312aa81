#pragma once

// Unit rays of pixels, one pixel per lane. Lanes do not depend on each other, so that the ray of one pixel
// has the same bits as among many.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr double kPi = 3.141592653589793;

/// Adding it leaves the nearest whole number of |x| < 2^51 in the lowest bits.
constexpr double kToWhole = 0x1.8p52;

struct SineCosine {
  DoubleV sine, cosine;
};

/// Sine and cosine of |x| <= 4, within about 1 ulp.
inline SineCosine sineCosine(DoubleV x) {
  // pi/2 in two parts; the first has so few bits that its multiples are exact.
  constexpr double kHalfPiHigh = 0x1.921fb544p0, kHalfPiLow = 0x1.0b4611a626331p-34;
  const DoubleV shifted = x * (2.0 / kPi) + kToWhole;
  const DoubleV quarters = shifted - kToWhole;
  const DoubleV r = (x - quarters * kHalfPiHigh) - quarters * kHalfPiLow;
  // Taylor's series: |r| <= pi/4 makes the first terms left out 1e-19 and 3e-18.
  const DoubleV s = r * r;
  DoubleV sine = s * (1.0 / 355687428096000.0) - 1.0 / 1307674368000.0;
  DoubleV cosine = s * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0;
  sine = sine * s + 1.0 / 6227020800.0;
  cosine = cosine * s + 1.0 / 479001600.0;
  sine = sine * s - 1.0 / 39916800.0;
  cosine = cosine * s - 1.0 / 3628800.0;
  sine = sine * s + 1.0 / 362880.0;
  cosine = cosine * s + 1.0 / 40320.0;
  sine = sine * s - 1.0 / 5040.0;
  cosine = cosine * s - 1.0 / 720.0;
  sine = sine * s + 1.0 / 120.0;
  cosine = cosine * s + 1.0 / 24.0;
  sine = sine * s - 1.0 / 6.0;
  sine = r + r * (s * sine);
  cosine = 1.0 - (0.5 * s - s * s * cosine);
  const LongV quadrant = (LongV)shifted;
  const LongV odd = -(quadrant & 1);
  const DoubleV a = odd ? cosine : sine, b = odd ? sine : cosine;
  return {(DoubleV)((LongV)a ^ (quadrant & 2) << 62), (DoubleV)((LongV)b ^ ((quadrant + 1) & 2) << 62)};
}

/// Columns as in Rays, and whether there is a ray.
struct RayLanes {
  DoubleV value[9];
  LongV exists;
};

/// The point of the image plane at distance 1 from a pinhole that has no distortion.
inline void normalise(const LensModel& lens, DoubleV u, DoubleV v, DoubleV& x, DoubleV& y) {
  y = (v - lens.cy) * lens.inverse_fy;
  x = (u - lens.cx - lens.skew * y) * lens.inverse_fx;
}

/// Writes the Jacobian by the pixel. @param a,b  derivatives of the ray by the normalised coordinates
inline void setJacobian(const LensModel& lens, const DoubleV (&a)[3], const DoubleV (&b)[3], RayLanes& rays) {
  const double skewed = -lens.skew * lens.inverse_fx * lens.inverse_fy;
  for (int row = 0; row < 3; ++row) {
    rays.value[3 + 2 * row] = a[row] * lens.inverse_fx;
    rays.value[4 + 2 * row] = a[row] * skewed + b[row] * lens.inverse_fy;
  }
}

/// The ray through (x, y, 1). @param inverse  of the symmetric Jacobian of the distortion: xx, xy, yy
inline void setPinholeRay(const LensModel& lens, DoubleV x, DoubleV y, const DoubleV (&inverse)[3],
                          RayLanes& rays) {
  const DoubleV scale = 1.0 / squareRoot(x * x + y * y + 1.0);
  const DoubleV dx = x * scale, dy = y * scale, dz = scale;
  const DoubleV cross = -(dx * dy) * scale;
  const DoubleV by_x[3] = {(1.0 - dx * dx) * scale, cross, -(dz * dx) * scale};
  const DoubleV by_y[3] = {cross, (1.0 - dy * dy) * scale, -(dz * dy) * scale};
  DoubleV a[3], b[3];
  for (int row = 0; row < 3; ++row) {
    a[row] = by_x[row] * inverse[0] + by_y[row] * inverse[1];
    b[row] = by_x[row] * inverse[1] + by_y[row] * inverse[2];
  }
  rays.value[0] = dx;
  rays.value[1] = dy;
  rays.value[2] = dz;
  setJacobian(lens, a, b, rays);
}

struct PlainPinholeLens {
  static RayLanes rays(const LensModel& lens, DoubleV u, DoubleV v) {
    RayLanes rays;
    DoubleV x, y;
    normalise(lens, u, v, x, y);
    rays.exists = x == x;
    const DoubleV zero = {}, one = zero + 1.0, identity[3] = {one, zero, one};
    setPinholeRay(lens, x, y, identity, rays);
    return rays;
  }
};

/// Newton's method. A step to where the distortion has turned means that the point has no ray.
template <bool Rational>
struct PinholeLens {
  static RayLanes rays(const LensModel& lens, DoubleV u, DoubleV v) {
    constexpr int kMaxSteps = 20;
    constexpr double kSmallestSquaredStep = 1e-24;
    RayLanes rays;
    DoubleV given_x, given_y;
    normalise(lens, u, v, given_x, given_y);
    DoubleV x = given_x, y = given_y;
    pullInside(lens, x, y);
    DoubleV inverse[3] = {};
    LongV moving = x == x, valid = moving;
    for (int step = 0; step < kMaxSteps && anyTrue((IntV)moving); ++step) {
      const DistortedPoint<DoubleV> p = distortPinhole<Rational>(lens.distortion, x, y);
      const DoubleV determinant = p.determinant();
      valid &= ~moving | ((determinant > kSmallestSlope) & (p.trace() > 0.0));
      moving &= valid;
      const DoubleV scale = 1.0 / determinant;
      const DoubleV entries[3] = {p.yy * scale, -(p.xy * scale), p.xx * scale};
      for (int k = 0; k < 3; ++k) inverse[k] = moving ? entries[k] : inverse[k];
      const DoubleV ex = p.x - given_x, ey = p.y - given_y;
      const DoubleV dx = inverse[0] * ex + inverse[1] * ey, dy = inverse[1] * ex + inverse[2] * ey;
      x = moving ? x - dx : x;
      y = moving ? y - dy : y;
      moving &= dx * dx + dy * dy > kSmallestSquaredStep;
    }
    rays.exists = valid & ~moving & (x * x + y * y < lens.limit);
    setPinholeRay(lens, x, y, inverse, rays);
    return rays;
  }

 private:
  /// Moves a distorted point, which is the start, to where the distortion has not turned: it may lie farther
  /// out than any point that has an image.
  static void pullInside(const LensModel& lens, DoubleV& x, DoubleV& y) {
    const double limit = 0.8 * lens.limit;
    const DoubleV squared = x * x + y * y;
    const LongV outside = squared > limit;
    if (!anyTrue((IntV)outside)) return;
    const DoubleV scale = outside ? squareRoot(limit / squared) : DoubleV{} + 1.0;
    x = x * scale;
    y = y * scale;
  }
};

struct FisheyeLens {
  static RayLanes rays(const LensModel& lens, DoubleV u, DoubleV v) {
    RayLanes rays;
    DoubleV x, y;
    normalise(lens, u, v, x, y);
    const DoubleV squared = x * x + y * y;
    const LongV off_axis = ~(squared <= 1e-300);  // of NaN, too
    const DoubleV radius = off_axis ? squareRoot(squared) : DoubleV{};
    const DoubleV inverse = 1.0 / (off_axis ? radius : DoubleV{} + 1.0);
    const DoubleV ux = off_axis ? x * inverse : DoubleV{} + 1.0, uy = off_axis ? y * inverse : DoubleV{};
    DoubleV slope;
    const DoubleV angle = solve(lens, radius, slope, rays.exists);
    const SineCosine at = sineCosine(angle);
    const DoubleV radial = 1.0 / slope, tangential = off_axis ? at.sine * inverse : DoubleV{} + 1.0;
    rays.value[0] = at.sine * ux;
    rays.value[1] = at.sine * uy;
    rays.value[2] = at.cosine;
    const DoubleV rx = at.cosine * ux * radial, ry = at.cosine * uy * radial, rz = -(at.sine * radial);
    const DoubleV tx = -(uy * tangential), ty = ux * tangential;
    setJacobian(lens, {rx * ux - tx * uy, ry * ux - ty * uy, rz * ux},
                {rx * uy + tx * ux, ry * uy + ty * ux, rz * uy}, rays);
    return rays;
  }

 private:
  /// The angle from the axis, by Newton's method within [0, limit], where the radius only grows.
  static DoubleV solve(const LensModel& lens, DoubleV radius, DoubleV& slope, LongV& exists) {
    constexpr int kMaxSteps = 60;
    constexpr double kSmallestStep = 1e-12;
    DoubleV low = {}, high = DoubleV{} + lens.limit;
    const FisheyeRadius<double> largest = fisheyeRadius(lens.distortion, lens.limit);
    exists = radius < largest.value;
    DoubleV angle = radius < high ? radius : high;
    slope = DoubleV{} + 1.0;
    LongV moving = exists;
    for (int step = 0; step < kMaxSteps && anyTrue((IntV)moving); ++step) {
      const FisheyeRadius<DoubleV> at = fisheyeRadius(lens.distortion, angle);
      const DoubleV error = at.value - radius;
      slope = moving ? at.slope : slope;
      low = error > 0.0 ? low : angle;
      high = error > 0.0 ? angle : high;
      DoubleV next = angle - error / slope;
      const LongV inside = (next >= low) & (next <= high);
      next = inside ? next : 0.5 * (low + high);
      const DoubleV moved = absolute(next - angle);
      angle = moving ? next : angle;
      moving &= moved > kSmallestStep;
    }
    exists &= ~moving & (slope > kSmallestSlope) & (angle < lens.limit);
    return angle;
  }
};

struct EquirectangularLens {
  static RayLanes rays(const LensModel& lens, DoubleV u, DoubleV v) {
    constexpr double kFarthest = 1e6;  // turns, which leaves the longitude exact to 1e-9
    RayLanes rays;
    DoubleV turns = (u + 0.5) * lens.inverse_fx - 0.5;
    const DoubleV half_turns = (v + 0.5) * lens.inverse_fy - 0.5;
    rays.exists = (absolute(turns) < kFarthest) & (absolute(half_turns) <= 0.5);
    turns = rays.exists ? turns : DoubleV{};
    turns = turns - ((turns + kToWhole) - kToWhole);
    const SineCosine longitude = sineCosine(turns * (2.0 * kPi));
    const SineCosine latitude = sineCosine((rays.exists ? half_turns : DoubleV{}) * kPi);
    const double by_u = 2.0 * kPi * lens.inverse_fx, by_v = kPi * lens.inverse_fy;
    rays.value[0] = latitude.cosine * longitude.sine;
    rays.value[1] = latitude.sine;
    rays.value[2] = latitude.cosine * longitude.cosine;
    rays.value[3] = rays.value[2] * by_u;
    rays.value[4] = -(latitude.sine * longitude.sine) * by_v;
    rays.value[5] = DoubleV{};
    rays.value[6] = latitude.cosine * by_v;
    rays.value[7] = -(rays.value[0] * by_u);
    rays.value[8] = -(latitude.sine * longitude.cosine) * by_v;
    return rays;
  }
};

/// The rays of one vector of pixels, NaN where there is none. A ray exists only if its numbers are finite.
template <class L>
inline RayLanes raysOf(const LensModel& lens, const double* x, const double* y) {
  RayLanes rays = L::rays(lens, load(x), load(y));
  DoubleV sum = {};
  for (const DoubleV& value : rays.value) sum += value * value;
  const DoubleV length =
      rays.value[0] * rays.value[0] + rays.value[1] * rays.value[1] + rays.value[2] * rays.value[2];
  // Lengths are other than 1 where coordinates overflowed on the way.
  rays.exists &= (sum <= __DBL_MAX__) & (length > 0.5);
  for (DoubleV& value : rays.value) value = rays.exists ? value : DoubleV{} + __builtin_nan("");
  return rays;
}

template <class L>
std::size_t unprojectKernel(const LensModel& lens, const double* x, const double* y, std::size_t n,
                            double* const* columns) {
  LongV existing = {};
  std::size_t i = 0;
  for (; i + kDoubleWidth <= n; i += kDoubleWidth) {
    const RayLanes rays = raysOf<L>(lens, x + i, y + i);
    for (int k = 0; k < 9; ++k) store(columns[k] + i, rays.value[k]);
    existing -= rays.exists;
  }
  const std::size_t left = n - i;
  if (left > 0) {
    double last_x[kDoubleWidth] = {}, last_y[kDoubleWidth] = {}, column[kDoubleWidth];
    for (std::size_t k = 0; k < left; ++k) {
      last_x[k] = x[i + k];
      last_y[k] = y[i + k];
    }
    const RayLanes rays = raysOf<L>(lens, last_x, last_y);
    for (int c = 0; c < 9; ++c) {
      store(column, rays.value[c]);
      for (std::size_t k = 0; k < left; ++k) columns[c][i + k] = column[k];
    }
    for (std::size_t k = 0; k < left; ++k) existing[0] -= rays.exists[k];
  }
  std::size_t count = 0;
  for (int k = 0; k < kDoubleWidth; ++k) count += static_cast<std::size_t>(existing[k]);
  return n - count;
}

}  // namespace
}  // namespace corrsel::core
