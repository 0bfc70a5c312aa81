#pragma once

#include <vector>

namespace corrsel::core {

/// Maps grey values: gain * value + offset.
struct Brightness {
  double gain = 1, offset = 0;

  double operator()(double value) const { return gain * value + offset; }
};

/// The map that makes values of a new image look like the expected ones.
///
/// Algorithm: Least squares twice, the second time without the values that are off by more than three times
/// the median. The result replaces `current` only where it halves the median difference, since values that
/// are wrong for another reason would flatten the image.
///
/// Failure: `current` with fewer than 20 values, where the median difference is below half a grey level, and
/// where the gain would leave [1/4, 4].
///
/// Cost: O(values log values).
///
/// @param values    means of patches of the new image
/// @param expected  of the same patches, as many
Brightness fitBrightness(const std::vector<double>& values, const std::vector<double>& expected,
                         const Brightness& current);

}  // namespace corrsel::core
