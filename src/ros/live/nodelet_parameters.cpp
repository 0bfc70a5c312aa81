#include "ros/live/nodelet_parameters.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "geometry/rotation_vector.h"

namespace corrsel {

using core::OptionVisitor;

namespace {

/// The parameters that FeatureMatcher and Selector have in common, so that both know whose work masks are.
template <class Parameters>
void visitMasks(OptionVisitor& visitor) {
  visitor.flag("use_mask", "Take masks from left/mask and right/mask, or from mask in sequence mode",
               &Parameters::use_mask);
  visitor.choice(
      "mask_mode",
      {{MaskMode::kLatched, "latched", "All later images; FeatureMatcher finds no features on it"},
       {MaskMode::kStamped, "stamped", "The images with its stamp; Selector rejects the matches on it"}},
      "With use_mask: what a mask is valid for; the same for both nodelets", &Parameters::mask_mode);
}

}  // namespace

void LiveParameters::visitCommon(OptionVisitor& visitor, const char* lazy_text) const {
  using P = LiveParameters;
  visitor.flag("lazy", lazy_text, &P::lazy);
  visitor.integer({"subscriber_queue_size", 1, 1000, "-",
                   "Messages of each topic that wait to be received; receiving is quick"},
                  &P::subscriber_queue_size);
  visitor.integer(
      {"pending", 1, 1000, "-",
       "Items that wait to be processed; when there are more, the oldest is dropped, and a larger "
       "number only adds delay"},
      &P::pending);
  visitor.number(
      {"warn_drop_ratio", 0, 1, "-", "Share of dropped items beyond which /diagnostics warns; 0 = off"},
      &P::warn_drop_ratio);
  visitor.number({"error_drop_ratio", 0, 1, "-",
                  "Share of dropped items beyond which /diagnostics reports an error; 0 = off"},
                 &P::error_drop_ratio);
  visitor.number(
      {"warn_latency", 0, 1e6, "s",
       "Age of the left image when its result is published, 95th percentile, beyond which /diagnostics "
       "warns; 0 = off"},
      &P::warn_latency);
  visitor.number(
      {"error_latency", 0, 1e6, "s", "The same age beyond which /diagnostics reports an error; 0 = off"},
      &P::error_latency);
  visitor.number({"warn_silence", 0, 1e6, "s", "Time without input after which /diagnostics warns; 0 = off"},
                 &P::warn_silence);
  visitor.number(
      {"error_silence", 0, 1e6, "s", "Time without input after which /diagnostics reports an error; 0 = off"},
      &P::error_silence);
  visitor.number({"diagnostic_period", 0.05, 1e6, "s", "Time between two reports on /diagnostics"},
                 &P::diagnostic_period);
}

void FeatureMatcherParameters::visit(OptionVisitor& visitor) const {
  using P = FeatureMatcherParameters;
  visitor.choice("mode",
                 {{Mode::kPair, "pair", "Pairs of left/image and right/image"},
                  {Mode::kSequence, "sequence", "Images of one camera, each with an earlier one"}},
                 "The images that are matched", &P::mode);
  visitor.choice("tracker",
                 {{Tracker::kDescriptors, "descriptors", "Features are detected in every image and compared"},
                  {Tracker::kFlow, "flow", "Points are followed by optical flow, in sequence mode only"}},
                 "What matches the images of a sequence", &P::tracker);
  visitor.choice("images",
                 {{Images::kAuto, "auto", "Rectified if the name of their topic contains image_rect"},
                  {Images::kRaw, "raw", "K and D of camera_info hold"},
                  {Images::kRectified, "rectified", "P of camera_info holds"}},
                 "Whether the images are rectified, which camera_info does not say", &P::images);
  visitor.text("image_transport",
               "Transport of the images: raw, compressed, or the name of an installed plug-in",
               &P::image_transport);
  visitMasks<P>(visitor);
  visitor.text("left_mask_file",
               "Image file; no features are found in the left image where it is zero, as on the robot's own "
               "body; empty = none",
               &P::left_mask_file);
  visitor.text("right_mask_file", "The same for the right image", &P::right_mask_file);
  visitor.text("mask_file", "The same in sequence mode", &P::mask_file);
  visitor.flag("approximate_sync", "Pair images whose stamps are close instead of equal",
               &P::approximate_sync);
  visitor.number({"approximate_sync_max_interval", 0, 1e6, "s",
                  "With approximate_sync: largest difference of the stamps of a pair; 0 = no limit"},
                 &P::approximate_sync_max_interval);
  visitor.integer({"queue_size", 1, 1000, "-",
                   "Images of each camera that are kept until the image of the other one arrives"},
                  &P::queue_size);
  visitor.integer({"threads", 1, 1024, "-",
                   "1 = the images of a pair one after the other, 2 = side by side; the result is the same"},
                  &P::threads);
  visitor.flag("image_quality",
               "Measure exposure, blur and noise of every image, which takes 0.1 ms for each",
               &P::image_quality);
  visitPrior(visitor);
  visitCommon(visitor, "Subscribe to the images only while somebody subscribes to the matches");
}

void FeatureMatcherParameters::visitPrior(OptionVisitor& visitor) const {
  using P = FeatureMatcherParameters;
  visitor.choice("prior",
                 {{Prior::kNone, "none", "All features are compared"},
                  {Prior::kImu, "imu", "The angular rates on imu (sensor_msgs/Imu); sequences only"},
                  {Prior::kTf, "tf", "TF between the frames of the images, or of prior_frame"},
                  {Prior::kLastPose, "last_pose",
                   "The camera moves on as the last pose on relative_pose shows; sequences only"}},
                 "What is known of the motion between the images; it is tested before it is used", &P::prior);
  visitor.number(
      {"prior_timeout", 0, 10, "s",
       "Time that is waited for what is known of the motion; afterwards all features are compared"},
      &P::prior_timeout);
  visitor.number({"prior_sigma", 0, 180, "deg",
                  "Standard deviation of the known rotation, beside what imu or last_pose state themselves"},
                 &P::prior_sigma);
  visitor.text("imu_rotation",
               "With imu: rotation from the frame of the IMU to that of the camera, a quaternion x, y, z, w "
               "or roll, pitch, yaw [rad]; empty = from TF",
               &P::imu_rotation);
  visitor.text("prior_frame", "With tf, in a sequence: frame of the camera; empty = that of the images",
               &P::prior_frame);
  visitor.text("prior_fixed_frame", "With tf: frame that does not move between the times of the images",
               &P::prior_fixed_frame);
  visitor.number({"prior_min_translation", 0, 1e6, "m",
                  "With tf: shortest translation whose direction is used; twenty times the error of TF"},
                 &P::prior_min_translation);
}

void FeatureMatcherParameters::check() const {
  OptionSet::check();
  imuRotation();
  if (mode == Mode::kPair && (prior == Prior::kImu || prior == Prior::kLastPose)) {
    throw std::invalid_argument(std::string("prior = ") + (prior == Prior::kImu ? "imu" : "last_pose") +
                                " is for mode = sequence; pairs of two cameras can have tf");
  }
  if (tracker == Tracker::kFlow && mode == Mode::kPair) {
    throw std::invalid_argument(
        "tracker is flow with mode pair; needed: mode sequence, or tracker descriptors");
  }
}

std::optional<cv::Matx33d> FeatureMatcherParameters::imuRotation() const {
  if (imu_rotation.empty()) return std::nullopt;
  std::vector<double> values;
  double squared = 0;
  for (const std::string& text : core::splitList(imu_rotation)) {
    values.push_back(core::parseNumber(text, "imu_rotation"));
    squared += values.back() * values.back();
  }
  if (values.size() == 3 && std::isfinite(squared)) {
    return core::rotationFromVector({0, 0, values[2]}) * core::rotationFromVector({0, values[1], 0}) *
           core::rotationFromVector({values[0], 0, 0});
  }
  constexpr double kTolerance = 1e-2;  // of a length that was written as text
  if (values.size() == 4 && std::abs(squared - 1) <= kTolerance) {
    return core::rotationFromQuaternion({values[3], values[0], values[1], values[2]});
  }
  throw std::invalid_argument(
      "imu_rotation = " + imu_rotation +
      " is no rotation; valid: a unit quaternion x, y, z, w, or roll, pitch, yaw [rad]");
}

void MatcherParameters::visit(OptionVisitor& visitor) const {
  using P = MatcherParameters;
  visitor.choice("mode",
                 {{FeatureMode::kPair, "pair", "Pairs of left/features and right/features"},
                  {FeatureMode::kSequence, "sequence", "Features of one camera, each with earlier ones"}},
                 "The features that are matched", &P::mode);
  visitor.number({"max_interval", 0, 1e6, "s",
                  "Largest difference of the stamps of a pair, less than half the time between two images"},
                 &P::max_interval);
  visitor.integer(
      {"queue_size", 1, 1000, "-", "Messages of each side that are kept until that of the other one arrives"},
      &P::queue_size);
  visitor.integer({"threads", 1, 1024, "-",
                   "Threads that compare descriptors; the result does not depend on their number"},
                  &P::threads);
  visitCommon(visitor, "Subscribe to the features only while somebody subscribes to the matches");
}

void SelectorParameters::visit(OptionVisitor& visitor) const {
  using P = SelectorParameters;
  visitor.choice(
      "mode",
      {{FeatureMode::kPair, "pair", "Matches between two cameras, masks on left/mask and right/mask"},
       {FeatureMode::kSequence, "sequence", "Matches between frames of one camera, masks on mask"}},
      "Where stamped masks come from", &P::mode);
  visitMasks<P>(visitor);
  visitor.number({"mask_timeout", 0, 10, "s",
                  "Stamped masks: time that a pair waits for its masks before it goes on without them"},
                 &P::mask_timeout);
  visitor.number({"mask_max_age", 0, 10, "s",
                  "Stamped masks: a mask also belongs to the newest image that is older than it by at most "
                  "this; 0 = equal stamps only"},
                 &P::mask_max_age);
  visitor.text("mask_classes",
               "Stamped masks: labels of a label image that are excluded, as \"11, 12, 13\"; empty = the "
               "image is a mask, which excludes where it is zero",
               &P::mask_classes);
  visitor.integer({"mask_dilation", 0, 200, "px",
                   "Stamped masks: what they exclude grows by so many of their pixels in every direction"},
                  &P::mask_dilation);
  visitCommon(visitor, "Subscribe to the correspondences only while somebody subscribes to the result");
  visitor.number(
      {"warn_inlier_ratio", 0, 1, "-", "Share of selected matches below which /diagnostics warns; 0 = off"},
      &SelectorParameters::warn_inlier_ratio);
  visitor.number({"error_inlier_ratio", 0, 1, "-",
                  "Share of selected matches below which /diagnostics reports an error; 0 = off"},
                 &SelectorParameters::error_inlier_ratio);
  visitor.text("presets_in_force",
               "Presets whose values the parameters of the selectors have; the nodelet sets it for its next "
               "start",
               &SelectorParameters::presets_in_force);
}

void SelectorParameters::check() const {
  OptionSet::check();
  maskClassList();
}

std::vector<int> SelectorParameters::maskClassList() const {
  constexpr int kLargestLabel = 65535;
  std::vector<int> classes;
  for (const std::string& text : core::splitList(mask_classes)) {
    classes.push_back(core::parseInteger(text, "mask_classes"));
    if (classes.back() < 0 || classes.back() > kLargestLabel) {
      throw std::invalid_argument("mask_classes has " + text + "; a label is a whole number from 0 to " +
                                  std::to_string(kLargestLabel));
    }
  }
  return classes;
}

void TrackerParameters::visit(OptionVisitor& visitor) const {
  using P = TrackerParameters;
  visitor.integer({"max_gap", 0, 30, "frames",
                   "Frames that a track may be missing in before it ends; above 0, features are subscribed"},
                  &P::max_gap);
  visitor.text("file", "CSV file that the tracks are written to; empty = none", &P::file);
  visitor.integer({"threads", 1, 1024, "-",
                   "Threads that compare descriptors; the result does not depend on their number"},
                  &P::threads);
  visitCommon(visitor,
              "Subscribe to the selections only while somebody subscribes to the tracks; with a file, they "
              "are always subscribed");
}

void ViewerParameters::visitCommon(OptionVisitor& visitor) const {
  using P = ViewerParameters;
  visitor.flag("lazy", "Subscribe and draw only while somebody subscribes to the drawings", &P::lazy);
  visitor.text("image_transport",
               "Transport of the images: raw, compressed, or the name of an installed plug-in",
               &P::image_transport);
  visitor.integer({"subscriber_queue_size", 1, 1000, "-",
                   "Messages of each topic that wait to be received; receiving is quick"},
                  &P::subscriber_queue_size);
  visitor.integer(
      {"cache_size", 1, 100000, "-", "Images that are kept until all messages with their stamp have arrived"},
      &P::cache_size);
}

void TrackViewerParameters::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.integer({"tail", 1, 1000, "frames", "Length of the tails of the tracks"},
                  &TrackViewerParameters::tail);
}

void MatchViewerParameters::visit(OptionVisitor& visitor) const {
  using P = MatchViewerParameters;
  visitCommon(visitor);
  visitor.number({"tolerance", 0, 1e6, "px", "Error up to which a match is drawn as correct"}, &P::tolerance);
  visitor.integer({"max_lines", 1, 1000000, "-", "Largest number of lines that are drawn of each colour"},
                  &P::max_lines);
}

void EvaluatorParameters::visit(OptionVisitor& visitor) const {
  visitor.text(
      "tolerances",
      "Errors up to which a selected match counts as correct, a list of numbers; each gives a score [px]",
      &EvaluatorParameters::tolerances);
  visitor.number({"ground_truth_tolerance", 1e-9, 1e6, "px",
                  "Error up to which a putative match counts as an inlier of the ground truth"},
                 &EvaluatorParameters::ground_truth_tolerance);
  visitor.integer({"subscriber_queue_size", 1, 1000, "-",
                   "Messages of each topic that wait to be received; receiving is quick"},
                  &EvaluatorParameters::subscriber_queue_size);
}

void EvaluatorParameters::check() const {
  OptionSet::check();
  toleranceList();
}

std::vector<double> EvaluatorParameters::toleranceList() const {
  std::vector<double> values;
  for (const std::string& text : core::splitList(tolerances)) {
    values.push_back(core::parseNumber(text, "tolerances"));
    if (!(std::isfinite(values.back()) && values.back() > 0)) {
      throw std::invalid_argument("tolerances has " + text + ", which is not a positive number");
    }
  }
  if (values.empty()) throw std::invalid_argument("tolerances has no number");
  return values;
}

void RigMonitorParameters::visit(OptionVisitor& visitor) const {
  using P = RigMonitorParameters;
  RigMonitorOptions::visit(visitor);
  visitor.number({"report_period", 0.01, 1e6, "s", "Time between two messages on rig_state, by the stamps"},
                 &P::report_period);
  visitor.text("output_folder",
               "Folder in which left.yaml and right.yaml, the corrected calibrations, are written while the "
               "state is a warning or an error; empty = none",
               &P::output_folder);
  visitor.integer({"subscriber_queue_size", 1, 1000, "-",
                   "Messages of each topic that wait to be received; receiving is quick"},
                  &P::subscriber_queue_size);
}

void FeatureChoice::visit(OptionVisitor& visitor) const {
  visitor.text("features", "Detector+descriptor: one of these, or any other pairing",
               &FeatureChoice::features);
}

std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> liveFeatureAlgorithms() {
  static const core::OptionMap live_defaults = {{"max_features", "1000"}};
  auto algorithms = core::featureAlgorithms();
  for (auto& [name, options] : algorithms) core::setOptionsWherePresent(*options, live_defaults, name);
  return algorithms;
}

void RegionParameters::visit(OptionVisitor& visitor) const {
  using P = RegionParameters;
  constexpr double kMax = 100000;
  visitor.integer(
      {"x", 0, kMax, "px", "Left edge of the part of the images in which features are looked for"}, &P::x);
  visitor.integer({"y", 0, kMax, "px", "Upper edge of that part"}, &P::y);
  visitor.integer({"width", 0, kMax, "px", "Width of that part; 0 = up to the right edge of the image"},
                  &P::width);
  visitor.integer({"height", 0, kMax, "px", "Height of that part; 0 = down to the lower edge of the image"},
                  &P::height);
}

void MatcherChoice::visit(OptionVisitor& visitor) const {
  using P = MatcherChoice;
  visitor.text("matcher",
               "Matcher: descriptors compares descriptors; package/Class is a matcher of another package",
               &P::matcher);
  visitor.text("options", "Options of a matcher of another package: name=value, comma-separated",
               &P::options);
}

void SelectorChoice::visit(OptionVisitor& visitor) const {
  using P = SelectorChoice;
  visitor.text(
      "selector",
      "Algorithm that decides which matches are correct, or package/Class of a selector from another package",
      &P::selector);
  visitor.text("preset",
               "Named set of option values of the chosen selector, empty for the default values; choosing "
               "one sets the "
               "parameters of the selector that do not change at the same time",
               &P::preset);
  visitor.text(
      "options",
      "Options of the chosen selector that are no parameters of their own: name=value, comma-separated",
      &P::options);
  visitor.number({"max_seconds", 0, 1e6, "s",
                  "Time limit of a selection, after which the best result so far counts; 0 = none"},
                 &P::max_seconds);
  visitor.flag("label_motion",
               "Find out which groups of matches move by themselves, and publish their matches on moving",
               &P::label_motion);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the random numbers of every selector that draws any"},
                  &P::seed);
}

void TrackerChoice::visit(OptionVisitor& visitor) const {
  using P = TrackerChoice;
  visitor.text("selector",
               "Selector that decides which lost tracks were found again: a name or name:preset, or "
               "package/Class of another package",
               &P::selector);
  visitor.integer({"min_age", 1, 1000000, "frames", "Tracks that were seen less often are not published"},
                  &P::min_age);
}

std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> nodeletParameters() {
  std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> result;
  result.emplace_back("FeatureMatcher", std::make_unique<FeatureMatcherParameters>());
  result.emplace_back("Matcher", std::make_unique<MatcherParameters>());
  result.emplace_back("Selector", std::make_unique<SelectorParameters>());
  result.emplace_back("Tracker", std::make_unique<TrackerParameters>());
  result.emplace_back("TrackViewer", std::make_unique<TrackViewerParameters>());
  result.emplace_back("MatchViewer", std::make_unique<MatchViewerParameters>());
  result.emplace_back("Evaluator", std::make_unique<EvaluatorParameters>());
  result.emplace_back("RigMonitor", std::make_unique<RigMonitorParameters>());
  return result;
}

}  // namespace corrsel
