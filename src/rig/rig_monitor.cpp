#include "corrsel/rig_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/pose_prior.h"
#include "geometry/essential.h"
#include "geometry/pose_fit.h"
#include "rig/deviation.h"
#include "rig/rig_fit.h"
#include "rig/rig_window.h"
#include "rig/trigger.h"

namespace corrsel::core {
namespace {

constexpr double kDegree = CV_PI / 180;
constexpr double kSignificant = 5;  // standard deviations, as in deviation.cpp
constexpr std::size_t kRegionMatches = 20;
constexpr double kLeftOver = 0.5;  // of the root mean square of the regions' median errors
constexpr double kAgrees = 3;      // standard deviations
constexpr const char* kNames[] = {"the rotation about x", "the rotation about y", "the rotation about z",
                                  "the first direction of the baseline",
                                  "the second direction of the baseline"};

RigWindowLimits limitsOf(const RigMonitorOptions& options) {
  return {options.window, static_cast<std::size_t>(options.max_pairs),
          static_cast<std::size_t>(options.max_matches), options.grid};
}

Pose poseOf(const cv::Matx33d& rotation, const cv::Vec3d& translation) {
  const PosePrior rig = PosePrior::ofRig(rotation, translation);
  rig.check();
  return {rig.rotation, rig.translation};
}

std::string degrees(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.3f", value);
  return buffer;
}

/// Signed errors of all matches of each region, px.
std::vector<std::vector<double>> errorsByRegion(const Pose& pose, const RigWindow& window, int grid) {
  std::vector<std::vector<double>> errors(static_cast<std::size_t>(grid * grid));
  const cv::Matx33d essential = essentialOf(pose);
  for (const RigWindow::Pair& pair : window.pairs()) {
    for (std::size_t i = 0; i < pair.rays.size(); ++i) {
      errors[pair.regions[i]].push_back(tangentSampson(essential, pair.rays, i));
    }
  }
  return errors;
}

/// Root mean square of the values whose corrected ones are within the limit; NaN for none.
double rootMeanSquare(const std::vector<double>& values, const std::vector<double>& corrected, double limit) {
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(corrected[i]) <= limit)) continue;
    sum += values[i] * values[i];
    ++n;
  }
  return std::sqrt(sum / n);
}

/// Whether the correction removes most of what the regions show.
/// @param usual  their median errors at the start, px
bool agrees(const std::vector<RigRegion>& regions, const std::vector<double>& usual) {
  double before = 0, after = 0;
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (regions[k].count < kRegionMatches) continue;
    before += std::pow(regions[k].median - usual[k], 2);
    after += std::pow(regions[k].corrected_median - usual[k], 2);
  }
  return after <= kLeftOver * kLeftOver * before;
}

}  // namespace

std::string toString(RigState state) {
  switch (state) {
    case RigState::kOk:
      return "ok";
    case RigState::kWarning:
      return "warning";
    case RigState::kError:
      return "error";
    case RigState::kUnknown:
      break;
  }
  return "unknown";
}

void RigMonitorOptions::visit(OptionVisitor& visitor) const {
  using P = RigMonitorOptions;
  visitor.number({"window", 0.1, 1e6, "s", "Time over which the matches of the rig are looked at"},
                 &P::window);
  visitor.integer({"max_pairs", 2, 10000, "-",
                   "Pairs in the window at most; those that come sooner after the last one are left out"},
                  &P::max_pairs);
  visitor.integer({"max_matches", 10, 100000, "-", "Matches of one pair that the window gets at most"},
                  &P::max_matches);
  visitor.integer({"min_matches", 20, 1000000, "-", "Matches in the window below which the state is unknown"},
                  &P::min_matches);
  visitor.integer({"grid", 1, 10, "-", "Regions along each side of the image, whose errors are reported"},
                  &P::grid);
  visitor.number({"warn_angle", 1e-4, 90, "degrees",
                  "Significant turn of the rig, or of the direction of its baseline, beyond which it warns"},
                 &P::warn_angle);
  visitor.number({"error_angle", 1e-4, 90, "degrees", "The same beyond which the state is an error"},
                 &P::error_angle);
  visitor.number({"hold", 0, 1e6, "s", "Time that a new state has to last before it counts"}, &P::hold);
  visitor.number(
      {"learn", 0, 1e6, "s",
       "Time at the start after which the pose that the matches show becomes the reference; 0 = the "
       "calibration is the reference"},
      &P::learn);
}

void RigMonitorOptions::check() const {
  OptionSet::check();
  if (error_angle < warn_angle) {
    throw std::invalid_argument("error_angle is " + formatNumber(error_angle) + ", below warn_angle, " +
                                formatNumber(warn_angle));
  }
}

/// The window, the reference and the state of a monitor.
class RigMonitor::Judge {
 public:
  Judge(const RigMonitorOptions& options, const cv::Matx33d& rotation, const cv::Vec3d& translation)
      : options_(options),
        window_(limitsOf(options)),
        calibrated_(poseOf(rotation, translation)),
        reference_(calibrated_),
        usual_medians_(static_cast<std::size_t>(options.grid * options.grid)),
        warning_(options.warn_angle, options.hold),
        error_(options.error_angle, options.hold) {}

  std::size_t add(double time, const Correspondences& matches) {
    const std::size_t count = window_.add(time, matches);
    if (std::isnan(start_) || time < now_) {
      start_ = time;
      warning_.interrupt();
      error_.interrupt();
    }
    now_ = time;
    return count;
  }

  RigReport report() {
    RigReport report;
    report.pairs = window_.pairs().size();
    report.matches = window_.size();
    report.seconds = window_.seconds();
    report.calibrated = report.corrected = calibrated_;
    const bool enough = report.matches >= static_cast<std::size_t>(options_.min_matches);
    const std::optional<RigEstimate> estimate = enough ? fit_.fit(window_, reference_) : std::nullopt;
    if (estimate) learn(*estimate);
    report.reference = reference_;
    report.learned = learned_;
    if (estimate) describe(*estimate, report);
    measureRegions(report);
    decide(enough, report);
    return report;
  }

  const RigMonitorOptions& options() const { return options_; }

 private:
  bool isLearning() const { return options_.learn > 0 && !learned_; }

  void learn(const RigEstimate& estimate) {
    if (!isLearning() || now_ - start_ < options_.learn) return;
    reference_ = estimate.pose;
    reference_covariance_ = estimate.covariance;
    reference_cautious_ = estimate.cautious;
    const auto errors = errorsByRegion(reference_, window_, options_.grid);
    for (std::size_t k = 0; k < errors.size(); ++k) {
      if (!errors[k].empty()) usual_medians_[k] = quantile(errors[k], 0.5);
    }
    learned_ = true;
  }

  void describe(const RigEstimate& estimate, RigReport& report) const {
    RelativePose pose;
    pose.rotation = estimate.pose.rotation;
    pose.translation = estimate.pose.translation;
    report.determined = true;
    report.noise = estimate.noise;
    report.deviation = poseDeviation(reference_, pose);
    const auto inBasis = [&](const cv::Matx<double, 5, 5>& covariance) {
      return inBasisOf(reference_.translation, estimate.pose.translation, covariance);
    };
    report.covariance = inBasis(estimate.covariance) + reference_covariance_;
    const cv::Matx<double, 5, 5> cautious = inBasis(estimate.cautious) + reference_cautious_;
    for (int k = 0; k < 5; ++k) {
      report.observable[static_cast<std::size_t>(k)] =
          kSignificant * std::sqrt(cautious(k, k)) <= options_.warn_angle * kDegree;
    }
    report.shown = significantPart(report.deviation, cautious);
    report.angle = angleOf(report.shown);
    report.corrected = moved(calibrated_, report.shown);
  }

  void measureRegions(RigReport& report) const {
    const auto errors = errorsByRegion(reference_, window_, options_.grid);
    for (const std::vector<double>& of_region : errors) {
      report.regions.push_back({of_region.size(), quantile(of_region, 0.5)});
    }
    if (!report.determined) return;
    const auto corrected = errorsByRegion(moved(reference_, report.shown), window_, options_.grid);
    for (std::size_t k = 0; k < corrected.size(); ++k) {
      RigRegion& region = report.regions[k];
      region.rms = rootMeanSquare(errors[k], corrected[k], kAgrees * report.noise);
      region.corrected_median = quantile(corrected[k], 0.5);
    }
    report.agreed = agrees(report.regions, usual_medians_);
  }

  void decide(bool enough, RigReport& report) {
    const std::string matches =
        std::to_string(report.matches) + " matches in " + std::to_string(report.pairs) + " pairs";
    if (!report.determined || isLearning()) {
      warning_.interrupt();
      error_.interrupt();
      report.message = isLearning() ? "learning the reference; " + matches
                       : enough     ? "the matches do not determine a pose; " + matches
                                    : "too few matches: " + matches;
      return;
    }
    const double angle = report.agreed ? report.angle : 0;
    // The time of what was seen: without anything new, no state begins or ends.
    const double seen = window_.pairs().back().time;
    warning_.update(seen, angle);
    error_.update(seen, angle);
    settled_ = settled_ || !(warning_.isChanging() || error_.isChanging());
    if (settled_) {
      report.state = error_.isOn() ? RigState::kError : warning_.isOn() ? RigState::kWarning : RigState::kOk;
    }
    report.message = sentence(report) + "; " + matches;
  }

  static std::string sentence(const RigReport& report) {
    const cv::Vec<double, 5> d = report.shown * (1 / kDegree);
    std::string text = "no significant deviation";
    if (report.angle > 0) {
      text = "the right camera has turned by " + degrees(d[0]) + " " + degrees(d[1]) + " " + degrees(d[2]) +
             " degrees about x y z, and the baseline by " + degrees(std::hypot(d[3], d[4])) + " degrees";
      if (!report.agreed) text += ", which does not explain what the regions of the image show";
    }
    std::vector<std::string> hidden;
    for (std::size_t k = 0; k < report.observable.size(); ++k) {
      if (!report.observable[k]) hidden.emplace_back(kNames[k]);
    }
    if (!hidden.empty()) text += "; not observable at the limit of the warning: " + joinList(hidden, ", ");
    return text + "; the length of the baseline cannot be observed";
  }

  const RigMonitorOptions options_;
  RigWindow window_;
  RigFit fit_;
  const Pose calibrated_;
  Pose reference_;
  cv::Matx<double, 5, 5> reference_covariance_, reference_cautious_;  // 0 of the calibration
  std::vector<double> usual_medians_;  // of the errors of the regions under a learned reference, px
  bool learned_ = false;
  bool settled_ = false;                                     // whether there has been a state that lasted
  double start_ = std::numeric_limits<double>::quiet_NaN();  // time of the first pair, s
  double now_ = 0;  // of the newest, s; the window may have left it out
  Trigger warning_, error_;
};

RigMonitor::RigMonitor(const RigMonitorOptions& options, const cv::Matx33d& rotation,
                       const cv::Vec3d& translation) {
  options.check();
  judge_ = std::make_unique<Judge>(options, rotation, translation);
}

RigMonitor::~RigMonitor() = default;

std::size_t RigMonitor::add(double time, const Correspondences& matches) {
  return judge_->add(time, matches);
}

RigReport RigMonitor::report() { return judge_->report(); }

const RigMonitorOptions& RigMonitor::options() const { return judge_->options(); }

}  // namespace corrsel::core
