#include "corrsel/random.h"

namespace corrsel::core {
namespace {

std::uint64_t rotateLeft(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = splitmix64(seed);
}

std::uint64_t Random::next() {
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

std::uint32_t Random::index(std::uint32_t bound) {
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

double Random::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

double Random::normal() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

void Random::sample(std::uint32_t bound, std::size_t count, std::uint32_t* out) {
  for (std::size_t i = 0; i < count; ++i) {
    // Draw a rank among the free indices, then step over the ones taken, which are kept sorted in out[0..i).
    std::uint32_t value = index(bound - static_cast<std::uint32_t>(i));
    std::size_t position = 0;
    while (position < i && out[position] <= value) {
      ++value;
      ++position;
    }
    for (std::size_t j = i; j > position; --j) out[j] = out[j - 1];
    out[position] = value;
  }
}

}  // namespace corrsel::core
