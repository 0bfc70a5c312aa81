#include "corrsel/ros/selector_plugins.h"

#include "corrsel/selectors/factory.h"
#include "ros/plugins/plugin_loader.h"

namespace corrsel {
namespace {

/// The process's own, which is never destroyed: see PluginLoader.
PluginLoader<core::Selector>& plugins() {
  static auto& loader = *new PluginLoader<core::Selector>({"corrsel::Selector", "selector"});
  return loader;
}

}  // namespace

void enableSelectorPlugins() {
  core::setSelectorLoader([](const std::string& name) { return plugins().create(name); });
}

std::vector<std::string> selectorPlugins() { return plugins().search(); }

std::vector<std::string> selectorPluginProblems() { return plugins().problems(); }

}  // namespace corrsel
