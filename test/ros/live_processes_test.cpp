// What only shows between processes: killed managers and masters, cameras that die, clocks that jump back,
// full disks.

#include <gtest/gtest.h>
#include <ros/network.h>
#include <rosbag/bag.h>
#include <sys/mount.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpc.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "base/text.h"
#include "child.h"
#include "live_support.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;
using testing::Child;
using testing::imageMsg;
using testing::Inbox;
using testing::texture;
using testing::waitFor;
using namespace std::chrono_literals;

constexpr auto kProcessPatience = 90s;  // processes start slowly on a busy machine

/// Process number of a node; 0 where it is not there.
int pidOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri;
  request[0] = "/live_processes_test";
  request[1] = node;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::master::execute("lookupNode", request, response, uri, false) ||
      !ros::network::splitURI(uri, host, port)) {
    return 0;
  }
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = "/live_processes_test";
  const bool answered = client.execute("getPid", caller, answer) && answer.size() == 3;
  client.close();
  return answered ? static_cast<int>(answer[2]) : 0;
}

std::vector<std::string> liveLaunch(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"roslaunch",
                                    "corrsel",
                                    "live.launch",
                                    "left_image:=left/image",
                                    "right_image:=right/image",
                                    "features:=orb+orb",
                                    "selector:=gms",
                                    "viewer:=false"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

/// load_test lies beside this program; rosrun would search the package for it every time.
std::string loadTestProgram() { return fs::read_symlink("/proc/self/exe").replace_filename("load_test"); }

/// load_test with the images of the test.
std::vector<std::string> loadTest(const std::string& images, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {loadTestProgram(), "--images", images};
  words.insert(words.end(), arguments.begin(), arguments.end());
  if (std::find(words.begin(), words.end(), "--wait") == words.end())
    words.insert(words.end(), {"--wait", "60"});
  return words;
}

class LiveProcesses : public ::testing::Test {
 protected:
  LiveProcesses() {
    fs::create_directories(folder_);
    cv::imwrite(left(), texture(320, 240, 1));
    cv::imwrite(right(), texture(320, 240, 1));
  }
  ~LiveProcesses() override { fs::remove_all(folder_); }

  std::string left() const { return (folder_ / "left_0.png").string(); }
  std::string right() const { return (folder_ / "right_0.png").string(); }
  std::string log(const std::string& name) const { return (folder_ / (name + ".log")).string(); }
  std::string logText(const std::string& name) const { return core::readTextFile(log(name)); }

  /// Cameras and a consumer in this process.
  void openCameras() {
    left_ = nh_.advertise<sensor_msgs::Image>("left/image", 5);
    right_ = nh_.advertise<sensor_msgs::Image>("right/image", 5);
    selections_ = std::make_unique<Inbox<Selection>>(nh_, "selection");
  }

  /// Sends pairs until one of them has been processed.
  bool answers() {
    std::vector<ros::Time> probes;
    const cv::Mat image = texture(320, 240, 1);
    return waitFor(
        [&] {
          const ros::WallTime now = ros::WallTime::now();
          probes.emplace_back(now.sec, now.nsec);
          left_.publish(imageMsg(probes.back(), "left_camera_optical", "mono8", image));
          right_.publish(imageMsg(probes.back(), "right_camera_optical", "mono8", image));
          std::this_thread::sleep_for(50ms);
          return std::any_of(probes.begin(), probes.end(),
                             [this](const ros::Time& probe) { return selections_->has(probe); });
        },
        kProcessPatience);
  }

  ros::NodeHandle nh_;
  const fs::path folder_ = fs::temp_directory_path() / ("corrsel_live_processes_" + std::to_string(getpid()));
  ros::Publisher left_, right_;
  std::unique_ptr<Inbox<Selection>> selections_;
};

TEST_F(LiveProcesses, AKilledManagerComesBackWithItsNodelets) {
  openCameras();
  Child launch(liveLaunch({"respawn:=true"}));
  ASSERT_TRUE(answers());
  // Again right after the first result, because that may have killed it.
  for (int i = 0; i < 3; ++i) {
    const int before = pidOf("/corrsel_manager");
    ASSERT_GT(before, 0);
    ASSERT_EQ(kill(before, SIGKILL), 0);
    EXPECT_TRUE(answers());
    const int after = pidOf("/corrsel_manager");
    EXPECT_GT(after, 0);
    EXPECT_NE(after, before);
  }
}

TEST_F(LiveProcesses, StandaloneNodeletsAreRespawnedOneByOne) {
  openCameras();
  Child launch(liveLaunch({"respawn:=true", "standalone:=true"}));
  ASSERT_TRUE(answers());
  for (const char* const node : {"/feature_matcher", "/selector"}) {
    const int before = pidOf(node);
    ASSERT_GT(before, 0) << node;
    ASSERT_EQ(kill(before, SIGKILL), 0);
    EXPECT_TRUE(answers()) << node;
    EXPECT_NE(pidOf(node), before) << node;
  }
}

TEST_F(LiveProcesses, ACameraProcessDiesAndAnotherTakesOver) {
  Child launch(liveLaunch({}));
  {
    Child camera(loadTest(folder_.string(), {"--seconds", "600", "--rate", "20"}), {}, log("first"));
    ASSERT_TRUE(
        waitFor([&] { return logText("first").find("processed by") != std::string::npos; }, kProcessPatience))
        << logText("first");
    camera.signalAll(SIGKILL);
    ASSERT_TRUE(camera.wait(20s));
  }
  Child camera(loadTest(folder_.string(), {"--seconds", "2", "--rate", "20", "--max-drop-ratio", "0.5"}), {},
               log("second"));
  ASSERT_TRUE(camera.wait(kProcessPatience)) << logText("second");
  EXPECT_EQ(camera.code(), 0) << logText("second");
}

TEST_F(LiveProcesses, ABagInALoopTurnsTheClockBack) {
  const std::string path = (folder_ / "loop.bag").string();
  const ros::Time start(100.0);
  {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    const cv::Mat image = texture(320, 240, 1);
    for (int i = 0; i < 10; ++i) {
      const ros::Time stamp = start + ros::Duration(0.1 * i);
      bag.write("/left/image", stamp, imageMsg(stamp, "left_camera_optical", "mono8", image));
      bag.write("/right/image", stamp, imageMsg(stamp, "right_camera_optical", "mono8", image));
    }
  }
  ros::param::set("/use_sim_time", true);
  selections_ = std::make_unique<Inbox<Selection>>(nh_, "selection");
  // A frame of the middle: the last left image may be overtaken by the first of the next round.
  const ros::Time middle = start + ros::Duration(0.5);
  const auto times_answered = [&] {
    const auto items = selections_->all();
    return std::count_if(items.begin(), items.end(),
                         [&](const auto& item) { return item.message->header.stamp == middle; });
  };
  {
    Child launch(liveLaunch({}));
    Child player({"rosbag", "play", "--quiet", "--clock", "--loop", path});
    EXPECT_TRUE(waitFor([&] { return times_answered() >= 4; }, kProcessPatience)) << times_answered();
    // Nodelets can still be asked and changed while the clock jumps.
    EXPECT_EQ(testing::configure("selector", {{"selector", "lpm"}})["selector"], "lpm");
    EXPECT_TRUE(waitFor([&] { return selections_->all().back().message->selector == "lpm"; }));
  }
  ros::param::del("/use_sim_time");
}

TEST_F(LiveProcesses, FramesFlowWhileTheMasterIsAway) {
  const std::string port = std::to_string(20000 + getpid() % 20000);
  const std::vector<std::pair<std::string, std::string>> environment = {
      {"ROS_MASTER_URI", "http://localhost:" + port}};
  const std::vector<std::string> master = {"rosmaster", "--core", "-p", port};
  const auto answers_at_port = [&port] {
    XmlRpc::XmlRpcClient client("localhost", std::stoi(port));
    XmlRpc::XmlRpcValue caller, answer;
    caller[0] = "/live_processes_test";
    return client.execute("getPid", caller, answer);
  };
  const auto answers_load = [&] {
    Child probe(loadTest(folder_.string(), {"--seconds", "0.1", "--wait", "20"}), environment, log("probe"));
    return probe.wait(60s) && probe.code() == 0;
  };
  auto first = std::make_unique<Child>(master, environment, log("master"));
  ASSERT_TRUE(waitFor(answers_at_port)) << logText("master");
  auto launch = std::make_unique<Child>(liveLaunch({}), environment);
  ASSERT_TRUE(waitFor(answers_load, kProcessPatience)) << logText("probe");
  {
    Child load(loadTest(folder_.string(),
                        {"--seconds", "12", "--rate", "10", "--interval", "2", "--max-drop-ratio", "0.2"}),
               environment, log("load"));
    ASSERT_TRUE(
        waitFor([&] { return logText("load").find("processed by") != std::string::npos; }, kProcessPatience));
    first.reset();  // gone for good, with all it knew
    std::this_thread::sleep_for(1s);
    first = std::make_unique<Child>(master, environment, log("master"));
    ASSERT_TRUE(waitFor(answers_at_port)) << logText("master");
    ASSERT_TRUE(load.wait(kProcessPatience));
    EXPECT_EQ(load.code(), 0) << logText("load");
  }
  // A new master knows no node, so everything is launched again, as ROS requires.
  launch.reset();
  launch = std::make_unique<Child>(liveLaunch({}), environment);
  EXPECT_TRUE(waitFor(answers_load, kProcessPatience)) << logText("probe");
}

TEST_F(LiveProcesses, AFullDiskEndsTheRecordingOnly) {
  const fs::path disk = folder_ / "disk";
  fs::create_directories(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=1m") != 0) {
    GTEST_SKIP() << "mounting a small disk is not allowed here";
  }
  {
    Child launch(liveLaunch({"record:=true", "bag:=" + (disk / "full").string()}), {}, log("launch"));
    Child load(loadTest(folder_.string(), {"--seconds", "4", "--rate", "20", "--max-drop-ratio", "0.2"}), {},
               log("load"));
    ASSERT_TRUE(load.wait(kProcessPatience));
    EXPECT_EQ(load.code(), 0) << logText("load");
    EXPECT_TRUE(launch.running());
    // The recorder reports why there is no recording.
    EXPECT_TRUE(waitFor([&] { return logText("launch").find("space") != std::string::npos; }))
        << logText("launch");
  }
  umount2(disk.c_str(), MNT_DETACH);
}

TEST_F(LiveProcesses, LoadTestExplainsItself) {
  const auto outcome = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {loadTestProgram()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    Child child(words, {}, log("load"));
    EXPECT_TRUE(child.wait(kProcessPatience));
    return child.code();
  };
  EXPECT_EQ(outcome({"--help"}), 0);
  EXPECT_NE(logText("load").find("--max-drop-ratio"), std::string::npos);
  for (const auto& [part, arguments] :
       std::vector<std::pair<std::string, std::vector<std::string>>>{{"--rate", {"--rate", "fast"}},
                                                                     {"between", {"--rate", "0"}},
                                                                     {"needs a value", {"--seconds"}},
                                                                     {"--no-such", {"--no-such", "1"}},
                                                                     {"mono8", {"--encoding", "yuv"}},
                                                                     {"640x480", {"--size", "big"}},
                                                                     {"lpm", {"--selectors", "gms,magic"}}}) {
    EXPECT_EQ(outcome(arguments), 2) << part;
    EXPECT_NE(logText("load").find(part), std::string::npos) << logText("load");
  }
  EXPECT_EQ(outcome({"--images", "/no/such/file.png,/no/other.png"}), 1);
  EXPECT_NE(logText("load").find("/no/such/file.png"), std::string::npos) << logText("load");
  // No nodelet runs.
  EXPECT_EQ(outcome({"--images", folder_.string(), "--wait", "1"}), 1);
  EXPECT_NE(logText("load").find("no node subscribes to /left/image"), std::string::npos) << logText("load");
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_processes_test");
  ros::NodeHandle nh;  // keeps ROS running from the first to the last test
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
