#pragma once

#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/truth_check.h"

namespace corrsel::core {

/// Compares the ground truth of a dataset with the given matches, or with matches of ORB features, which are
/// made for this purpose, and returns the sequences whose ground truth is probably not what it was given as
/// (truthWarnings()). Pairs that cannot be read, and those with labels or without ground truth, are left out.
/// @param threads  threads that may be used; the result does not depend on it
/// Cost: the images are read; features and matches take some hundredths of a second for each pair.
std::vector<TruthWarning> doubtfulTruths(const DatasetReader& reader, int threads);

}  // namespace corrsel::core
