#pragma once

#include <cstddef>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// What tells the better of two matches before anything is known about the motion. Lower is better, and NaN
/// is unknown. Descriptor distances come first. Where the matches have none, the cost is 1 - probability, so
/// that the confidences of a learned matcher order its matches.
///
/// The columns are read, not copied. O(1) per match.
class MatchCosts {
 public:
  /// @pre matches.inconsistency() returns an empty text, and the matches live as long as this object
  explicit MatchCosts(const Correspondences& matches)
      : nearest_(matches.distance.empty() ? nullptr : matches.distance.data()),
        second_(matches.second_distance.empty() ? nullptr : matches.second_distance.data()),
        probability_(matches.probability.empty() ? nullptr : matches.probability.data()),
        size_(matches.size()) {}

  /// Whether the matches have a column that orders them.
  bool known() const { return nearest_ != nullptr || probability_ != nullptr; }

  /// Compares matches of different left features: the distance, or 1 - probability. @pre known()
  float nearest(std::size_t row) const {
    return nearest_ != nullptr ? nearest_[row] : 1.0F - probability_[row];
  }

  /// Compares any matches: writes the distance divided by the second-nearest distance where the matches have
  /// one, otherwise nearest(), of each row. @pre known()
  void ratios(std::vector<float>& out) const {
    out.resize(size_);
    if (nearest_ != nullptr && second_ != nullptr) {
      for (std::size_t row = 0; row < size_; ++row) out[row] = nearest_[row] / second_[row];
    } else {
      for (std::size_t row = 0; row < size_; ++row) out[row] = nearest(row);
    }
  }

 private:
  const float *nearest_, *second_, *probability_;
  std::size_t size_;
};

}  // namespace corrsel::core
