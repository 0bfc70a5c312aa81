#pragma once

#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/correspondences.h"
#include "corrsel/image_pair.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Writes the putative matches of a pair and what every selector keeps of them, as CSV files in
/// matches/csv/DATASET/SEQUENCE/PAIR/FEATURES/PRESELECTION/ of a run's folder (docs/matches.md describes
/// them). The parts of these paths are made by uniqueFileName(). Files of an earlier, unfinished session are
/// overwritten.
class SavedMatches {
 public:
  /// @param seeds  whether there is a file for every seed
  SavedMatches(const std::string& folder, const ImagePair& pair, bool seeds);

  /// Writes putative.csv. @throws RunFolderError where a file cannot be written, like write()
  void writePutative(const Cell& cell, const Correspondences& putative);

  /// Writes SELECTOR.csv, or SELECTOR@SEED.csv, beside the last putative.csv.
  /// @param putative  those that were written last
  void write(const Correspondences& putative, const std::string& selector, int seed,
             const Selection& selection);

  /// What has been written.
  const std::vector<SavedSelection>& selections() const { return selections_; }

 private:
  std::string root_;
  bool seeds_;
  SavedSelection common_;  ///< what the next selections share
  std::string cell_folder_;
  std::vector<SavedSelection> selections_;
};

/// Copies the files of selections from the folder of one run to that of another one. Throws RunFolderError
/// that names a file that cannot be copied.
void copySavedMatches(const std::string& from, const std::string& to,
                      const std::vector<SavedSelection>& selections);

}  // namespace corrsel::core
