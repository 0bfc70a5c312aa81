// Flow: newest first, nothing blocks, nothing is copied, nothing is done without a subscriber.

#include <gtest/gtest.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpc.h>

#include <atomic>
#include <cmath>
#include <future>
#include <map>
#include <string>
#include <vector>

#include "../core/test_support.h"
#include "add_test_selector.h"
#include "base/stopwatch.h"
#include "corrsel/evaluation/statistics.h"
#include "held_selector.h"
#include "live_fixture.h"
#include "passing_object.h"

namespace corrsel {
namespace {

using testing::configure;
using testing::imageMsg;
using testing::kSanitized;
using testing::Live;
using testing::texture;
using testing::waitFor;
using namespace std::chrono_literals;

double age(const ros::Time& stamp, const ros::WallTime& at) {
  return (at - ros::WallTime(stamp.sec, stamp.nsec)).toSec();
}

ros::Time wallStamp() {
  const ros::WallTime now = ros::WallTime::now();
  return {now.sec, now.nsec};
}

Correspondences madeUpMatches(const ros::Time& stamp, std::size_t n, std::uint64_t seed = 1) {
  core::testing::SceneOptions options;
  options.n = n;
  options.seed = seed;
  PairInfo info;
  info.header.stamp = info.right_stamp = stamp;
  info.header.frame_id = "left_camera_optical";
  info.right_frame_id = "right_camera_optical";
  info.features = "given";
  return toMsg(core::testing::homographyScene(options).matches, info);
}

/// Bytes that this process received over its connections, by topic, and messages: messages handed over inside
/// the process have no bytes.
struct Received {
  int bytes = 0, messages = 0;
};
std::map<std::string, Received> received() {
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  XmlRpc::XmlRpcValue request, answer;
  request[0] = "/live_test";
  std::map<std::string, Received> topics;
  if (!client.execute("getBusStats", request, answer)) return topics;
  // Publications, subscriptions and services, without the status that other calls begin with.
  XmlRpc::XmlRpcValue& subscriptions = answer[1];
  for (int i = 0; i < subscriptions.size(); ++i) {
    Received& topic = topics[std::string(subscriptions[i][0])];
    XmlRpc::XmlRpcValue& connections = subscriptions[i][1];
    if (connections.getType() != XmlRpc::XmlRpcValue::TypeArray) continue;  // none
    for (int k = 0; k < connections.size(); ++k) {
      topic.bytes += static_cast<int>(connections[k][1]);
      topic.messages += static_cast<int>(connections[k][2]);
    }
  }
  client.close();
  return topics;
}

class LiveFlow : public Live {
 protected:
  /// A number of matches for which `st` takes about as long as asked for, and its time.
  double findSlowLoad(double seconds, std::size_t* n) {
    set(selector() + "/max_seconds", 0.0);
    startSelector();
    configure(selector(), {{"selector", "st"}});
    double taken = 0.0;
    for (*n = 1000; *n < 100000; *n = *n * 3 / 2) {
      const ros::Time stamp = nextStamp();
      correspondences_.publish(madeUpMatches(stamp, *n));
      const SelectionConstPtr selection = selections_->wait(stamp);
      if (!selection) return 0.0;
      taken = selection->seconds.select;
      if (taken >= seconds) break;
    }
    return taken;
  }
};

TEST_F(LiveFlow, MovingMatchesHaveATopicOfTheirOwn) {
  startSelector();
  configure(selector(), {{"selector", "auto"}});
  testing::Inbox<Correspondences> moving(nh_, "moving");
  ASSERT_TRUE(waitFor([&] { return moving.connected(); }));
  ros::Time stamp = nextStamp();
  correspondences_.publish(testing::passingObject(stamp));
  ASSERT_TRUE(selections_->wait(stamp));
  EXPECT_FALSE(moving.has(stamp));

  configure(selector(), {{"label_motion", "true"}});
  stamp = nextStamp();
  correspondences_.publish(testing::passingObject(stamp));
  const CorrespondencesConstPtr found = moving.wait(stamp);
  const SelectionConstPtr selection = selections_->wait(stamp);
  ASSERT_TRUE(found && selection);
  EXPECT_NEAR(found->left_x.size(), testing::kObjectMatches, 2);
  EXPECT_EQ(found->header.frame_id, "left_optical");
  EXPECT_EQ(selection->motion.back(), Selection::GROUP_MOVING);
}

TEST_F(LiveFlow, NothingIsCopiedInsideAManager) {
  start();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(ask(good_, good_));
  std::map<std::string, Received> topics = received();
  for (const char* const name : {"left/image", "right/image", "correspondences", "matches", "selection"}) {
    const Received& topic = topics[nh_.resolveName(name)];
    EXPECT_GE(topic.messages, 5) << name;
    EXPECT_EQ(topic.bytes, 0) << name << " was serialised";
  }
}

TEST_F(LiveFlow, AnswersAreOnesOwnToKeep) {
  start();
  const ros::Time first = nextStamp();
  send(first, good_, good_);
  const CorrespondencesConstPtr kept = matches_->wait(first);
  ASSERT_TRUE(kept);
  const Correspondences copy = *kept;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(ask(texture(320, 240, 7), good_));
  EXPECT_EQ(kept->left_x, copy.left_x);  // a message is never touched once published
  EXPECT_EQ(kept->header.stamp, first);
}

TEST_F(LiveFlow, StampsFramesAndTimesAreThoseOfTheImages) {
  start();
  const ros::Time stamp = nextStamp();
  send(stamp, good_, good_);
  const SelectionConstPtr selection = selections_->wait(stamp);
  const CorrespondencesConstPtr matches = matches_->wait(stamp);
  ASSERT_TRUE(selection && matches);
  EXPECT_EQ(selection->header.frame_id, "left_camera_optical");
  EXPECT_EQ(selection->right_frame_id, "right_camera_optical");
  EXPECT_EQ(selection->right_stamp, stamp);
  EXPECT_EQ(matches->header.frame_id, "left_camera_optical");
  EXPECT_EQ(matches->left_x.size(), selection->n_selected);
  for (const double seconds :
       {selection->seconds.wait, selection->seconds.detect, selection->seconds.describe,
        selection->seconds.match, selection->seconds.select, selection->seconds.publish}) {
    EXPECT_GE(seconds, 0.0);  // and not NaN
    EXPECT_LT(seconds, 60.0);
  }
}

TEST_F(LiveFlow, SlowSelectorsAnswerTheNewest) {
  std::size_t n = 0;
  const double slow = findSlowLoad(0.15, &n);
  ASSERT_GT(slow, 0.15);
  // Five times faster than the selector.
  Correspondences message = madeUpMatches(ros::Time(), n);
  std::size_t sent = 0;
  ros::Time last;
  const core::Stopwatch watch;
  while (watch.seconds() < 12 * slow) {
    message.header.stamp = last = wallStamp();
    correspondences_.publish(boost::make_shared<Correspondences>(message));
    ++sent;
    std::this_thread::sleep_for(std::chrono::duration<double>(slow / 5));
  }
  ASSERT_TRUE(selections_->wait(last));
  double period = 0.0, oldest = 0.0;
  std::size_t answered = 0;
  ros::WallTime before;
  for (const auto& item : selections_->all()) {
    if (item.message->header.stamp < ros::Time(1e8)) continue;  // those that looked for the load
    ++answered;
    // The time between two results is the selector's period as this machine allows it at the moment.
    period = std::max(period, item.message->seconds.select);
    if (!before.isZero()) period = std::max(period, (item.arrival - before).toSec());
    before = item.arrival;
    oldest = std::max(oldest, age(item.message->header.stamp, item.arrival));
  }
  ASSERT_GE(answered, 3u);
  ASSERT_LT(answered, sent);
  std::printf("selector period at most %.3f s, oldest result %.3f s, %zu of %zu processed\n", period, oldest,
              answered, sent);
  EXPECT_LT(oldest, 2 * period);
  // Pairs without a result are counted.
  EXPECT_TRUE(waitFor([&] {
    const auto status = diagnostics_->of(selector(), "processing");
    return status.number("dropped") == static_cast<double>(sent - answered);
  })) << sent
      << " sent, " << answered << " processed\n"
      << diagnostics_->text();
}

TEST_F(LiveFlow, ReconfiguringDoesNotWaitForASlowSelection) {
  testing::addTestSelector<testing::HeldSelector>();
  startSelector();
  configure(selector(), {{"selector", testing::HeldSelector::kName}});
  const ros::Time stamp = nextStamp();
  {
    const testing::Hold hold;
    correspondences_.publish(madeUpMatches(stamp, 1000));
    ASSERT_TRUE(hold.waitForRun());
    EXPECT_EQ(configure(selector(), {{"selector", "gms"}})["selector"], "gms");
    EXPECT_TRUE(hold.running()) << "it waited";
  }
  const SelectionConstPtr selection = selections_->wait(stamp);
  ASSERT_TRUE(selection);
  EXPECT_EQ(selection->selector, testing::HeldSelector::kName);  // a run that has begun ends as it began
  const ros::Time next = nextStamp();
  correspondences_.publish(madeUpMatches(next, 1000));
  ASSERT_TRUE(selections_->wait(next));
  EXPECT_EQ(selections_->wait(next)->selector, "gms");
}

TEST_F(LiveFlow, TimeBudgetsEndSlowSelections) {
  std::size_t n = 0;
  const double slow = findSlowLoad(1.0, &n);
  ASSERT_GT(slow, 0.5);
  configure(selector(), {{"selector", "st"}}, {{"max_seconds", 0.1}});
  const ros::Time stamp = nextStamp();
  correspondences_.publish(madeUpMatches(stamp, n));
  const SelectionConstPtr selection = selections_->wait(stamp);
  ASSERT_TRUE(selection);
  // TOO_LARGE if the time did not even suffice for a first result.
  EXPECT_TRUE(selection->status == Selection::STATUS_TIME_LIMIT ||
              selection->status == Selection::STATUS_TOO_LARGE)
      << selection->message;
  EXPECT_LT(selection->seconds.select, slow);
  EXPECT_FALSE(selection->message.empty());
  // The node reports this.
  EXPECT_TRUE(waitFor([&] {
    const auto status = diagnostics_->of(selector(), "processing");
    return status.level > 0 || status.number("failures") > 0;
  })) << diagnostics_->text();
}

TEST_F(LiveFlow, UnloadingInMidSelectionIsClean) {
  std::size_t n = 0;
  const double slow = findSlowLoad(0.5, &n);
  ASSERT_GT(slow, 0.25);
  for (int i = 0; i < 3; ++i) {
    const ros::Time stamp = nextStamp();
    correspondences_.publish(madeUpMatches(stamp, n));
    correspondences_.publish(madeUpMatches(nextStamp(), n));  // and one that waits
    std::this_thread::sleep_for(std::chrono::duration<double>(slow / 4));
    EXPECT_TRUE(nodelets_->unload(selector()));
    loadSelector();
    ASSERT_TRUE(waitFor([&] {
      const ros::Time probe = nextStamp();
      correspondences_.publish(madeUpMatches(probe, 300));
      return waitFor([&] { return selections_->has(probe); }, 300ms);
    }));
  }
}

TEST_F(LiveFlow, UnloadingWhileFramesFlowIsClean) {
  start();
  std::atomic<bool> stop{false};
  std::thread camera([&] {
    while (!stop) {
      send(nextStamp(), good_, good_);
      std::this_thread::sleep_for(3ms);
    }
  });
  for (int i = 0; i < 6; ++i) {
    const std::size_t before = selections_->size();
    EXPECT_TRUE(waitFor([&] { return selections_->size() > before; })) << i;
    EXPECT_TRUE(nodelets_->unload(i % 2 == 0 ? matcher() : selector()));
    if (i % 2 == 0) {
      loadMatcher();
    } else {
      loadSelector();
    }
  }
  stop = true;
  camera.join();
  EXPECT_TRUE(answers());
}

// While the first callbacks run: subscribers are coming, and the first images.
TEST_F(LiveFlow, UnloadingRightAfterLoadingIsClean) {
  setDefaults();
  openCameras();
  openInboxes();
  for (int i = 0; i < 15; ++i) {
    loadMatcher();
    loadSelector();
    send(nextStamp(), good_, good_);
    EXPECT_TRUE(nodelets_->unload(matcher()));
    EXPECT_TRUE(nodelets_->unload(selector()));
  }
  loadMatcher();
  loadSelector();
  EXPECT_TRUE(answers());
}

TEST_F(LiveFlow, NoSubscriberNoWork) {
  setDefaults();
  openCameras();
  diagnostics_ = std::make_unique<testing::Diagnostics>(nh_);
  loadMatcher();
  ASSERT_TRUE(waitFor([&] { return diagnostics_->of(matcher(), "input").level >= 0; }));
  EXPECT_EQ(left_.getNumSubscribers(), 0u);
  for (int i = 0; i < 3; ++i) {
    {
      testing::Inbox<Correspondences> inbox(nh_, "correspondences");
      EXPECT_TRUE(waitFor([&] { return left_.getNumSubscribers() == 1 && right_.getNumSubscribers() == 1; }));
      const ros::Time stamp = nextStamp();
      send(stamp, good_, good_);
      EXPECT_TRUE(inbox.wait(stamp));
    }
    EXPECT_TRUE(waitFor([&] { return left_.getNumSubscribers() == 0 && right_.getNumSubscribers() == 0; }));
  }
}

TEST_F(LiveFlow, NotLazyWorksForNobody) {
  setDefaults();
  set(matcher() + "/lazy", false);
  openCameras();
  loadMatcher();
  EXPECT_TRUE(waitFor([&] { return left_.getNumSubscribers() == 1 && right_.getNumSubscribers() == 1; }));
}

TEST_F(LiveFlow, NothingIsLatched) {
  start();
  const ros::Time stamp = nextStamp();
  send(stamp, good_, good_);
  ASSERT_TRUE(selections_->wait(stamp));
  // A new subscriber receives new results only.
  testing::Inbox<Selection> late(nh_, "selection");
  testing::Inbox<Correspondences> late_matches(nh_, "matches");
  const ros::Time next = nextStamp();
  ASSERT_TRUE(waitFor([&] {
    send(nextStamp(), good_, good_);
    return waitFor([&] { return late.size() > 0 && late_matches.size() > 0; }, 200ms);
  }));
  for (const auto& item : late.all()) EXPECT_GE(item.message->header.stamp, next);
  for (const auto& item : late_matches.all()) EXPECT_GE(item.message->header.stamp, next);
}

TEST_F(LiveFlow, AStormOfParametersWhileFramesFlow) {
  start();
  std::atomic<bool> stop{false};
  std::thread camera([&] {
    while (!stop) {
      send(nextStamp(), good_, good_);
      std::this_thread::sleep_for(20ms);
    }
  });
  // 100 changes a second of both nodelets, half of them nonsense.
  const std::vector<std::string> names = {"gms", "lpm:v2", "nnsr", "no_such_selector", "ransac", "", "vfc"};
  auto storm = [&](int offset) {
    for (int i = 0; i < (kSanitized ? 20 : 50); ++i) {
      const std::string& name = names[static_cast<std::size_t>(i + offset) % names.size()];
      configure(selector(), {{"selector", name.substr(0, name.find(':'))}, {"preset", ""}},
                {{"gms_alpha", 3.0 + i % 5}});
      configure(matcher(), {{"features", i % 10 == 9 ? "surf+surf" : "orb+orb"}}, {},
                {{"orb_max_features", 200 + i}});
      std::this_thread::sleep_for(10ms);
    }
  };
  const std::size_t before = selections_->size();
  std::future<void> other = std::async(std::launch::async, storm, 3);
  storm(0);
  other.get();
  stop = true;
  camera.join();
  EXPECT_GT(selections_->size(), before + 10);  // frames did flow
  EXPECT_EQ(configure(selector(), {{"selector", "lpm"}, {"preset", ""}})["selector"], "lpm");
  const SelectionConstPtr selection = ask(good_, good_);
  ASSERT_TRUE(selection);
  EXPECT_EQ(selection->selector, "lpm");
}

TEST_F(LiveFlow, DiagnosticsAccountForEverything) {
  start();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(ask(good_, good_));
  EXPECT_TRUE(waitFor([&] {
    const auto processing = diagnostics_->of(selector(), "processing");
    return processing.values.count("last failure") == 1 && processing.values.count("selector") == 1 &&
           processing.values.count("inlier ratio") == 1 && processing.number("processed") >= 10;
  })) << diagnostics_->text();
  auto status = diagnostics_->of(selector(), "processing");
  EXPECT_EQ(status.values["selector"], "gms");
  EXPECT_GT(status.number("inlier ratio"), 0.5);
  std::size_t stages = 0;
  for (const auto& [key, value] : status.values) stages += key.compare(0, 4, "p95 ") == 0;
  EXPECT_GE(stages, 3u) << diagnostics_->text();
  status = diagnostics_->of(matcher(), "input");
  EXPECT_NE(diagnostics_->text().find("left rate"), std::string::npos) << diagnostics_->text();
  // No camera sends images, and the silence is reported.
  EXPECT_TRUE(waitFor([&] { return diagnostics_->of(matcher(), "input").level > 0; }))
      << diagnostics_->text();
}

TEST_F(LiveFlow, OverheadIsSmall) {
  setDefaults();
  set(matcher() + "/orb_max_features", 2000);
  set(matcher() + "/threads", 1);  // else times of both images, side by side, are added up
  openCameras();
  openInboxes();
  loadMatcher();
  loadSelector();
  const cv::Mat image = texture(640, 480, 4);
  ASSERT_TRUE(answers());
  std::vector<double> stages, publish, overheads;
  std::size_t n_input = 0;
  for (int i = 0; i < (kSanitized ? 5 : 60); ++i) {
    const ros::Time stamp = nextStamp();
    const sensor_msgs::ImagePtr left = imageMsg(stamp, "camera", "mono8", image);
    const sensor_msgs::ImagePtr right = imageMsg(stamp, "camera", "mono8", image);
    const ros::WallTime ready = ros::WallTime::now();
    send(left, right);
    const SelectionConstPtr selection = selections_->wait(stamp);
    ASSERT_TRUE(selection);
    const double total = (selections_->all().back().arrival - ready).toSec();
    const StageTimes& seconds = selection->seconds;
    stages.push_back(seconds.detect + seconds.describe + seconds.match + seconds.select);
    publish.push_back(seconds.publish);
    overheads.push_back(total - stages.back());
    n_input = selection->n_input;
    // The next messages find the memory of these, as those of a robot do.
    found_->forget();
    matches_->forget();
    selections_->forget();
  }
  EXPECT_GE(n_input, 1800u);
  // The least is what the pipeline itself costs; the rest is other load on the machine. It is a share of the
  // stages, because the speed of the machine is not known.
  const double least_stages = core::quantile(stages, 0.0), least = core::quantile(overheads, 0.0);
  std::printf("of %.3f ms for %zu matches: overhead %.0f %%, of which publish %.0f %%\n", 1e3 * least_stages,
              n_input, 100 * least / least_stages, 100 * core::quantile(publish, 0.0) / least_stages);
  EXPECT_LT(least, (kSanitized ? 1 : 0.4) * least_stages);
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_test");
  ros::NodeHandle nh;  // keeps ROS running from the first to the last test
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
