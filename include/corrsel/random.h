#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Seeded pseudo-random engine (xoshiro256++ 1.0 by Blackman and Vigna, seeded through splitmix64).
/// Uses integer arithmetic and exactly rounded operations only, so the numbers are the same on every platform
/// and with every standard library, which std::uniform_int_distribution and friends do not promise.
class Random {
 public:
  explicit Random(std::uint64_t seed = 0);

  /// 64 uniformly distributed bits.
  std::uint64_t next() {
    const std::uint64_t result = rotateLeft(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = rotateLeft(state_[3], 45);
    return result;
  }

  /// Uniform in [0, bound), without modulo bias (Lemire 2019). @pre bound > 0
  std::uint32_t index(std::uint32_t bound) {
    std::uint64_t product = (next() >> 32) * bound;
    std::uint32_t low = static_cast<std::uint32_t>(product);
    if (low < bound) {
      const std::uint32_t threshold = (0U - bound) % bound;
      while (low < threshold) {
        product = (next() >> 32) * bound;
        low = static_cast<std::uint32_t>(product);
      }
    }
    return static_cast<std::uint32_t>(product >> 32);
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform();

  /// Uniform in [low, high).
  double uniform(double low, double high);

  /// Approximately standard normal: the sum of 12 uniforms minus 6 (tails end at +-6), free of libm.
  double normal();

  /// Draws `count` distinct indices from [0, bound), in any order. @pre count <= bound. O(count^2), meant for
  /// small samples.
  void sample(std::uint32_t bound, std::size_t count, std::uint32_t* out);

  /// Puts the values in random order. O(n).
  void shuffle(std::vector<std::uint32_t>& values);

 private:
  static std::uint64_t rotateLeft(std::uint64_t value, int bits) {
    return (value << bits) | (value >> (64 - bits));
  }

  std::uint64_t state_[4];
};

}  // namespace corrsel::core
