// The reports of LiveDiagnostics on /diagnostics about flows that the tests define.

#include "ros/live/live_diagnostics.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace corrsel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::chrono::seconds kPatience(20);  // generous: the machine may be busy

/// The newest status of every name.
class Reader {
 public:
  Reader() : subscriber_(ros::NodeHandle().subscribe("/diagnostics", 100, &Reader::receive, this)) {}

  /// Waits for a status that fulfils the condition. @return the newest one of that name, whether it does or
  /// not
  DiagnosticStatus waitFor(const std::string& name,
                           const std::function<bool(const DiagnosticStatus&)>& condition) {
    std::unique_lock<std::mutex> lock(mutex_);
    arrived_.wait_for(lock, kPatience, [&] { return statuses_.count(name) && condition(statuses_[name]); });
    return statuses_[name];
  }

  std::string waitForValue(const std::string& name, const std::string& key, const std::string& value) {
    return valueOf(waitFor(name, [&](const auto& status) { return valueOf(status, key) == value; }), key);
  }

  static std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& item : status.values) {
      if (item.key == key) return item.value;
    }
    return "(absent)";
  }

 private:
  void receive(const diagnostic_msgs::DiagnosticArrayConstPtr& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const DiagnosticStatus& status : message->status) statuses_[status.name] = status;
    arrived_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<std::string, DiagnosticStatus> statuses_;
  ros::Subscriber subscriber_;
};

/// A made-up node: its counts are polled twenty times a second.
class LiveDiagnosticsTest : public ::testing::Test {
 protected:
  std::unique_ptr<LiveDiagnostics> make(const std::string& node, SelectorParameters parameters = {}) {
    parameters.diagnostic_period = 0.05;
    return std::make_unique<LiveDiagnostics>(
        ros::NodeHandle(), ros::NodeHandle("/" + node), "/" + node, parameters, [this] {
          LiveDiagnostics::Flow flow;
          flow.wanted = wanted_;
          flow.inputs = {{"left", left_ += left_step_}, {"right", right_ += right_step_}};
          flow.done = done_ += done_step_;
          flow.dropped = dropped_ += dropped_step_;
          return flow;
        });
  }

  Reader reader_;
  std::atomic<bool> wanted_{true};
  std::atomic<std::size_t> left_{0}, right_{0}, done_{0}, dropped_{0};
  std::atomic<std::size_t> left_step_{0}, right_step_{0}, done_step_{0}, dropped_step_{0};
};

TEST_F(LiveDiagnosticsTest, KeepingUpIsOk) {
  left_step_ = right_step_ = done_step_ = 1;
  const auto diagnostics = make("fine");
  diagnostics->set("selector", "lpm:v2");
  for (int i = 1; i <= 100; ++i) diagnostics->finished({{"select", 0.001 * i}, {"detect", std::nan("")}});
  diagnostics->inlierRatio(0.5);
  diagnostics->inlierRatio(std::nan(""));
  for (const double confidence : {0.0, 7.25, 40.0}) diagnostics->confidence(confidence);
  EXPECT_EQ(reader_.waitForValue("fine: processing", "selector", "lpm:v2"), "lpm:v2");
  const DiagnosticStatus status = reader_.waitFor(
      "fine: processing", [](const auto& s) { return Reader::valueOf(s, "drop ratio") == "0.000"; });
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_EQ(Reader::valueOf(status, "p50 select [s]"), "0.05050");
  EXPECT_EQ(Reader::valueOf(status, "p95 select [s]"), "0.09505");
  EXPECT_EQ(Reader::valueOf(status, "p50 detect [s]"), "(absent)");
  EXPECT_EQ(Reader::valueOf(status, "inlier ratio"), "0.500");
  EXPECT_EQ(Reader::valueOf(status, "p50 confidence"), "7.2");
  EXPECT_EQ(Reader::valueOf(status, "last failure"), "none");
  const DiagnosticStatus input = reader_.waitFor("fine: input", [](const auto& s) {
    return Reader::valueOf(s, "left rate [Hz]").find("unknown") == std::string::npos &&
           Reader::valueOf(s, "left rate [Hz]") != "(absent)";
  });
  EXPECT_EQ(input.level, DiagnosticStatus::OK);
  const double rate = std::stod(Reader::valueOf(input, "left rate [Hz]"));
  EXPECT_GT(rate, 2.0);  // 20 on an idle machine
  EXPECT_LT(rate, 40.0);
}

TEST_F(LiveDiagnosticsTest, DropsWarnAndBecomeErrors) {
  left_step_ = right_step_ = 2;
  done_step_ = dropped_step_ = 1;
  const auto diagnostics = make("dropping");
  const auto warned = reader_.waitFor("dropping: processing", [](const auto& s) { return s.level != 0; });
  EXPECT_EQ(warned.level, DiagnosticStatus::WARN);
  EXPECT_NE(warned.message.find("drops 50 %"), std::string::npos) << warned.message;
  dropped_step_ = 1000;
  EXPECT_EQ(reader_.waitFor("dropping: processing", [](const auto& s) { return s.level == 2; }).level,
            DiagnosticStatus::ERROR);
}

TEST_F(LiveDiagnosticsTest, ASilentCameraIsNamedAndForgivenWhenItComesBack) {
  left_step_ = done_step_ = 1;
  SelectorParameters parameters;
  parameters.warn_silence = 0.3;
  parameters.error_silence = 1.0;
  const auto diagnostics = make("silent", parameters);
  const auto warned = reader_.waitFor("silent: input", [](const auto& s) { return s.level == 1; });
  EXPECT_NE(warned.message.find("no right for"), std::string::npos) << warned.message;
  EXPECT_EQ(warned.message.find("no left"), std::string::npos) << warned.message;
  EXPECT_EQ(reader_.waitFor("silent: input", [](const auto& s) { return s.level == 2; }).level, 2);
  right_step_ = 1;
  EXPECT_EQ(reader_.waitFor("silent: input", [](const auto& s) { return s.level == 0; }).level, 0);
}

TEST_F(LiveDiagnosticsTest, NobodyWantsNothingIsSilent) {
  wanted_ = false;
  SelectorParameters parameters;
  parameters.warn_silence = 0.1;
  parameters.error_silence = 0.2;
  const auto diagnostics = make("idle", parameters);
  const auto status = reader_.waitFor(
      "idle: input", [](const auto& s) { return s.message.find("idle") != std::string::npos; });
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_NE(status.message.find("idle"), std::string::npos) << status.message;
}

TEST_F(LiveDiagnosticsTest, FailuresWarnForAWhileAndAreRemembered) {
  left_step_ = right_step_ = done_step_ = 1;
  const auto diagnostics = make("failing");
  diagnostics->failed("encoding '32FC1' is not supported");
  auto status = reader_.waitFor("failing: processing", [](const auto& s) { return s.level == 1; });
  EXPECT_NE(status.message.find("32FC1"), std::string::npos) << status.message;
  status = reader_.waitFor("failing: processing", [](const auto& s) { return s.level == 0; });
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_EQ(Reader::valueOf(status, "last failure"), "encoding '32FC1' is not supported");
  EXPECT_EQ(Reader::valueOf(status, "failures"), "1");
}

TEST_F(LiveDiagnosticsTest, ImagesThatSufferWarnForAWhile) {
  left_step_ = right_step_ = done_step_ = 1;
  const auto diagnostics = make("dark");
  diagnostics->imageFaults("the left image is dark");
  diagnostics->imageFaults("");
  auto status = reader_.waitFor("dark: processing", [](const auto& s) { return s.level == 1; });
  EXPECT_NE(status.message.find("the left image is dark"), std::string::npos) << status.message;
  status = reader_.waitFor("dark: processing", [](const auto& s) { return s.level == 0; });
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
}

TEST_F(LiveDiagnosticsTest, LatencyAndInlierRatioHaveLimits) {
  left_step_ = right_step_ = done_step_ = 1;
  SelectorParameters parameters;
  parameters.warn_latency = 0.1;
  parameters.error_latency = 0.5;
  const auto diagnostics = make("late", parameters);
  diagnostics->limitInlierRatio(0.1, 0.05);
  diagnostics->finished({{"age", 0.2}});
  auto status = reader_.waitFor("late: processing", [](const auto& s) { return s.level == 1; });
  EXPECT_NE(status.message.find("0.200 s old"), std::string::npos) << status.message;
  diagnostics->inlierRatio(0.01);
  status = reader_.waitFor("late: processing", [](const auto& s) { return s.level == 2; });
  EXPECT_NE(status.message.find("1.0 % of the matches"), std::string::npos) << status.message;
}

TEST_F(LiveDiagnosticsTest, LimitsOfZeroAreOff) {
  left_step_ = 1;
  dropped_step_ = 1;
  SelectorParameters parameters;
  parameters.warn_silence = parameters.error_silence = 0;
  parameters.warn_drop_ratio = parameters.error_drop_ratio = 0;
  const auto diagnostics = make("quiet", parameters);
  diagnostics->inlierRatio(0.0);
  diagnostics->finished({{"age", 1e9}});
  const auto status = reader_.waitFor(
      "quiet: processing", [](const auto& s) { return Reader::valueOf(s, "drop ratio") == "1.000"; });
  EXPECT_EQ(Reader::valueOf(status, "drop ratio"), "1.000");
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << status.message;
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_diagnostics_test");
  ros::NodeHandle nh;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
