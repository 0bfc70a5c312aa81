#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace corrsel::core {

/// A circular histogram of gradient directions, whose peaks are the orientations of a feature (Lowe, IJCV
/// 2004, section 5).
///
/// The detectors differ in how a direction is assigned to bins, how the histogram is smoothed and which peaks
/// count, so add() takes a bin, smooth() takes a kernel, and forEachPeak() reports all peaks.
/// @tparam T  float or double, the precision of the sums
template <class T>
class OrientationHistogram {
 public:
  static constexpr std::size_t kBins = 36;

  /// A bin and its two neighbours.
  struct Peak {
    std::size_t bin;
    T before, here, after;

    /// The second difference; negative at a maximum.
    T curvature() const { return before + after - 2 * here; }

    /// Position of the vertex of the parabola through the three bins, in bins relative to the peak's bin.
    T offset() const { return offset(curvature()); }
    T offset(T curvature) const { return static_cast<T>(0.5) * (before - after) / curvature; }
  };

  /// @param bin  0 to 2 kBins - 1; a full turn is subtracted where needed
  void add(std::size_t bin, T weight) { bins_[bin < kBins ? bin : bin - kBins] += weight; }

  /// The kBins sums, for kernels that write them.
  T* bins() { return bins_.data(); }

  /// Replaces every bin by kernel(at), where at(k) is the former value of the bin k further on the circle,
  /// for k from -2 to 2.
  template <class Kernel>
  void smooth(int rounds, const Kernel& kernel) {
    for (int round = 0; round < rounds; ++round) {
      std::array<T, kBins + 4> rough;
      std::copy(bins_.begin(), bins_.end(), rough.begin() + 2);
      rough[0] = bins_[kBins - 2];
      rough[1] = bins_[kBins - 1];
      rough[kBins + 2] = bins_[0];
      rough[kBins + 3] = bins_[1];
      for (std::size_t i = 0; i < kBins; ++i) {
        const T* const middle = rough.data() + i + 2;
        bins_[i] = kernel([middle](std::ptrdiff_t k) { return middle[k]; });
      }
    }
  }

  /// The largest bin; the first of several equal ones.
  Peak highest() const {
    return at(static_cast<std::size_t>(std::max_element(bins_.begin(), bins_.end()) - bins_.begin()));
  }

  /// Calls `visit` with every bin that is larger than both of its neighbours, in the order of bins.
  template <class Visit>
  void forEachPeak(const Visit& visit) const {
    for (std::size_t i = 0; i < kBins; ++i) {
      const Peak peak = at(i);
      if (peak.here > peak.before && peak.here > peak.after) visit(peak);
    }
  }

 private:
  Peak at(std::size_t bin) const {
    return {bin, bins_[(bin + kBins - 1) % kBins], bins_[bin], bins_[(bin + 1) % kBins]};
  }

  std::array<T, kBins> bins_{};
};

}  // namespace corrsel::core
