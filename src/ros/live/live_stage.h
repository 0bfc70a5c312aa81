#pragma once

#include <dynamic_reconfigure/server.h>
#include <ros/advertise_options.h>
#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "corrsel/StageTimes.h"
#include "ros/live/callback_thread.h"
#include "ros/live/live_diagnostics.h"
#include "ros/live/live_source.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/on_demand.h"
#include "ros/live/parameters.h"
#include "ros/live/periodic.h"
#include "ros/live/wall_throttle.h"
#include "ros/live/work_queue.h"

namespace corrsel {

/// One stage of the live pipeline: everything that the nodelets FeatureMatcher and Selector have in common.
///
/// A LiveSource hands items to a WorkQueue, whose thread works on them one after the other; the work
/// publishes its results. OnDemand starts the source with the first subscriber to an output and stops it with
/// the last. LiveDiagnostics polls the counts. A dynamic_reconfigure server passes on configurations.
///
/// Threads: the source and the connections of subscribers have one, the server has one (so that slow work
/// does not delay a change), the queue, the diagnostics and the complaints have one each. No thread of the
/// nodelet manager is used.
///
/// Destruction: the two threads with callbacks are stopped first, then the queue. Then the members go in the
/// reverse order of their declaration: whatever calls another member is destroyed before it. The functions
/// that the nodelet passes in, and what they use, must outlive this object, so it is the nodelet's last
/// member.
template <class Item, class Config>
class LiveStage {
 public:
  using Put = std::function<void(Item)>;

  /// What distinguishes one stage from another.
  struct Parts {
    /// Opens the source. @param nh  its callbacks run on the stage's thread. @param put  takes over an item
    std::function<std::unique_ptr<LiveSource>(const ros::NodeHandle& nh, Put put)> open;

    /// Works on one item, on the thread of the queue. An exception drops the item, with a warning.
    std::function<void(const Item&)> work;

    /// Puts a configuration into force and writes back what was changed in it. Must not throw.
    std::function<void(Config&, std::uint32_t level)> configure;
  };

  /// Nothing is called or advertised before start(), except Parts::open.
  LiveStage(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& name,
            const LiveParameters& parameters, Parts parts)
      : nh_(nh),
        pnh_(pnh),
        name_(name),
        lazy_(parameters.lazy),
        parts_(std::move(parts)),
        queue_(static_cast<std::size_t>(parameters.pending), [this](const Item& item) { process(item); }),
        source_(parts_.open(input_thread_.handle(nh), [this](Item item) { queue_.put(std::move(item)); })),
        demand_(
            lazy_, [this] { return hasSubscribers(); }, [this] { source_->subscribe(); },
            [this] { source_->unsubscribe(); }),
        diagnostics_(server_thread_.handle(nh), pnh, name, parameters, [this] { return flow(); }) {}

  LiveStage(const LiveStage&) = delete;
  LiveStage& operator=(const LiveStage&) = delete;

  ~LiveStage() {
    input_thread_.stop();
    server_thread_.stop();
    queue_.stop();
  }

  /// An output for start().
  template <class Message>
  static ros::AdvertiseOptions output(const std::string& topic) {
    constexpr std::uint32_t kPublisherQueue = 10;
    ros::AdvertiseOptions options;
    options.init<Message>(topic, kPublisherQueue);
    return options;
  }

  /// Puts the first configuration into force, then advertises the outputs and begins.
  void start(std::vector<ros::AdvertiseOptions> outputs) {
    for (const std::string& text : clampedParameters<Config>(pnh_)) ROS_WARN_STREAM_NAMED(name_, text);
    server_ = std::make_unique<Server>(server_mutex_, server_thread_.handle(pnh_));
    server_->setCallback([this](Config& config, std::uint32_t level) { parts_.configure(config, level); });
    if (lazy_) ROS_INFO_NAMED(name_, "lazy: the input is subscribed while somebody subscribes to the output");
    const auto on_change = [this](const ros::SingleSubscriberPublisher&) { demand_.update(); };
    demand_.start([&] {
      ros::NodeHandle nh = input_thread_.handle(nh_);
      for (ros::AdvertiseOptions& options : outputs) {
        options.connect_cb = options.disconnect_cb = on_change;
        const std::string topic = options.topic;  // advertise() replaces it by the resolved name
        publishers_.emplace_back(topic, nh.advertise(options));
      }
    });
    complaints_ = std::make_unique<Periodic>(kComplaintPeriod, [this] { complain(); });
  }

  /// Publishes a message, a shared pointer, on an output. @pre the topic is one of those given to start()
  template <class MessagePtr>
  void publish(const std::string& topic, const MessagePtr& message) const {
    publisher(topic).publish(message);
  }

  /// Whether somebody subscribes to an output. @pre as for publish()
  bool isWanted(const std::string& topic) const { return publisher(topic).getNumSubscribers() > 0; }

  /// Adds one item's times to the diagnostics. @param stamp  of the left image
  void report(const StageTimes& seconds, const ros::Time& stamp) {
    diagnostics_.finished({{"wait", seconds.wait},
                           {"detect", seconds.detect},
                           {"describe", seconds.describe},
                           {"match", seconds.match},
                           {"select", seconds.select},
                           {"publish", seconds.publish},
                           {"age", ros::Time::now().toSec() - stamp.toSec()}});
  }

  /// Something was lost or late: it is counted in the diagnostics, and logged at most once in five seconds.
  void warn(const std::string& text) {
    diagnostics_.failed(text);
    if (warning_.due()) ROS_WARN_STREAM_NAMED(name_, text);
  }

  LiveDiagnostics& diagnostics() { return diagnostics_; }

 private:
  using Server = dynamic_reconfigure::Server<Config>;
  static constexpr double kComplaintPeriod = 15.0;  ///< s, wall time

  const ros::Publisher& publisher(const std::string& topic) const {
    const auto is_topic = [&topic](const auto& entry) { return entry.first == topic; };
    return std::find_if(publishers_.begin(), publishers_.end(), is_topic)->second;
  }

  void process(const Item& item) {
    try {
      parts_.work(item);
    } catch (const std::exception& error) {  // malformed messages, encodings, masks, OpenCV
      warn(core::joinList(source_->topics(), " or ") + ": dropped: " + error.what());
    }
  }

  bool hasSubscribers() const {
    return std::any_of(publishers_.begin(), publishers_.end(),
                       [](const auto& entry) { return entry.second.getNumSubscribers() > 0; });
  }

  LiveDiagnostics::Flow flow() {
    const auto work = queue_.counts();
    return {demand_.running(), source_->inputs(), work.done, work.dropped};
  }

  void complain() {
    const std::string text = source_->complaint();
    if (text.empty()) return;
    diagnostics_.failed(text);
    ROS_WARN_STREAM_NAMED(name_, "in " << kComplaintPeriod << " s: " << text);
  }

  const ros::NodeHandle nh_, pnh_;
  const std::string name_;
  const bool lazy_;
  const Parts parts_;
  // The order of declaration is that of destruction, reversed: see above.
  CallbackThread input_thread_;   ///< input, and who subscribes to the outputs
  CallbackThread server_thread_;  ///< reconfiguration: slow work does not delay it
  std::vector<std::pair<std::string, ros::Publisher>> publishers_;  ///< written under demand_'s lock
  WallThrottle warning_;
  WorkQueue<Item> queue_;
  std::unique_ptr<LiveSource> source_;
  OnDemand demand_;
  LiveDiagnostics diagnostics_;
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Periodic> complaints_;
};

}  // namespace corrsel
