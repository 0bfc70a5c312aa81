#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// Makes a selector of another package from the name of its class. Throws where it cannot.
using SelectorLoader = std::function<std::unique_ptr<Selector>(const std::string& class_name)>;

/// Sets what createSelector() asks for "package/Class", in the whole process and from now on; an empty loader
/// takes it away. To be called from any thread. Programs of ROS use ros/selector_plugins.h.
void setSelectorLoader(SelectorLoader loader);

/// Creates a selector from "name" or "name:preset", e.g. "gms", "lpm:v2", "ransac:f", or from
/// "package/Class", which has no presets, through the loader.
/// @param options  options of this algorithm, applied on top of the preset; unknown names are an error
/// @param common   values offered to every algorithm (seed, threads, model...); skipped where not known, and
///                 weaker than the preset and the options
/// Throws std::invalid_argument: unknown name or preset (listing the valid ones), option out of range, or
/// whatever a class of another package threw.
std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options = {},
                                         const OptionMap& common = {});

/// All algorithms of this library in the paper's order; the pseudo-selector keep_all, the baseline, comes
/// last.
std::vector<std::string> selectorNames();

/// Whether a selector of another package is meant: "package/Class".
bool isPluginName(const std::string& spec);

/// Presets of one algorithm beside its default; may be empty, and is for "package/Class". Throws
/// std::invalid_argument on an unknown name.
std::vector<std::string> selectorPresets(const std::string& name);

}  // namespace corrsel::core
