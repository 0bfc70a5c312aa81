#include "reference/hypothesis_affinity.h"

#include <algorithm>

namespace corrsel::core {
namespace {

/// Number of bits of each byte, as a byte.
std::uint64_t bitsOfBytes(std::uint64_t x) {
  x -= (x >> 1) & 0x5555555555555555U;
  x = (x & 0x3333333333333333U) + ((x >> 2) & 0x3333333333333333U);
  return (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fU;
}

std::uint64_t sumOfBytes(std::uint64_t x) { return (x * 0x0101010101010101U) >> 56; }

}  // namespace

void HypothesisAffinity::start(std::size_t matches) {
  static_assert(kHead * kBlocks < 256, "the sum of a byte must not overflow");
  matches_ = matches;
  filled_ = closed_ = 0;
  errors_.resize(kBlock * matches);
  remembered_.assign(kBlocks * matches, 0);
  weights_.resize(matches);
}

void HypothesisAffinity::add() {
  if (++filled_ == kBlock) closeBlock();
}

void HypothesisAffinity::closeBlock() {
  std::uint64_t* const words = remembered_.data() + closed_ % kBlocks * matches_;
  for (std::size_t i = 0; i < matches_; ++i) {
    float smallest[kHead];
    std::uint8_t hypothesis[kHead];
    std::size_t count = 0;
    for (std::size_t h = 0; h < kBlock; ++h) {
      const float error = errors_[h * matches_ + i];
      if (count == kHead && !(error < smallest[kHead - 1])) continue;
      std::size_t k = count < kHead ? count++ : kHead - 1;
      for (; k > 0 && error < smallest[k - 1]; --k) {
        smallest[k] = smallest[k - 1];
        hypothesis[k] = hypothesis[k - 1];
      }
      smallest[k] = error;
      hypothesis[k] = static_cast<std::uint8_t>(h);
    }
    words[i] = 0;
    for (const std::uint8_t h : hypothesis) words[i] |= std::uint64_t{1} << h;
  }
  ++closed_;
  filled_ = 0;
}

std::uint32_t HypothesisAffinity::affinity(std::uint32_t a, std::uint32_t b) const {
  std::uint64_t bytes = 0;
  for (std::size_t block = 0; block < kBlocks; ++block) {
    const std::uint64_t* const words = remembered_.data() + block * matches_;
    bytes += bitsOfBytes(words[a] & words[b]);
  }
  return static_cast<std::uint32_t>(sumOfBytes(bytes));
}

void HypothesisAffinity::multiplyByAffinity(std::uint32_t member) {
  constexpr std::size_t kTile = 256;  // matches whose words are counted together, by vector instructions
  const std::size_t blocks = std::min(closed_, kBlocks);
  std::uint64_t bytes[kTile];
  for (std::size_t begin = 0; begin < matches_; begin += kTile) {
    const std::size_t count = std::min(kTile, matches_ - begin);
    std::fill_n(bytes, count, std::uint64_t{0});
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::uint64_t* const words = remembered_.data() + block * matches_;
      const std::uint64_t of_member = words[member];
      for (std::size_t k = 0; k < count; ++k) bytes[k] += bitsOfBytes(words[begin + k] & of_member);
    }
    for (std::size_t k = 0; k < count; ++k) {
      // As a 32-bit number, which converts faster.
      weights_[begin + k] *= static_cast<double>(static_cast<std::int32_t>(sumOfBytes(bytes[k])));
    }
  }
  weights_[member] = 0;
}

void HypothesisAffinity::draw(Random& random, std::size_t sample_size, std::uint32_t* sample) {
  const auto n = static_cast<std::uint32_t>(matches_);
  if (closed_ == 0) {
    random.sample(n, sample_size, sample);
    return;
  }
  std::fill(weights_.begin(), weights_.end(), 1.0);
  sample[0] = random.index(n);
  for (std::size_t k = 1; k < sample_size; ++k) {
    multiplyByAffinity(sample[k - 1]);
    // The weights are whole numbers, and their sum is exact.
    double total = 0;
    for (const double weight : weights_) total += weight;
    if (total > 0) {
      double left = random.uniform() * total;
      for (std::uint32_t j = 0; j < n && left >= 0; ++j) {
        if (weights_[j] == 0) continue;
        sample[k] = j;
        left -= weights_[j];
      }
      continue;
    }
    do {
      sample[k] = random.index(n);
    } while (std::find(sample, sample + k, sample[k]) != sample + k);
    // The following members agree with this one.
    std::fill(weights_.begin(), weights_.end(), 1.0);
    for (std::size_t i = 0; i < k; ++i) weights_[sample[i]] = 0;
  }
}

}  // namespace corrsel::core
