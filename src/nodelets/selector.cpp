#include <corrsel/SelectorConfig.h>
#include <dynamic_reconfigure/server.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>

#include "corrsel/ros/callback_thread.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/live_diagnostics.h"
#include "corrsel/ros/on_demand.h"
#include "corrsel/ros/parameters.h"
#include "corrsel/ros/selector_plugins.h"
#include "corrsel/ros/wall_throttle.h"
#include "corrsel/ros/work_queue.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/stopwatch.h"
#include "corrsel/text.h"

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
  /// A selector with the name under which it was asked for.
  struct Active {
    std::string spec;
    double max_seconds = 0.0;
    std::shared_ptr<const core::Selector> selector;
  };
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
    Active active;
    {
      const std::lock_guard<std::mutex> lock(active_mutex_);
      active = active_;
    }
    try {
      answer(active, item);
    } catch (const std::exception& error) {  // malformed messages
      warn(getNodeHandle().resolveName("correspondences") + ": dropped: " + error.what());
    }
  }

  void answer(const Active& active, const Item& item) {
    PairInfo info;
    const double waited = item.waiting.seconds();
    core::Stopwatch watch;
    const core::Correspondences input = fromMsg(*item.message, &info);
    // What was not measured before counts as nothing: matches that somebody else has made.
    info.wait_seconds = (info.wait_seconds >= 0 ? info.wait_seconds : 0.0) + waited;
    info.publish_seconds = (info.publish_seconds >= 0 ? info.publish_seconds : 0.0) + watch.seconds();

    const core::Selection selection = active.selector->select(input);
    watch.restart();
    matches_publisher_.publish(
        boost::make_shared<Correspondences>(toMsg(input.subset(core::selectedRows(selection.mask)), info)));
    const auto message = boost::make_shared<Selection>(toMsg(selection, info, active.spec));
    message->publish_seconds += watch.seconds();
    selection_publisher_.publish(message);
    report(active, selection, *message);
  }

  void report(const Active& active, const core::Selection& selection, const Selection& message) {
    diagnostics_->answered({{"wait", message.wait_seconds},
                            {"detect", message.detect_seconds},
                            {"describe", message.describe_seconds},
                            {"match", message.match_seconds},
                            {"select", message.select_seconds},
                            {"publish", message.publish_seconds},
                            {"age", ros::Time::now().toSec() - message.header.stamp.toSec()}});
    if (selection.n_input > 0) {
      diagnostics_->inlierRatio(static_cast<double>(selection.n_selected) /
                                static_cast<double>(selection.n_input));
    }
    if (selection.n_input == 0) warn("no putative matches: are the images dark, blurred or masked?");
    const bool late = active.max_seconds > 0 && selection.seconds > active.max_seconds;
    if (selection.status != core::Status::kOk) {
      warn(active.spec + ": " + core::toString(selection.status) + ": " + selection.message);
    } else if (late) {
      warn(active.spec + ": took " + std::to_string(selection.seconds) + " s of max_seconds = " +
           std::to_string(active.max_seconds) + " with " + std::to_string(selection.n_input) + " matches");
    }
  }

  void warn(const std::string& text) {
    diagnostics_->failed(text);
    if (warning_.due()) NODELET_WARN_STREAM(text);
  }

  LiveDiagnostics::Flow flow() {
    const WorkQueue<Item>::Counts work = queue_->counts();
    return {demand_->running(), {{"correspondences", work.received}}, work.done, work.dropped};
  }

  static Active create(const SelectorConfig& config) {
    Active active;
    active.spec = config.preset.empty() ? config.selector : config.selector + ":" + config.preset;
    active.max_seconds = config.max_seconds;
    core::OptionMap options = core::isPluginName(config.selector)
                                  ? parseOptions(config.plugin_options)
                                  : changedOptions(config, config.selector + "_");
    core::OptionMap common = {{"seed", std::to_string(config.seed)}};
    if (config.max_seconds > 0) {
      common["max_seconds"] = core::formatNumber(config.max_seconds);
      // The selector's own limit counts only where it is the stricter one.
      const auto own = options.find("max_seconds");
      const double limit = own == options.end() ? 0.0 : core::parseNumber(own->second, "max_seconds");
      if (own != options.end() && (limit <= 0 || limit > config.max_seconds)) options.erase(own);
    }
    active.selector = core::createSelector(active.spec, options, common);
    return active;
  }

  /// A preset that belonged to the selector chosen before goes with it.
  void dropStalePreset(SelectorConfig& config) {
    if (config.preset.empty() || config.selector == accepted_.selector || config.preset != accepted_.preset)
      return;
    const std::vector<std::string> presets = core::selectorPresets(config.selector);
    if (std::find(presets.begin(), presets.end(), config.preset) != presets.end()) return;
    NODELET_WARN_STREAM("preset '" << config.preset << "' is not one of " << config.selector
                                   << "'s and is cleared");
    config.preset.clear();
  }

  void reconfigure(SelectorConfig& config, std::uint32_t level) {
    if ((level & kLevelSelector) == 0) return;
    Active active;
    try {
      dropStalePreset(config);
      active = create(config);
    } catch (const std::exception& error) {
      NODELET_ERROR_STREAM("selector not changed: " << error.what() << "; '" << accepted_.selector
                                                    << (accepted_.preset.empty() ? "" : ":")
                                                    << accepted_.preset
                                                    << "' stays in force with the options it had");
      config = accepted_;
      if (active_.selector) return;
      active = create(config);  // at start-up: the defaults
    }
    accepted_ = config;
    NODELET_INFO_STREAM("selector " << active.spec);
    diagnostics_->set("selector", active.spec);
    const std::lock_guard<std::mutex> lock(active_mutex_);
    active_ = active;
  }

  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelSelector = 2;

  // Order of destruction: what calls goes before what is called.
  CallbackThread matches_thread_;  ///< matches and who subscribes to the outcome
  CallbackThread server_thread_;   ///< reconfiguring: a slow selection does not hold it up
  ros::Publisher matches_publisher_, selection_publisher_;
  std::mutex active_mutex_;  ///< guards active_, which is written under server_mutex_ only
  Active active_;
  SelectorConfig accepted_ = SelectorConfig::__getDefault__();  ///< the newest configuration that worked
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
