#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "corrsel/benchmark/results.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {
namespace {

/// The errors of one kind of the repetitions of each pair.
class PairErrors {
 public:
  void add(const PairId& pair, double error) {
    if (std::isnan(error)) return;
    const auto [found, is_new] = index_.emplace(pair, pairs_.size());
    if (is_new) pairs_.emplace_back();
    pairs_[found->second].push_back(error);
    all_.push_back(error);
  }

  std::size_t pairs() const { return pairs_.size(); }
  const std::vector<double>& all() const { return all_; }
  double auc(double threshold) const { return errorAuc(all_, threshold); }
  Interval interval(double threshold) const { return bootstrapAuc(pairs_, threshold, kBootstrapSeed); }

 private:
  std::map<PairId, std::size_t> index_;
  std::vector<std::vector<double>> pairs_;
  std::vector<double> all_;
};

void addDefined(std::vector<double>& values, double value) {
  if (!std::isnan(value)) values.push_back(value);
}

/// The normalised errors of poses.
struct Consistency {
  std::vector<double> squared;
  std::size_t inside = 0;

  void add(const NormalizedError& error) {
    squared.push_back(error.squared);
    inside += error.inside() ? 1 : 0;
  }

  ConsistencySummary summary() const {
    ConsistencySummary result;
    result.poses = squared.size();
    if (squared.empty()) return result;
    result.mean = mean(squared);
    result.median = quantile(squared, 0.5);
    result.inside = static_cast<double>(inside) / static_cast<double>(squared.size());
    return result;
  }
};

/// The poses that a selector gives itself.
class OwnPoses {
 public:
  void add(const PairId& pair, const OwnPose& own) {
    errors_.add(pair, own.pose_error);
    no_pose_ += own.motion == Motion::kNone ? 1 : 0;
    uncertain_ += own.uncertain ? 1 : 0;
    addDefined(rotations_, own.rotation_error);
    addDefined(translations_, own.translation_error);
    if (own.normalized.degrees == 3) turned_.add(own.normalized);
    if (own.normalized.degrees == 5 && std::isnan(own.second_error)) translated_.add(own.normalized);
  }

  OwnPoseSummary summary() const {
    OwnPoseSummary result;
    result.poses = errors_.pairs();
    result.no_pose = no_pose_;
    result.auc_5 = errors_.auc(5);
    result.auc_10 = errors_.auc(10);
    result.auc_20 = errors_.auc(20);
    const Interval interval = errors_.interval(10);
    result.auc_10_low = interval.low;
    result.auc_10_high = interval.high;
    result.rotation_median = quantile(rotations_, 0.5);
    result.translation_median = quantile(translations_, 0.5);
    result.pose_median = quantile(errors_.all(), 0.5);
    result.uncertain = uncertain_;
    result.with_translation = translated_.summary();
    result.rotations = turned_.summary();
    return result;
  }

 private:
  PairErrors errors_;
  std::size_t no_pose_ = 0, uncertain_ = 0;
  std::vector<double> rotations_, translations_;
  Consistency translated_, turned_;
};

struct Group {
  PoseSummaryRow row;
  PairErrors poses, corners;
  OwnPoses own;
  std::vector<double> accuracies, rotations, translations, precisions, seconds;
};

void addRow(const PoseRow& row, Group& group) {
  group.poses.add(row.id, row.pose_error);
  group.corners.add(row.id, row.corner_error);
  if (!std::isnan(row.pose_error)) {
    group.row.no_pose += row.model == PoseModel::kNone ? 1 : 0;
    group.accuracies.push_back(thresholdAccuracy(row.pose_error));
  }
  group.row.no_homography += std::isinf(row.corner_error) ? 1 : 0;
  addDefined(group.rotations, row.rotation_error);
  addDefined(group.translations, row.translation_error);
  addDefined(group.precisions, row.epipolar_precision);
  addDefined(group.seconds, row.seconds);
  if (row.own) group.own.add(row.id, *row.own);
}

}  // namespace

std::vector<PoseSummaryRow> summarizePoses(const std::vector<PoseRow>& rows) {
  using GroupKey = std::tuple<std::string, std::string, std::string, std::string>;
  std::vector<Group> groups;
  std::map<GroupKey, std::size_t> index;
  for (const PoseRow& row : rows) {
    const GroupKey key{row.id.dataset, row.features, row.preselection, row.selector};
    const auto [found, is_new] = index.emplace(key, groups.size());
    if (is_new) {
      groups.emplace_back();
      PoseSummaryRow& head = groups.back().row;
      std::tie(head.dataset, head.features, head.preselection, head.selector) = key;
    }
    if (!row.evaluated()) continue;
    addRow(row, groups[found->second]);
  }
  std::vector<PoseSummaryRow> summary;
  for (const Group& group : groups) {
    PoseSummaryRow row = group.row;
    row.poses = group.poses.pairs();
    row.auc_5 = group.poses.auc(5);
    row.auc_10 = group.poses.auc(10);
    row.auc_20 = group.poses.auc(20);
    const Interval pose_interval = group.poses.interval(10);
    row.auc_10_low = pose_interval.low;
    row.auc_10_high = pose_interval.high;
    row.accuracy = mean(group.accuracies);
    row.rotation_median = quantile(group.rotations, 0.5);
    row.translation_median = quantile(group.translations, 0.5);
    row.pose_median = quantile(group.poses.all(), 0.5);
    row.epipolar_precision = mean(group.precisions);
    row.homographies = group.corners.pairs();
    row.corner_auc_1 = group.corners.auc(1);
    row.corner_auc_3 = group.corners.auc(3);
    row.corner_auc_5 = group.corners.auc(5);
    const Interval corner_interval = group.corners.interval(3);
    row.corner_auc_3_low = corner_interval.low;
    row.corner_auc_3_high = corner_interval.high;
    row.corner_median = quantile(group.corners.all(), 0.5);
    row.seconds_median = quantile(group.seconds, 0.5);
    row.own = group.own.summary();
    summary.push_back(row);
  }
  return summary;
}

}  // namespace corrsel::core
