#pragma once

#include <string>
#include <vector>

namespace corrsel {

/// Makes core::createSelector() accept selectors of other packages: classes derived from corrsel::Selector
/// that a package exports with pluginlib, under the name "package/Class" (see docs/adding_selectors.md). A
/// program that creates selectors calls it once; further calls do nothing. It needs no ROS master, reads
/// nothing before the first such name is used, and may be called from any thread.
///
/// A library that has been loaded stays loaded until the process ends, because selectors may outlive
/// everything else. A library that was built anew is used by the next process.
void enableSelectorPlugins();

/// The selectors that packages on ROS_PACKAGE_PATH declare, sorted. Their libraries are not loaded. Every
/// call searches for packages, which takes about 0.1 s.
std::vector<std::string> selectorPlugins();

/// Why declared selectors are not available (files that cannot be read, names of another form, names that are
/// declared twice): one sentence for each, with the file and the remedy. As of the newest search for
/// packages.
std::vector<std::string> selectorPluginProblems();

}  // namespace corrsel
