#pragma once

#include <cstddef>
#include <string>

namespace corrsel::core {

/// What this program runs on, as a flat JSON object: CPU, cores, compiler, build type, OpenCV, kernel level,
/// package version and commit, threads.
std::string environmentJson(int threads);

/// Writes environmentJson() to environment.json of a run's folder. What was merged into the folder before
/// stays listed.
void writeEnvironment(const std::string& folder, int threads);

/// Adds the environment of the folder `from`, of which `pairs` pairs were copied, to the list "merged_from".
/// Throws RunFolderError where one of the two files is damaged.
void addMergedEnvironment(const std::string& folder, const std::string& from, std::size_t pairs);

}  // namespace corrsel::core
