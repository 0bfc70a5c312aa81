#include "ros/live/nodelet_parameters.h"

#include <cmath>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/features/extractor.h"

namespace corrsel {

using core::OptionVisitor;

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
  visitor.choice("images",
                 {{Images::kAuto, "auto", "Rectified if the name of their topic contains image_rect"},
                  {Images::kRaw, "raw", "K and D of camera_info hold"},
                  {Images::kRectified, "rectified", "P of camera_info holds"}},
                 "Whether the images are rectified, which camera_info does not say", &P::images);
  visitor.text("image_transport",
               "Transport of the images: raw, compressed, or the name of an installed plug-in",
               &P::image_transport);
  visitor.flag("use_mask", "Take masks from left/mask and right/mask, or from mask in sequence mode",
               &P::use_mask);
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
  visitCommon(visitor, "Subscribe to the images only while somebody subscribes to the matches");
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

void MatchViewerParameters::visit(OptionVisitor& visitor) const {
  using P = MatchViewerParameters;
  visitor.flag("lazy", "Subscribe and draw only while somebody subscribes to the drawings", &P::lazy);
  visitor.text("image_transport",
               "Transport of the images: raw, compressed, or the name of an installed plug-in",
               &P::image_transport);
  visitor.integer({"subscriber_queue_size", 1, 1000, "-",
                   "Messages of each topic that wait to be received; receiving is quick"},
                  &P::subscriber_queue_size);
  visitor.integer(
      {"cache_size", 1, 100000, "-", "Pairs that are kept until all messages with their stamp have arrived"},
      &P::cache_size);
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
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the random numbers of every selector that draws any"},
                  &P::seed);
}

std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> nodeletParameters() {
  std::vector<std::pair<std::string, std::unique_ptr<core::OptionSet>>> result;
  result.emplace_back("FeatureMatcher", std::make_unique<FeatureMatcherParameters>());
  result.emplace_back("Matcher", std::make_unique<MatcherParameters>());
  result.emplace_back("Selector", std::make_unique<SelectorParameters>());
  result.emplace_back("MatchViewer", std::make_unique<MatchViewerParameters>());
  result.emplace_back("Evaluator", std::make_unique<EvaluatorParameters>());
  result.emplace_back("RigMonitor", std::make_unique<RigMonitorParameters>());
  return result;
}

}  // namespace corrsel
