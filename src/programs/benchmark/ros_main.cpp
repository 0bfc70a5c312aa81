// The benchmark of the ROS package: it also reads bags in its own process, publishes its progress and takes
// selectors of other packages. It works with and without a ROS master.

#include <ros/package.h>
#include <ros/ros.h>

#include <cstdlib>
#include <optional>

#include "base/text.h"
#include "corrsel/ros/selector_plugins.h"
#include "programs/benchmark/node_name.h"
#include "programs/benchmark/run.h"
#include "programs/benchmark/topic_reporter.h"
#include "ros/bags/open_bag.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

/// Names the node and, where there is a master, registers it.
/// @return keeps the node registered
std::optional<ros::NodeHandle> initRos(int argc, char** argv, const core::Shard& shard) {
  // The parts of a run may run at the same time, so each of them has its own node name.
  const std::string usual = shard.count == 1 ? "benchmark" : "benchmark_" + std::to_string(shard.index + 1);
  const NodeName name({argv + 1, argv + argc}, usual);
  // ROS removes its remappings from this copy; names like dataset:=vgg are arguments of this program.
  std::vector<char*> ros_argv = {argv[0]};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool replaced = name.chosen() && word.compare(0, 8, "__name:=") == 0;
    if (word.compare(0, 2, "__") == 0 && !replaced) ros_argv.push_back(argv[i]);
  }
  int ros_argc = static_cast<int>(ros_argv.size());
  ros::init(ros_argc, ros_argv.data(), name.chosen().value_or(usual), ros::init_options::NoSigintHandler);
  if (!name.note().empty()) std::cout << "note: " << name.note() << std::endl;
  std::optional<ros::NodeHandle> node;
  if (ros::master::check()) node.emplace("~");
  return node;
}

BagTopics topicsOf(const std::map<std::string, std::string>& given) {
  BagTopics topics;
  const auto text = [&given](const char* name, std::string& topic) {
    const auto found = given.find(name);
    if (found != given.end()) topic = found->second;
  };
  text("left", topics.left);
  text("right", topics.right);
  text("left_info", topics.left_info);
  text("right_info", topics.right_info);
  text("ground_truth", topics.ground_truth);
  text("correspondences", topics.correspondences);
  text("images", topics.images);
  std::string difference;
  text("max_stamp_difference", difference);
  if (!difference.empty()) {
    topics.max_stamp_difference = core::parseNumber(difference, "max_stamp_difference");
  }
  return topics;
}

class RosFront : public BenchmarkFront {
 public:
  RosFront(int argc, char** argv) : argc_(argc), argv_(argv) { enableSelectorPlugins(); }

  std::string program() const override { return "benchmark"; }
  fs::path runsFolder() const override {
    const char* const ros_home = std::getenv("ROS_HOME");
    const char* const home = std::getenv("HOME");
    const fs::path root =
        ros_home && *ros_home ? fs::path(ros_home) : fs::path(home && *home ? home : ".") / ".ros";
    return root / "corrsel";
  }
  std::string argument(const std::string& name, const std::string& value) const override {
    return name + ":=" + value;
  }
  std::string fetchCommand() const override { return "rosrun corrsel fetch_samples.sh"; }
  std::string reportCommand() const override { return "rosrun corrsel report.py"; }
  fs::path fetchScript() const override {
    const fs::path in_sources = fs::path(ros::package::getPath("corrsel")) / "scripts/fetch_samples.sh";
    return fs::exists(in_sources) ? in_sources : BenchmarkFront::fetchScript();
  }
  std::vector<std::string> selectorPlugins() const override { return corrsel::selectorPlugins(); }
  std::vector<std::string> selectorPluginProblems() const override {
    return corrsel::selectorPluginProblems();
  }
  OpenedBag openBag(const std::string& path, const core::BenchmarkConfig& config) const override;
  std::unique_ptr<Reporter> startReporter(const Arguments& arguments) override {
    node_ = initRos(argc_, argv_, arguments.shard);
    if (!node_) return BenchmarkFront::startReporter(arguments);
    return std::make_unique<TopicReporter>(arguments.verbose, arguments.output_dir, *node_);
  }

 private:
  int argc_;
  char** argv_;
  std::optional<ros::NodeHandle> node_;  ///< keeps the node registered
};

OpenedBag RosFront::openBag(const std::string& path, const core::BenchmarkConfig& config) const {
  std::unique_ptr<BagSource> source = corrsel::openBag(path, topicsOf(config.bag_topics));
  std::vector<std::string> notes = source->notes();
  if (!source->evaluatedByCalibration().empty()) {
    std::vector<std::string> tolerances;
    for (const double tau : config.tolerances) tolerances.push_back(core::formatNumber(tau));
    notes.push_back(source->evaluatedByCalibration() + " (tolerances " + core::joinList(tolerances, ", ") +
                    " px; inliers within " + core::formatNumber(config.ground_truth_tolerance) +
                    " px): an outlier near its epipolar line counts as correct, so precision is an upper "
                    "bound");
  }
  return {std::move(source), std::move(notes)};
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  corrsel::RosFront front(argc, argv);
  return corrsel::runBenchmark({argv + 1, argv + argc}, front);
}
