#include <corrsel/SelectorConfig.h>
#include <dynamic_reconfigure/server.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "base/stopwatch.h"
#include "corrsel/ros/selector_plugins.h"
#include "ros/live/callback_thread.h"
#include "ros/live/live_diagnostics.h"
#include "ros/live/live_selector.h"
#include "ros/live/on_demand.h"
#include "ros/live/parameters.h"
#include "ros/live/wall_throttle.h"
#include "ros/live/work_queue.h"

namespace corrsel {

/// Answers every message on `correspondences` with the matches that the chosen selector keeps (`matches`) and
/// with its decision (`selection`).
class SelectorNodelet : public nodelet::Nodelet {
 public:
  ~SelectorNodelet() override {
    for (CallbackThread* thread : {&matches_thread_, &server_thread_}) thread->stop();
    if (queue_) queue_->stop();
  }

 private:
  struct Item {
    CorrespondencesConstPtr message;
    core::Stopwatch waiting;
  };
  using Server = dynamic_reconfigure::Server<SelectorConfig>;

  void onInit() override {
    ros::NodeHandle& pnh = getPrivateNodeHandle();
    for (const std::string& text : clampedParameters<SelectorConfig>(pnh)) NODELET_WARN_STREAM(text);
    enableSelectorPlugins();
    queue_ = std::make_unique<WorkQueue<Item>>(std::max(1, pnh.param("pending", 1)),
                                               [this](const Item& item) { process(item); });
    queue_size_ = static_cast<std::uint32_t>(std::max(1, pnh.param("subscriber_queue_size", 5)));
    const bool lazy = pnh.param("lazy", true);
    demand_ = std::make_unique<OnDemand>(
        lazy,
        [this] {
          return matches_publisher_.getNumSubscribers() + selection_publisher_.getNumSubscribers() > 0;
        },
        [this] { subscribe(); }, [this] { subscriber_.shutdown(); });
    diagnostics_ = std::make_unique<LiveDiagnostics>(server_thread_.handle(getNodeHandle()), pnh, getName(),
                                                     [this] { return flow(); });

    server_ = std::make_unique<Server>(server_mutex_, server_thread_.handle(pnh));
    server_->setCallback([this](SelectorConfig& config, std::uint32_t level) { reconfigure(config, level); });

    if (lazy) NODELET_INFO("lazy: correspondences are subscribed while somebody subscribes to the outcome");
    const auto on_change = [this](const ros::SingleSubscriberPublisher&) { demand_->update(); };
    {
      const auto lock = demand_->hold();
      ros::NodeHandle nh = matches_thread_.handle(getNodeHandle());
      matches_publisher_ = nh.advertise<Correspondences>("matches", kPublisherQueue, on_change, on_change);
      selection_publisher_ = nh.advertise<Selection>("selection", kPublisherQueue, on_change, on_change);
    }
    demand_->update();
  }

  void subscribe() {
    subscriber_ = matches_thread_.handle(getNodeHandle())
                      .subscribe<Correspondences>("correspondences", queue_size_,
                                                  [this](const CorrespondencesConstPtr& message) {
                                                    queue_->put({message, core::Stopwatch()});
                                                  });
  }

  /// On the thread of the queue.
  void process(const Item& item) {
    try {
      const LiveSelector::Answer answer = selector_.select(*item.message, item.waiting.seconds());
      const core::Stopwatch watch;
      matches_publisher_.publish(answer.matches);
      answer.selection->seconds.publish += watch.seconds();
      selection_publisher_.publish(answer.selection);
      report(answer);
    } catch (const std::exception& error) {  // malformed messages
      warn(getNodeHandle().resolveName("correspondences") + ": dropped: " + error.what());
    }
  }

  void report(const LiveSelector::Answer& answer) {
    const Selection& selection = *answer.selection;
    diagnostics_->answered({{"wait", selection.seconds.wait},
                            {"detect", selection.seconds.detect},
                            {"describe", selection.seconds.describe},
                            {"match", selection.seconds.match},
                            {"select", selection.seconds.select},
                            {"publish", selection.seconds.publish},
                            {"age", ros::Time::now().toSec() - selection.header.stamp.toSec()}});
    if (selection.n_input > 0) {
      diagnostics_->inlierRatio(static_cast<double>(selection.n_selected) /
                                static_cast<double>(selection.n_input));
    }
    if (!answer.warning.empty()) warn(answer.warning);
  }

  void warn(const std::string& text) {
    diagnostics_->failed(text);
    if (warning_.due()) NODELET_WARN_STREAM(text);
  }

  LiveDiagnostics::Flow flow() {
    const WorkQueue<Item>::Counts work = queue_->counts();
    return {demand_->running(), {{"correspondences", work.received}}, work.done, work.dropped};
  }

  void reconfigure(SelectorConfig& config, std::uint32_t level) {
    if ((level & kLevelSelector) == 0) return;
    const LiveSelector::Change change = selector_.configure(config);
    for (const std::string& text : change.warnings) NODELET_WARN_STREAM(text);
    if (!change.error.empty()) NODELET_ERROR_STREAM(change.error);
    if (change.error.empty()) NODELET_INFO_STREAM("selector " << change.spec);
    diagnostics_->set("selector", change.spec);
  }

  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelSelector = 2;

  // Order of destruction: what calls goes before what is called.
  CallbackThread matches_thread_;  ///< matches and who subscribes to the outcome
  CallbackThread server_thread_;   ///< reconfiguring: a slow selection does not hold it up
  ros::Publisher matches_publisher_, selection_publisher_;
  LiveSelector selector_;
  WallThrottle warning_;
  std::unique_ptr<WorkQueue<Item>> queue_;
  std::uint32_t queue_size_ = 5;
  ros::Subscriber subscriber_;  ///< guarded by demand_
  std::unique_ptr<OnDemand> demand_;
  std::unique_ptr<LiveDiagnostics> diagnostics_;
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::SelectorNodelet, nodelet::Nodelet)
