#pragma once

#include <corrsel/SelectorConfig.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/Selection.h"
#include "corrsel/selectors/selector.h"

namespace corrsel {

/// Turns messages with putative matches into messages with the selected ones. The selector follows a
/// configuration; a configuration that does not work leaves the selector before it in force. Thread-safe: a
/// configuration never waits for a selection.
class LiveSelector {
 public:
  /// Level of the parameters in cfg/Selector.cfg.
  static constexpr std::uint32_t kLevelSelector = 2;

  struct Result {
    boost::shared_ptr<Correspondences> matches;  ///< the selected ones; none where the status is `uncertain`
    boost::shared_ptr<Selection> selection;      ///< its time of publishing lacks that of these two messages
    std::string warning;                         ///< why the selection is not as requested; empty = it is
  };
  struct Change {
    std::string spec;                   ///< "name" or "name:preset", in force
    std::vector<std::string> warnings;  ///< what was changed in the configuration
    std::string error;                  ///< why the configuration is not in force; empty = it is
  };

  /// Makes the selector that a configuration asks for, and corrects `config` where it does not work: a preset
  /// of the previous selector is cleared, and after an error `config` is the configuration that stays in
  /// force (at first the defaults). Throws nothing for a bad configuration.
  Change configure(SelectorConfig& config);

  /// Selects among the matches of a message. Only after configure(). Throws std::exception that names the
  /// field of a malformed message.
  /// @param waited  s since the message arrived
  Result select(const Correspondences& message, double waited) const;

 private:
  struct Active {
    std::string spec;
    double max_seconds = 0.0;
    std::shared_ptr<const core::Selector> selector;
  };

  static Active create(const SelectorConfig& config);
  std::string clearStalePreset(SelectorConfig& config) const;

  std::mutex configuring_;
  SelectorConfig accepted_ = SelectorConfig::__getDefault__();  ///< the newest one that worked
  mutable std::mutex active_mutex_;
  Active active_;
};

}  // namespace corrsel
