#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/options.h"
#include "corrsel/rig_monitor.h"

// The parameters of the nodelets that are not options of an algorithm. This file includes no ROS, so that the
// catalogue of options (src/programs/option_catalogue.cpp) lists them in every build.
namespace corrsel {

/// Start-up parameters of the nodelets that work through a queue (LiveStage), and of their diagnostics
/// (LiveDiagnostics). 0 switches a limit off.
struct LiveParameters : core::OptionSet {
  bool lazy = true;
  int subscriber_queue_size = 5;
  int pending = 1;
  double warn_drop_ratio = 0.2, error_drop_ratio = 0.9;
  double warn_latency = 0, error_latency = 0;
  double warn_silence = 2, error_silence = 10;
  double diagnostic_period = 1;

 protected:
  /// @param lazy_text     describes `lazy`
  void visitCommon(core::OptionVisitor& visitor, const char* lazy_text) const;
};

/// What a mask is valid for.
enum class MaskMode : std::uint8_t { kLatched, kStamped };

/// Start-up parameters of the FeatureMatcher nodelet.
struct FeatureMatcherParameters : LiveParameters {
  enum class Mode : std::uint8_t { kPair, kSequence };
  enum class Images : std::uint8_t { kAuto, kRaw, kRectified };
  enum class Tracker : std::uint8_t { kDescriptors, kFlow };
  enum class Prior : std::uint8_t { kNone, kImu, kTf, kLastPose };

  Mode mode = Mode::kPair;
  Tracker tracker = Tracker::kDescriptors;
  Images images = Images::kAuto;
  std::string image_transport = "raw";
  bool use_mask = false;
  MaskMode mask_mode = MaskMode::kLatched;
  std::string left_mask_file, right_mask_file, mask_file;
  bool approximate_sync = false;
  double approximate_sync_max_interval = 0;
  int queue_size = 5;
  int threads = 2;
  bool image_quality = true;
  Prior prior = Prior::kNone;
  double prior_timeout = 0.02, prior_sigma = 0.5;
  std::string imu_rotation;
  std::string prior_frame, prior_fixed_frame = "odom";
  double prior_min_translation = 0.1;

  void visit(core::OptionVisitor& visitor) const override;

  /// Throws std::invalid_argument also for an imu_rotation that is none, and for a prior that the mode does
  /// not allow, and for the optical flow of pairs.
  void check() const override;

  /// R that turns a vector in the frame of the IMU into one in that of the camera; nothing where
  /// imu_rotation is empty.
  std::optional<cv::Matx33d> imuRotation() const;

 private:
  void visitPrior(core::OptionVisitor& visitor) const;
};

/// Start-up parameters of the RigMonitor nodelet.
struct RigMonitorParameters : core::RigMonitorOptions {
  double report_period = 1;
  std::string output_folder;
  int subscriber_queue_size = 10;

  void visit(core::OptionVisitor& visitor) const override;
};

enum class FeatureMode : std::uint8_t { kPair, kSequence };

/// Start-up parameters of the Matcher nodelet.
struct MatcherParameters : LiveParameters {
  FeatureMode mode = FeatureMode::kPair;
  double max_interval = 0;
  int queue_size = 5;
  int threads = 2;

  void visit(core::OptionVisitor& visitor) const override;
};

/// Start-up parameters of the Selector nodelet.
struct SelectorParameters : LiveParameters {
  FeatureMode mode = FeatureMode::kPair;
  bool use_mask = false;
  MaskMode mask_mode = MaskMode::kLatched;
  double mask_timeout = 0.2, mask_max_age = 0;
  std::string mask_classes;
  int mask_dilation = 0;
  double warn_inlier_ratio = 0.1, error_inlier_ratio = 0;
  std::string presets_in_force;

  void visit(core::OptionVisitor& visitor) const override;

  /// Throws std::invalid_argument also if the classes are not a list of whole numbers from 0 to 65535.
  void check() const override;
  std::vector<int> maskClassList() const;
};

/// Start-up parameters of the Tracker nodelet.
struct TrackerParameters : LiveParameters {
  TrackerParameters() { pending = 10; }  // a frame that is dropped may break tracks

  int max_gap = 2;
  std::string file;
  int threads = 1;

  void visit(core::OptionVisitor& visitor) const override;
};

/// Start-up parameters of the nodelets that draw.
struct ViewerParameters : core::OptionSet {
  bool lazy = true;
  std::string image_transport = "raw";
  int subscriber_queue_size = 5;
  int cache_size = 10;

 protected:
  void visitCommon(core::OptionVisitor& visitor) const;
};

/// Start-up parameters of the TrackViewer nodelet.
struct TrackViewerParameters : ViewerParameters {
  int tail = 20;

  void visit(core::OptionVisitor& visitor) const override;
};

/// Start-up parameters of the MatchViewer nodelet.
struct MatchViewerParameters : ViewerParameters {
  double tolerance = 5;
  int max_lines = 200;

  void visit(core::OptionVisitor& visitor) const override;
};

/// Start-up parameters of the Evaluator nodelet.
struct EvaluatorParameters : core::OptionSet {
  std::string tolerances = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10";  ///< px
  double ground_truth_tolerance = 10;                        ///< px
  int subscriber_queue_size = 10;

  void visit(core::OptionVisitor& visitor) const override;

  /// Throws std::invalid_argument also if the tolerances are not a list of positive numbers.
  void check() const override;
  std::vector<double> toleranceList() const;
};

/// The parameters of the FeatureMatcher nodelet that can be changed at run time and are not options of an
/// algorithm: the combination of algorithms, and the part of the images in which features are looked for.
struct FeatureChoice : core::OptionSet {
  std::string features = "sift+sift";

  void visit(core::OptionVisitor& visitor) const override;
};

/// core::featureAlgorithms() with the default values of live use. In live use a frame must be processed
/// before the next one arrives, so detectors have a limit on the number of features. Everywhere else the
/// default values are those of the paper.
std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> liveFeatureAlgorithms();

struct RegionParameters : core::OptionSet {
  int x = 0, y = 0, width = 0, height = 0;

  void visit(core::OptionVisitor& visitor) const override;
};

/// The parameters of the Matcher nodelet that can be changed at run time, beside the options of the
/// comparison of descriptors and of sequences.
struct MatcherChoice : core::OptionSet {
  static constexpr const char* kDescriptors = "descriptors";  ///< core::DescriptorMatcher

  std::string matcher = kDescriptors;
  std::string options;

  void visit(core::OptionVisitor& visitor) const override;
};

/// The parameters of the Selector nodelet that can be changed at run time and are not options of a selector.
struct SelectorChoice : core::OptionSet {
  std::string selector = "auto";
  std::string preset;
  std::string options;
  double max_seconds = 1;
  bool label_motion = false;
  int seed = 0;

  void visit(core::OptionVisitor& visitor) const override;
};

/// The parameters of the Tracker nodelet that can be changed at run time.
struct TrackerChoice : core::OptionSet {
  std::string selector = "auto";
  int min_age = 2;

  void visit(core::OptionVisitor& visitor) const override;
};

/// The start-up parameters of all nodelets with their default values, by the name of the nodelet.
std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> nodeletParameters();

}  // namespace corrsel
