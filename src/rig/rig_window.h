#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <opencv2/core/types.hpp>
#include <unordered_set>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// Size of a RigWindow, see RigMonitorOptions.
struct RigWindowLimits {
  double seconds;
  std::size_t pairs, matches;
  int grid;
};

/// The matches of the last pairs of a rig as rays. A place that the window has already is not taken again,
/// see RigMonitor.
class RigWindow {
 public:
  struct Pair {
    double time = 0;
    RayMatches rays;
    std::vector<std::uint8_t> regions;  ///< of the left image, row by row
    std::vector<std::uint64_t> places;
  };

  explicit RigWindow(const RigWindowLimits& limits) : limits_(limits) {}

  /// Takes over matches of a pair, and drops what has left the window. Throws as RigMonitor::add().
  /// @return how many were taken over
  std::size_t add(double time, const Correspondences& matches);

  const std::deque<Pair>& pairs() const { return pairs_; }
  std::size_t size() const { return size_; }

  /// From the oldest pair to the newest, s.
  double seconds() const { return pairs_.empty() ? 0.0 : pairs_.back().time - pairs_.front().time; }

 private:
  void clear();
  void makeRoom(double time);
  Pair choose(const Correspondences& matches, const cv::Size& size);

  RigWindowLimits limits_;
  std::deque<Pair> pairs_;
  std::unordered_set<std::uint64_t> taken_;  // places of the matches
  std::size_t size_ = 0;
};

}  // namespace corrsel::core
