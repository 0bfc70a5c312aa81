#include "corrsel/random.h"

namespace corrsel::core {
namespace {

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

double Random::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

double Random::normal() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

void Random::shuffle(std::vector<std::uint32_t>& values) {
  for (std::size_t i = values.size(); i > 1; --i)
    std::swap(values[i - 1], values[index(static_cast<std::uint32_t>(i))]);
}

void Random::sample(std::uint32_t bound, std::size_t count, std::uint32_t* out) {
  // Where equal draws are rare it is quickest to draw again.
  constexpr std::uint32_t kRare = 64;
  if (bound / kRare > count) {
    for (std::size_t i = 0; i < count;) {
      out[i] = index(bound);
      bool taken = false;
      for (std::size_t k = 0; k < i; ++k) taken = taken || out[k] == out[i];
      i += taken ? 0 : 1;
    }
    return;
  }
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
