#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// A square patch of an image, row by row in blocks of 32 bytes. Bytes beyond its side may be read.
struct BytePatch {
  static constexpr int kBlock = 32;

  const std::uint8_t* first;  ///< its upper left pixel
  std::ptrdiff_t stride;
  int side;    ///< px
  int blocks;  ///< per row: side / kBlock, rounded up
};

/// First moments, relative to the place where the weights are 0.
struct Moments {
  std::int32_t x, y;
};

/// The loops of oriented patches that are compared pixel by pixel.
struct BinaryKernels {
  /// Sums of the pixels with weights from -63 to 63 per pixel; [row][block][32] weights each.
  Moments (*moments)(const BytePatch& patch, const std::int8_t* x_weights, const std::int8_t* y_weights);

  /// 256 comparisons of two pixels: bit i % 8 of byte i / 8 is set where the first is darker than the second.
  /// @param places  first and second pixel of every test, alternating: row * 32 blocks + column
  /// @param copy    scratch: side * 32 blocks bytes
  void (*tests)(const BytePatch& patch, const std::uint16_t* places, std::uint8_t* copy, std::uint8_t* out);
};

}  // namespace corrsel::core
