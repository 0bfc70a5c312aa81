#pragma once

// The distortion of lenses, for kernels and for the code that calls them. T is double or a vector of doubles:
// both round alike. Everything has internal linkage for the reason that simd.h states.

namespace corrsel::core {

/// What the kernels need of a camera.
struct LensModel {
  double inverse_fx, inverse_fy, skew, cx, cy;  ///< of K; of a panorama 1/width and 1/height only
  double distortion[8];                         ///< as in Camera
  /// Where the distortion has its first turning point: r^2 = x^2 + y^2 of a pinhole, +Inf without one; of a
  /// fisheye lens the angle from the axis, rad, at most pi.
  double limit;
};

namespace {

/// A distorted point, and the symmetric matrix of its derivatives by the point.
template <class T>
struct DistortedPoint {
  T x, y, xx, xy, yy;

  T determinant() const { return xx * yy - xy * xy; }
  T trace() const { return xx + yy; }
};

/// Distorts the point (x, y, 1) as cv::projectPoints does.
/// @tparam Rational  with the denominator k4 k5 k6, otherwise without it
template <bool Rational, class T>
inline DistortedPoint<T> distortPinhole(const double (&k)[8], T x, T y) {
  const T xx = x * x, xy = x * y, yy = y * y, r2 = xx + yy;
  T factor = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  T slope = k[0] + r2 * (2.0 * k[1] + r2 * (3.0 * k[4]));  // by r2
  if (Rational) {
    const T inverse = 1.0 / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    factor = factor * inverse;
    slope = (slope - factor * (k[5] + r2 * (2.0 * k[6] + r2 * (3.0 * k[7])))) * inverse;
  }
  const double p1 = 2.0 * k[2], p2 = 2.0 * k[3];
  const T tangential = factor + p1 * y + p2 * x;
  const T twice = slope + slope;
  return {x * tangential + k[3] * r2, y * tangential + k[2] * r2, tangential + twice * xx + 2.0 * p2 * x,
          twice * xy + p1 * x + p2 * y, tangential + twice * yy + 2.0 * p1 * y};
}

/// The image's distance from the centre, in focal lengths, at an angle from the axis, and its derivative.
template <class T>
struct FisheyeRadius {
  T value, slope;
};

template <class T>
inline FisheyeRadius<T> fisheyeRadius(const double (&k)[8], T angle) {
  const T s = angle * angle;
  return {angle * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))),
          1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * (9.0 * k[3]))))};
}

}  // namespace

/// Where the slopes of the distortion are below this, it counts as turned.
constexpr double kSmallestSlope = 1e-6;

}  // namespace corrsel::core
