#include "corrsel/ros/matcher_plugins.h"

#include "ros/plugins/plugin_loader.h"

namespace corrsel {

std::unique_ptr<Matcher> createMatcher(const std::string& name) {
  // It is never destroyed: see PluginLoader.
  static auto& loader = *new PluginLoader<core::Matcher>({"corrsel::Matcher", "matcher"});
  return loader.create(name);
}

}  // namespace corrsel
