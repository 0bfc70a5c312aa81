#pragma once

#include <corrsel/TrackerConfig.h>

#include <atomic>
#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "corrsel/Tracks.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/tracking/track_file.h"
#include "corrsel/tracking/track_keeper.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/track_source.h"

namespace corrsel {

/// Turns selections of a sequence into messages with tracks, and writes the file of tracks. A frame of an
/// earlier time, of another size or with features of another name begins new tracks. configure() may be
/// called while add() is at work on another thread; add() is called on one thread at a time.
class LiveTracker {
 public:
  /// Level of the parameters in cfg/Tracker.cfg.
  static constexpr std::uint32_t kLevelTracker = 1;

  struct Result {
    boost::shared_ptr<Tracks> tracks;
    std::string warning;  ///< what was left out; empty = nothing
  };

  explicit LiveTracker(const TrackerParameters& parameters);

  /// Begins the file of tracks. Throws std::runtime_error that names it if it cannot be written.
  void openFile(const std::string& path) { file_ = std::make_unique<core::TrackFile>(path); }

  /// Puts a configuration into force. After an error, `config` is the configuration that stays in force.
  /// @return why the configuration is not in force; empty = it is
  std::string configure(TrackerConfig& config);

  /// Adds a frame. Throws std::exception that names the field of a malformed message; tracks end there then.
  Result add(const TrackItem& item);

 private:
  void addReference(const TrackItem& item, const core::Correspondences& matches);
  void write(std::uint64_t frame, std::string& warning);
  boost::shared_ptr<Tracks> message(const Correspondences& of) const;

  const int max_gap_, threads_;
  TrackerConfig accepted_ = TrackerConfig::__getDefault__();  ///< the newest one that worked
  std::atomic<int> min_age_;
  std::mutex mutex_;  ///< guards selector_
  std::shared_ptr<const core::Selector> selector_;
  core::TrackKeeper keeper_;
  std::unique_ptr<core::TrackFile> file_;
  std::string kind_;  ///< features and size of the frames in keeper_
};

}  // namespace corrsel
