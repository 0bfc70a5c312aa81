#pragma once

#include <corrsel/SelectorConfig.h>

#include <boost/shared_ptr.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/Selection.h"
#include "corrsel/selectors/selector.h"

namespace corrsel {

/// From messages with putative matches to messages with the selected ones. The selector follows a
/// configuration; one that does not work leaves the selector before it in force. Thread-safe: a configuration
/// never waits for a selection.
class LiveSelector {
 public:
  struct Answer {
    boost::shared_ptr<Correspondences> matches;  ///< the selected ones
    boost::shared_ptr<Selection> selection;      ///< publish_seconds: without publishing these two
    std::string warning;  ///< why the selection is not what was asked for; empty = it is
  };
  struct Change {
    std::string spec;                   ///< "name" or "name:preset", in force
    std::vector<std::string> warnings;  ///< what was changed in the configuration
    std::string error;                  ///< why the configuration is not in force; empty = it is
  };

  /// Makes the selector that a configuration asks for. What does not work is put right in `config`: a preset
  /// of the selector chosen before is cleared, and after an error it is what was in force (at first the
  /// defaults). Throws nothing for a bad configuration.
  Change configure(SelectorConfig& config);

  /// @param waited  s since the message arrived
  /// Throws std::exception for malformed messages, naming the field. Only after configure().
  Answer select(const Correspondences& message, double waited) const;

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
