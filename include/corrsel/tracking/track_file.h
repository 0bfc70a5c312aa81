#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "corrsel/tracking/track_keeper.h"

namespace corrsel::core {

/// Writes tracks to a CSV file while they grow, one row for each sight of a track that was seen at least
/// twice.
///
/// The columns are track, stamp (id of the frame), keypoint (number of the feature in its frame, from 0), x,
/// y (px, centre of the first pixel at (0, 0)). The first line has their names. A track's rows are in the
/// order of the frames; the row of its first sight comes with that of its second one. Every frame is flushed,
/// so that a program that ends at any moment leaves whole frames.
///
/// Cost: O(features) for a frame, and about 50 bytes of the file for each row.
class TrackFile {
 public:
  /// Replaces a file of this name. Throws std::runtime_error that names it if it cannot be written.
  explicit TrackFile(const std::filesystem::path& path);

  /// Adds a frame. Throws std::runtime_error that names the file if it cannot be written, e.g. because the
  /// disk is full; then nothing more can be added.
  /// @param tracks  of its features
  void add(std::uint64_t frame, const std::vector<FeatureTrack>& tracks);

 private:
  void check();

  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace corrsel::core
