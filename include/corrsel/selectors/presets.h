#pragma once

#include <string>
#include <utility>
#include <vector>

#include "corrsel/options.h"

namespace corrsel::core {

/// Named sets of option values, applied on top of an algorithm's defaults.
using Presets = std::vector<std::pair<std::string, OptionMap>>;

}  // namespace corrsel::core
