#pragma once

#include <map>
#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"

namespace corrsel::core {

/// Names of the presets: the paper's experiments, "paper", which comprises these, and further experiments.
std::vector<std::string> experimentNames();

/// Datasets of a preset, which are used where the user names none. Throws std::invalid_argument for an
/// unknown name.
std::vector<std::string> experimentDatasets(const std::string& name);

/// The datasets of a run with the preset, given those that the user names or experimentDatasets(): the preset
/// `unrelated` adds to each dataset the pairs of its different scenes.
std::vector<std::string> completeDatasets(const std::string& name, std::vector<std::string> datasets);

/// Whether the preset runs several variants of the same selector, see experimentSelectors().
bool makesVariants(const std::string& name);

/// The selectors of a run with the preset, given those that the user names. `budget` replaces a selector that
/// has a time limit by variants with each of its limits, e.g. "usac[max_seconds=0.01]". `curves` puts a
/// selector into the row of its variants with the values of its main parameter, unless its preset or its
/// brackets set this parameter; a variant that would equal the selector itself is left out. Other selectors
/// and presets change nothing.
/// @param options  as in BenchmarkConfig
/// Throws what createSelector() throws.
std::vector<std::string> experimentSelectors(const std::string& name,
                                             const std::vector<std::string>& selectors,
                                             const std::map<std::string, OptionMap>& options);

/// Fills in what the preset decides and the user has left empty: cells (features and preselection),
/// selectors, and the sections of the report. Throws std::invalid_argument for an unknown name (listing the
/// valid ones). An empty name fills in the defaults of a run without preset.
void applyExperiment(const std::string& name, BenchmarkConfig& config);

}  // namespace corrsel::core
