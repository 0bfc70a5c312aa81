#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "benchmark/csv_table.h"
#include "benchmark/scaling.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/evaluation/truth_check.h"
#include "corrsel/image_pair.h"

namespace corrsel::core {

/// One row of stages.csv.
struct StageRow {
  std::optional<std::size_t> number;  ///< place of the pair in the uncut run, from 0; none: no pair's stage
  PairId id;                          ///< only the dataset, or nothing, where the stage belongs to no pair
  StageTime stage;
};

/// A picture of matches, one row of images/index.csv.
struct ExampleImage {
  std::string file;  ///< inside images/
  PairId id;
  std::string features, preselection, selector;
  std::size_t n_selected = 0, n_correct = 0, n_wrong = 0, n_missed = 0;
  double tau = kUndefined;  ///< px
};

/// The CSV files of a run's folder, see docs/evaluation.md.
inline constexpr char kPairsFile[] = "pairs.csv";
/// @param tolerances  of the run, px; each has two columns
CsvTable<ResultRow> pairsTable(const std::vector<double>& tolerances);
const CsvTable<PoseRow>& posesTable();
const CsvTable<SummaryRow>& summaryTable();
const CsvTable<PoseSummaryRow>& poseSummaryTable();
const CsvTable<StageRow>& stagesTable();
const CsvTable<ScalingRow>& scalingTable();
const CsvTable<Failure>& failuresTable();
const CsvTable<TruthCheck>& truthChecksTable();
const CsvTable<ExampleImage>& imagesTable();
const CsvTable<Remark>& remarksTable();
const CsvTable<SavedSelection>& savedMatchesTable();

/// The table in a pairs.csv, whose header tells the tolerances. Throws RunFolderError where the file cannot
/// be read or has a format of another version; the error tells which one and what can be done.
CsvTable<ResultRow> pairsTableIn(const std::string& file);

/// The remarks of a run's folder; none where it has no file of them.
std::vector<Remark> readRemarks(const std::string& folder);

}  // namespace corrsel::core
