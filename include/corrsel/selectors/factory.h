#pragma once

#include <memory>
#include <string>
#include <vector>

#include "corrsel/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// Creates a selector from "name" or "name:preset", e.g. "gms", "lpm:v2", "ransac:f".
/// @param options  options of this algorithm, applied on top of the preset; unknown names are an error
/// @param common   values offered to every algorithm (seed, threads, model...); skipped where not known, and
///                 weaker than the preset and the options
/// Throws std::invalid_argument: unknown name or preset (listing the valid ones) or option out of range.
std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options = {},
                                         const OptionMap& common = {});

/// All algorithm names in the paper's order; the pseudo-selector keep_all, the baseline, comes last.
std::vector<std::string> selectorNames();

/// Presets of one algorithm beside its default; may be empty. Throws std::invalid_argument on an unknown
/// name.
std::vector<std::string> selectorPresets(const std::string& name);

}  // namespace corrsel::core
