#pragma once

#include <string>

namespace corrsel::core {

/// What a run was made on, as a flat JSON object: CPU, cores, compiler, build type, OpenCV, kernel level,
/// package version and commit, threads.
std::string environmentJson(int threads);

}  // namespace corrsel::core
