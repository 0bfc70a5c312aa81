#pragma once

// Errors of homographies and fundamental matrices in double precision, by which matches are selected.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr int kPixelWidth = kWidth / 2;
typedef float PixelFloatV __attribute__((vector_size(kPixelWidth * 4)));
typedef double PixelV __attribute__((vector_size(kPixelWidth * 8)));

inline PixelV loadPixels(const float* p) {
  PixelFloatV v;
  __builtin_memcpy(&v, p, sizeof v);
  return __builtin_convertvector(v, PixelV);
}

/// The operations of homographyError().
struct PixelTransfer {
  template <class T>
  static T error(const double* h, T x, T y, T u, T v) {
    const T w = h[6] * x + h[7] * y + h[8];
    const T inverse = 1.0 / w;
    const T dx = (h[0] * x + h[1] * y + h[2]) * inverse - u;
    const T dy = (h[3] * x + h[4] * y + h[5]) * inverse - v;
    return w > 0.0 ? dx * dx + dy * dy : __builtin_inf() - T{};
  }
};

/// The operations of sampsonError().
struct PixelSampson {
  template <class T>
  static T error(const double* f, T x, T y, T u, T v) {
    const T a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5];
    const T c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
    const T residual = u * a + v * b + f[6] * x + f[7] * y + f[8];
    const T gradient = a * a + b * b + c * c + d * d;
    const T at_epipole = residual == 0.0 ? T{} : __builtin_inf() - T{};
    return gradient == 0.0 ? at_epipole : residual * residual / gradient;
  }
};

template <class Error>
void pixelErrorsKernel(const double* model, const MatchColumns& m, std::size_t begin, std::size_t end,
                       double* out) {
  double h[9];  // which `out` cannot change
  for (int k = 0; k < 9; ++k) h[k] = model[k];
  std::size_t i = begin;
  for (; i + kPixelWidth <= end; i += kPixelWidth) {
    const PixelV error = Error::template error<PixelV>(h, loadPixels(m.left_x + i), loadPixels(m.left_y + i),
                                                       loadPixels(m.right_x + i), loadPixels(m.right_y + i));
    __builtin_memcpy(out + (i - begin), &error, sizeof error);
  }
  for (; i < end; ++i) {
    out[i - begin] =
        Error::template error<double>(h, static_cast<double>(m.left_x[i]), static_cast<double>(m.left_y[i]),
                                      static_cast<double>(m.right_x[i]), static_cast<double>(m.right_y[i]));
  }
}

}  // namespace
}  // namespace corrsel::core
