#pragma once

#include <string>

#include "corrsel/options.h"

namespace corrsel::core {

/// Kinds of pairs of a stereo camera that moves.
enum class FramePairs { kStereo, kSteps, kBoth };

/// Which pairs are made of the images of a sequence or a reconstruction. The file kFile in the folder of the
/// dataset sets it; docs/datasets.md repeats the options, and a test compares.
struct PairChoice : OptionSet {
  static constexpr char kFile[] = "corrsel.yaml";

  int step = 10;
  int max_pairs = 100;
  double min_baseline = 0.05;
  double max_gap = 0.02;
  FramePairs pairs = FramePairs::kBoth;
  int min_points = 30;

  void visit(OptionVisitor& visitor) const override;
};

/// Reads the choice from the folder of a dataset; the defaults where it has no such file. Throws DatasetError
/// that names the file, the option, its value and what is valid.
PairChoice readPairChoice(const std::string& folder);

}  // namespace corrsel::core
