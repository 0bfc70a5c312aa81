#include "record.h"

namespace corrsel::load_test {
namespace {

double age(const ros::Time& stamp) {
  return (ros::WallTime::now() - ros::WallTime(stamp.sec, stamp.nsec)).toSec();
}

}  // namespace

void Record::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  pairs_.clear();
  index_.clear();
  counts_ = Counts();
  newest_matches_ = ros::Time();
  start_ = ros::WallTime::now();
}

void Record::send(const ros::Time& stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  PairRecord pair;
  pair.stamp = stamp;
  pair.sent = (ros::WallTime(stamp.sec, stamp.nsec) - start_).toSec();
  index_[stamp] = pairs_.size();
  pairs_.push_back(pair);
  ++counts_.sent;
}

/// Null for a stamp that was not sent; those before the start are the ones that were sent to warm up.
PairRecord* Record::find(const ros::Time& stamp) {
  const auto found = index_.find(stamp);
  if (found != index_.end()) return &pairs_[found->second];
  if (ros::WallTime(stamp.sec, stamp.nsec) >= start_) ++counts_.unknown;
  return nullptr;
}

void Record::receive(const Correspondences& msg) {
  const double latency = age(msg.header.stamp);
  const std::lock_guard<std::mutex> lock(mutex_);
  PairRecord* const pair = find(msg.header.stamp);
  if (!pair) return;
  if (pair->processed()) {
    ++counts_.duplicates;
    return;
  }
  pair->latency = latency;
  ++counts_.processed;
  if (msg.header.stamp < newest_matches_) {
    ++counts_.out_of_order;
  } else {
    newest_matches_ = msg.header.stamp;
  }
}

void Record::receive(const Selection& msg) {
  const double latency = age(msg.header.stamp);
  const std::lock_guard<std::mutex> lock(mutex_);
  PairRecord* const pair = find(msg.header.stamp);
  if (!pair) return;
  if (pair->selected()) {
    ++counts_.duplicates;
    return;
  }
  pair->selection_latency = latency;
  const StageTimes& seconds = msg.seconds;
  pair->stages = {seconds.wait,  seconds.detect, seconds.describe,
                  seconds.match, seconds.select, seconds.publish};
  pair->selector = msg.selector;
  pair->status = msg.status;
  pair->n_input = msg.n_input;
  pair->n_selected = msg.n_selected;
  ++counts_.selections;
}

Record::Counts Record::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Counts counts = counts_;
  counts.newest_processed = !pairs_.empty() && pairs_.back().processed() && pairs_.back().selected();
  return counts;
}

std::vector<PairRecord> Record::pairs() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return pairs_;
}

}  // namespace corrsel::load_test
