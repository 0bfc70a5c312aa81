#pragma once

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

/// Fills in what the preset decides and the user has left empty: cells (features and preselection),
/// selectors, and the sections of the report. Throws std::invalid_argument for an unknown name (listing the
/// valid ones). An empty name fills in the defaults of a run without preset.
void applyExperiment(const std::string& name, BenchmarkConfig& config);

}  // namespace corrsel::core
