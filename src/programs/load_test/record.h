#pragma once

#include <ros/time.h>

#include <array>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/Selection.h"

namespace corrsel::load_test {

/// Names of the stages of a selection's times, in order.
constexpr std::array<const char*, 6> kStages = {"wait", "detect", "describe", "match", "select", "publish"};

/// One pair and its results. Times in seconds; NaN = no result.
struct PairRecord {
  ros::Time stamp;
  double sent = 0.0;                                          ///< since the start of the test
  double latency = std::numeric_limits<double>::quiet_NaN();  ///< stamp to arrival of the matches
  double selection_latency = std::numeric_limits<double>::quiet_NaN();
  std::array<double, kStages.size()> stages;
  std::string selector;
  int status = 0;
  std::size_t n_input = 0, n_selected = 0;

  PairRecord() { stages.fill(std::numeric_limits<double>::quiet_NaN()); }
  bool processed() const { return latency == latency; }
  bool selected() const { return selection_latency == selection_latency; }
};

/// Records pairs and their results. Safe on several threads.
class Record {
 public:
  /// Forgets the pairs so far; results for them are no longer counted.
  void restart();

  /// To be called before the pair is published.
  void send(const ros::Time& stamp);

  void receive(const Correspondences& msg);
  void receive(const Selection& msg);

  struct Counts {
    std::size_t sent = 0, processed = 0, selections = 0;
    std::size_t duplicates = 0, out_of_order = 0, unknown = 0;  ///< results that should not exist
    bool newest_processed = false;  ///< matches and selection of the last pair have arrived
  };
  Counts counts() const;

  std::vector<PairRecord> pairs() const;

 private:
  PairRecord* find(const ros::Time& stamp);

  mutable std::mutex mutex_;
  std::vector<PairRecord> pairs_;
  std::map<ros::Time, std::size_t> index_;
  ros::WallTime start_;
  ros::Time newest_matches_;
  Counts counts_;
};

}  // namespace corrsel::load_test
