#pragma once

#include <memory>
#include <string>

#include "corrsel/matching/matcher.h"

namespace corrsel {

using core::Matcher;

/// Makes a matcher of another package: a class derived from corrsel::Matcher that the package exports with
/// pluginlib, by its name "package/Class" (see docs/live.md). Packages are searched where the name is not
/// known, which takes about 0.1 s. A library that has been loaded stays loaded until the process ends. It
/// needs no ROS master and may be called from any thread. Throws std::invalid_argument that names the matcher
/// and the remedy if no package declares it, or its library cannot be loaded; a constructor's exception
/// passes through.
std::unique_ptr<Matcher> createMatcher(const std::string& name);

}  // namespace corrsel
