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

#include "corrsel/ros/conversions.h"
#include "corrsel/ros/parameters.h"
#include "corrsel/selectors/factory.h"

namespace corrsel {

/// Answers every message on `correspondences` with the matches that the chosen selector keeps (`matches`) and
/// with its decision (`selection`).
class SelectorNodelet : public nodelet::Nodelet {
 private:
  /// A selector with the name under which it was asked for.
  struct Active {
    std::string spec;
    std::shared_ptr<const core::Selector> selector;
  };

  void onInit() override {
    for (const std::string& text : clampedParameters<SelectorConfig>(getPrivateNodeHandle())) {
      NODELET_WARN_STREAM(text);
    }
    ros::NodeHandle& nh = getNodeHandle();
    matches_publisher_ = nh.advertise<Correspondences>("matches", kPublisherQueue);
    selection_publisher_ = nh.advertise<Selection>("selection", kPublisherQueue);

    // The server has threads of its own: a slow selection does not hold up set_parameters.
    server_ = std::make_unique<Server>(server_mutex_, getMTPrivateNodeHandle());
    server_->setCallback([this](SelectorConfig& config, std::uint32_t level) { reconfigure(config, level); });

    const int queue = std::max(1, getPrivateNodeHandle().param("subscriber_queue_size", 1));
    subscriber_ =
        nh.subscribe("correspondences", static_cast<std::uint32_t>(queue), &SelectorNodelet::process, this);
  }

  void process(const CorrespondencesConstPtr& msg) {
    Active active;
    {
      const std::lock_guard<std::mutex> lock(active_mutex_);
      active = active_;
    }
    if (!active.selector) return;
    PairInfo info;
    core::Correspondences input;
    try {
      input = fromMsg(*msg, &info);
    } catch (const std::invalid_argument& error) {
      NODELET_WARN_STREAM_THROTTLE(5.0, subscriber_.getTopic() << ": dropped: " << error.what());
      return;
    }
    const core::Selection selection = active.selector->select(input);
    matches_publisher_.publish(
        boost::make_shared<Correspondences>(toMsg(input.subset(core::selectedRows(selection.mask)), info)));
    selection_publisher_.publish(boost::make_shared<Selection>(toMsg(selection, info, active.spec)));
  }

  static Active create(const SelectorConfig& config) {
    Active active;
    active.spec = config.preset.empty() ? config.selector : config.selector + ":" + config.preset;
    const std::string name = active.spec.substr(0, active.spec.find(':'));
    const core::OptionMap common = {{"seed", std::to_string(config.seed)}};
    active.selector = core::createSelector(active.spec, changedOptions(config, name + "_"), common);
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
    const std::lock_guard<std::mutex> lock(active_mutex_);
    active_ = active;
  }

  using Server = dynamic_reconfigure::Server<SelectorConfig>;
  static constexpr std::uint32_t kPublisherQueue = 10;
  static constexpr std::uint32_t kLevelSelector = 2;

  ros::Publisher matches_publisher_, selection_publisher_;
  std::mutex active_mutex_;  ///< guards active_, which is written under server_mutex_ only
  Active active_;
  SelectorConfig accepted_ = SelectorConfig::__getDefault__();  ///< the newest configuration that worked
  boost::recursive_mutex server_mutex_;
  std::unique_ptr<Server> server_;
  ros::Subscriber subscriber_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::SelectorNodelet, nodelet::Nodelet)
