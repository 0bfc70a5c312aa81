#pragma once

#include <corrsel/SelectorConfig.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/RelativePose.h"
#include "corrsel/Selection.h"
#include "corrsel/options.h"
#include "corrsel/selectors/selector.h"
#include "ros/live/mask_gate.h"

namespace corrsel {

/// Turns messages with putative matches into messages with the selected ones. The selector follows a
/// configuration; a configuration that does not work leaves the selector before it in force. Thread-safe: a
/// configuration never waits for a selection.
///
/// The configuration shows what runs. Choosing a preset writes its values into the parameters of the
/// selector, and choosing none writes the default values, except into parameters that change at the same
/// time. Afterwards a parameter counts with every value, also with its default. The parameter `options` is
/// for options without a parameter; an option that has one is moved there.
class LiveSelector {
 public:
  /// Level of the parameters in cfg/Selector.cfg.
  static constexpr std::uint32_t kLevelSelector = 2;

  struct Result {
    boost::shared_ptr<Correspondences> matches;  ///< the selected ones; none where the status is `uncertain`
    boost::shared_ptr<Correspondences> moving;   ///< those of moving groups; null where label_motion is off
    boost::shared_ptr<Selection> selection;      ///< its time of publishing lacks that of these messages
    boost::shared_ptr<RelativePose> relative_pose;  ///< null where the selector estimates none
    /// poseOfRight(); null where there is none, or none to be relied on
    boost::shared_ptr<geometry_msgs::PoseWithCovarianceStamped> pose;
    std::string verdict = "not estimated";  ///< the motion between the images, for diagnostics
    std::string warning;                    ///< why the selection is not as requested; empty = it is
  };
  struct Change {
    std::string spec;                   ///< "name" or "name:preset", in force
    std::vector<std::string> warnings;  ///< what was changed in the configuration
    std::string error;                  ///< why the configuration is not in force; empty = it is
  };

  /// @param presets  what presets() returned when the values of the parameters were in force before, e.g.
  ///                 before a restart; empty = never
  explicit LiveSelector(const std::string& presets = "");

  /// Makes the selector that a configuration asks for, and corrects `config` where it does not work: a preset
  /// and `options` of the previous selector are cleared, and after an error `config` is the configuration
  /// that stays in force (at first the defaults). Throws nothing for a bad configuration.
  Change configure(SelectorConfig& config);

  /// Selects among the matches of a message. Only after configure(). Throws std::exception that names the
  /// field of a malformed message.
  /// @param waited  s since the message arrived
  /// @param masks   of the two images, where masks are used: the matches on them are rejected, and the
  ///                algorithm does not see them. A mask that does not fit its image is left out, with a
  ///                warning
  Result select(const Correspondences& message, double waited,
                const std::optional<PairMasks>& masks = std::nullopt) const;

  /// The presets whose values the parameters of the selectors have, "name:preset", comma-separated.
  std::string presets() const;

 private:
  struct Active {
    std::string spec;
    double max_seconds = 0.0;
    bool label_motion = false;
    std::shared_ptr<const core::Selector> selector;
  };

  core::OptionMap parametersOf(const SelectorConfig& config) const;
  Active create(SelectorConfig& config) const;
  std::vector<std::string> clearLeftovers(SelectorConfig& config) const;

  mutable std::mutex configuring_;
  SelectorConfig accepted_ = SelectorConfig::__getDefault__();  ///< the newest one that worked
  std::map<std::string, std::string> presets_;  ///< selector -> the preset that its parameters have
  mutable std::mutex active_mutex_;
  Active active_;
};

/// One sentence for each of the names that is `selector_option` for an option without such a parameter.
/// @param names  parameters of the nodelet, relative to its namespace
std::vector<std::string> unreadParameters(const std::vector<std::string>& names);

}  // namespace corrsel
