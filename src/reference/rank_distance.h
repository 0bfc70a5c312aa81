#pragma once

#include <cstdint>

namespace corrsel::core {

/// The distance of two rankings of length k, from 0 for equal ones to 1 for those without a common member
/// (mTopKRP); that of reversed ones is 0.5.
class RankDistance {
 public:
  static constexpr int kMax = 64;
  static constexpr std::uint8_t kAbsent = 255;

  /// @pre 1 <= k <= kMax
  explicit RankDistance(int k);

  int length() const { return k_; }

  /// F, the distance of rankings without a common member before the division by it.
  double largest() const { return largest_; }

  /// f, the cost of one of the two members that have no partner.
  double perStranger() const { return largest_ / (2 * k_); }

  /// @param places  for the members of the right ranking, first rank first, their places in the left one,
  ///                counted from 0; places that are at least length(), like kAbsent, are no common members.
  ///                No other place occurs twice.
  /// The first entries of places in longer rankings are those of rankings that are cut off at `length()`.
  /// O(length()).
  double operator()(const std::uint8_t* places) const;

 private:
  int k_;
  double largest_;
};

}  // namespace corrsel::core
