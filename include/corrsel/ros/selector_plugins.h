#pragma once

#include <string>
#include <vector>

namespace corrsel {

/// Makes core::createSelector() take selectors of other packages: classes derived from corrsel::Selector that
/// a package exports with pluginlib, under the name "package/Class" (docs/selectors.md says how). To be
/// called once by whatever creates selectors; more calls do nothing. Needs no ROS master, reads nothing
/// before the first such name, and may be called from any thread.
///
/// A library once loaded stays loaded until the process ends, and so does what loads it: selectors may
/// outlive everything else. A library that was built anew is used by the next process.
void enableSelectorPlugins();

/// The selectors that packages on ROS_PACKAGE_PATH declare, sorted; their libraries are not loaded. Packages
/// are looked for in every call: about 0.1 s.
std::vector<std::string> selectorPlugins();

/// What keeps declared selectors from being offered (files that cannot be read, names of another form, names
/// declared twice): one sentence each, naming file and cure. As of the newest search for packages.
std::vector<std::string> selectorPluginProblems();

}  // namespace corrsel
