#include "benchmark/tables.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace corrsel::core {
namespace {

/// A column that is empty where the selector gave nothing that could be evaluated.
template <class Row>
CsvColumn<Row> ifEvaluated(CsvColumn<Row> column) {
  column.cell = [cell = column.cell](const Row& row) {
    return row.evaluated() ? cell(row) : CellValue(std::string());
  };
  return column;
}

/// A column that is empty where the true pose is not known or nothing could be evaluated.
CsvColumn<PoseRow> ifPose(CsvColumn<PoseRow> column) {
  column.cell = [cell = column.cell](const PoseRow& row) {
    return std::isnan(row.pose_error) ? CellValue(std::string()) : cell(row);
  };
  column.read = [read = column.read](const std::string& text, PoseRow& row) {
    if (!text.empty()) read(text, row);
  };
  return column;
}

/// A column of the pose that a selector gave itself; empty where it gave none.
CsvColumn<PoseRow> ownColumn(const CsvColumn<OwnPose>& column) {
  return {column.name,
          [cell = column.cell](const PoseRow& row) {
            return row.own ? cell(*row.own) : CellValue(std::string());
          },
          [read = column.read](const std::string& text, PoseRow& row) {
            if (text.empty()) return;
            if (!row.own) row.own.emplace();
            read(text, *row.own);
          }};
}

CsvColumn<OwnPose> uncertainColumn() {
  const std::string name = "uncertain";
  return {name, [](const OwnPose& own) { return CellValue(own.uncertain ? 1 : 0); },
          [name](const std::string& text, OwnPose& own) {
            const int value = parseInteger(text, name);
            if (value != 0 && value != 1)
              throw std::invalid_argument(name + ": '" + text + "' is not 0 or 1");
            own.uncertain = value == 1;
          }};
}

CsvColumn<StageRow> stageNumber() {
  return {"number",
          [](const StageRow& row) { return row.number ? CellValue(*row.number) : CellValue(std::string()); },
          [](const std::string& text, StageRow& row) {
            if (!text.empty()) readCell(text, "number", row.number.emplace());
          }};
}

// The columns of pairs.csv that each tolerance has: "n_inliers_5px", "n_correct_5px".
const std::string kInliers = "n_inliers_", kCorrect = "n_correct_", kUnit = "px";

// pairs.csv begins with this and the number of its format. Format 1 had a row for each tolerance and no such
// line.
constexpr int kPairsFormat = 2;
const std::string kFormatBeginning = "# corrsel pairs ";

bool startsWith(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

/// Throws where the first line of a pairs.csv is not that of this version.
void requireFormat(const std::string& file, const std::string& line) {
  std::string found;
  if (startsWith(line, "dataset,")) {
    found = "1 (no line with a version), which corrsel wrote up to version 0.1.0";
  } else if (startsWith(line, kFormatBeginning)) {
    found = line.substr(kFormatBeginning.size());
  } else {
    throw RunFolderError(file + ", line 1: '" + kFormatBeginning + std::to_string(kPairsFormat) +
                         "' is missing, so this is no file of a benchmark run; give the output folder of a "
                         "run");
  }
  if (found == std::to_string(kPairsFormat)) return;
  throw RunFolderError(
      file + " has format " + found + "; this version reads format " + std::to_string(kPairsFormat) +
      ". Run the benchmark again with the settings in the folder's config.yaml and another output folder, or "
      "read the folder with the version that wrote it, which its environment.json names");
}

bool isLabelled(const ResultRow& row) { return row.truth == TruthKind::kLabels; }

/// A count of a column of pairs.csv that only some kinds of truth have. @return nothing for an empty cell
std::optional<std::size_t> countIn(const std::string& text, const std::string& column, bool expected,
                                   const ResultRow& row) {
  if (text.empty()) return std::nullopt;
  std::size_t count = 0;
  readCell(text, column, count);
  if (expected) return count;
  throw std::invalid_argument(column + " = " + text + " beside the truth " + toString(row.truth));
}

CellValue countCell(std::size_t count) { return count; }

/// The number of inliers at tolerance i. Reading it adds the metrics of this tolerance to the row.
CsvColumn<ResultRow> inlierColumn(double tau, std::size_t i) {
  const std::string name = kInliers + formatNumber(tau) + kUnit;
  return {name,
          [i](const ResultRow& row) {
            const bool known = row.truth != TruthKind::kNone && !isLabelled(row);
            return known ? countCell(row.metrics.at(i).n_inliers) : CellValue(std::string());
          },
          [name, tau](const std::string& text, ResultRow& row) {
            const bool known = row.truth != TruthKind::kNone && !isLabelled(row);
            const auto count = countIn(text, name, known, row);
            if (isLabelled(row)) return;
            Metrics& metrics = row.metrics.emplace_back();
            metrics.tau = tau;
            metrics.n_inliers = count.value_or(0);
          }};
}

/// The number of selected inliers at tolerance i. It is read after the inliers and the selected matches.
CsvColumn<ResultRow> correctColumn(double tau, std::size_t i) {
  const std::string name = kCorrect + formatNumber(tau) + kUnit;
  return {name,
          [i](const ResultRow& row) {
            const bool known = row.truth != TruthKind::kNone && !isLabelled(row);
            return known ? countCell(row.metrics.at(i).n_correct) : CellValue(std::string());
          },
          [name, i](const std::string& text, ResultRow& row) {
            const bool known = row.truth != TruthKind::kNone && !isLabelled(row);
            const auto count = countIn(text, name, known, row);
            if (!count) return;
            Metrics& metrics = row.metrics.at(i);
            metrics = metricsOf(metrics.tau, *count, metrics.n_inliers, row.n_selected, row.n_ground_truth);
          }};
}

/// The same of labelled truth, which has no tolerance, and whose inliers are n_ground_truth.
CsvColumn<ResultRow> labelledColumn() {
  const std::string name = kCorrect + "labels";
  return {name,
          [](const ResultRow& row) {
            return isLabelled(row) ? countCell(row.metrics.at(0).n_correct) : CellValue(std::string());
          },
          [name](const std::string& text, ResultRow& row) {
            const auto count = countIn(text, name, isLabelled(row), row);
            if (!isLabelled(row)) return;
            Metrics metrics;
            metrics.n_inliers = row.n_ground_truth;
            if (count) {
              metrics = metricsOf(kUndefined, *count, row.n_ground_truth, row.n_selected, row.n_ground_truth);
            }
            row.metrics = {metrics};
          }};
}

}  // namespace

std::string cellText(const CellValue& cell) {
  return std::visit(
      [](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::string>) {
          return value;
        } else if constexpr (std::is_same_v<Value, double>) {
          return formatNumber(value);
        } else {
          return std::to_string(value);
        }
      },
      cell);
}

void readCell(const std::string& text, const std::string&, std::string& field) { field = text; }

void readCell(const std::string& text, const std::string& column, std::size_t& field) {
  if (text.empty()) return;
  const double value = parseNumber(text, column);
  // Beyond 2^53 not every whole number is a double.
  if (!(value >= 0 && value <= 9007199254740992.0) || value != std::floor(value)) {
    throw std::invalid_argument(column + ": '" + text + "' is not a count");
  }
  field = static_cast<std::size_t>(value);
}

void readCell(const std::string& text, const std::string& column, int& field) {
  field = parseInteger(text, column);
}

void readCell(const std::string& text, const std::string& column, double& field) {
  if (!text.empty()) field = parseNumber(text, column);
}

void readCell(const std::string& text, const std::string&, Status& field) { field = statusFromString(text); }

void readCell(const std::string& text, const std::string&, SceneKind& field) {
  if (!text.empty()) field = sceneFromString(text);
}

void readCell(const std::string& text, const std::string& column, PoseModel& field) {
  try {
    field = poseModelFromString(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(column + ": " + error.what());
  }
}

void readCell(const std::string& text, const std::string& column, Motion& field) {
  try {
    field = motionFromString(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(column + ": " + error.what());
  }
}

void readCell(const std::string& text, const std::string& column, TruthKind& field) {
  try {
    field = truthKindFromString(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(column + ": " + error.what());
  }
}

CsvTable<ResultRow> pairsTable(const std::vector<double>& tolerances) {
  std::vector<CsvColumn<ResultRow>> columns = {
      csvColumn("dataset", &ResultRow::id, &PairId::dataset),
      csvColumn("sequence", &ResultRow::id, &PairId::sequence),
      csvColumn("pair", &ResultRow::id, &PairId::pair),
      csvColumn("features", &ResultRow::features),
      csvColumn("preselection", &ResultRow::preselection),
      csvColumn("selector", &ResultRow::selector),
      csvColumn("truth", &ResultRow::truth),
      csvColumn("n_left", &ResultRow::n_left),
      csvColumn("n_right", &ResultRow::n_right),
      csvColumn("n_putative", &ResultRow::n_putative),
      csvColumn("n_ground_truth", &ResultRow::n_ground_truth),
  };
  for (std::size_t i = 0; i < tolerances.size(); ++i) columns.push_back(inlierColumn(tolerances[i], i));
  columns.push_back(ifEvaluated(csvColumn("n_selected", &ResultRow::n_selected)));
  columns.push_back(ifEvaluated(labelledColumn()));
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    columns.push_back(ifEvaluated(correctColumn(tolerances[i], i)));
  }
  for (const CsvColumn<ResultRow>& column : {
           csvColumn("status", &ResultRow::status),
           ifEvaluated(csvColumn("scene", &ResultRow::scene)),
           ifEvaluated(csvColumn("confidence", &ResultRow::confidence)),
           csvColumn("seed", &ResultRow::seed),
           csvColumn("detect_s", &ResultRow::detect_seconds),
           csvColumn("describe_s", &ResultRow::describe_seconds),
           csvColumn("match_s", &ResultRow::match_seconds),
           ifEvaluated(csvColumn("select_s", &ResultRow::select_seconds)),
       }) {
    columns.push_back(column);
  }
  return {kPairsFile, columns, kFormatBeginning + std::to_string(kPairsFormat)};
}

CsvTable<ResultRow> pairsTableIn(const std::string& file) {
  std::vector<std::string> head;
  std::ifstream in(file, std::ios::binary);
  for (std::string line; head.size() < 2 && std::getline(in, line);) head.push_back(line);
  head.resize(2);
  requireFormat(file, head[0]);
  std::vector<double> tolerances;
  for (const std::string& name : parseCsvLine(head[1])) {
    const bool of_tolerance = startsWith(name, kInliers) && name.size() > kInliers.size() + kUnit.size();
    if (!of_tolerance) continue;
    const std::string tau = name.substr(kInliers.size(), name.size() - kInliers.size() - kUnit.size());
    tolerances.push_back(std::strtod(tau.c_str(), nullptr));
  }
  CsvTable<ResultRow> table = pairsTable(tolerances);
  if (table.header() == head[1]) return table;
  throw RunFolderError(file +
                       ", line 2: this is not the header that this version writes; run the benchmark again "
                       "into another folder");
}

const CsvTable<PoseRow>& posesTable() {
  static const CsvTable<PoseRow> table(
      "poses.csv", {
                       csvColumn("dataset", &PoseRow::id, &PairId::dataset),
                       csvColumn("sequence", &PoseRow::id, &PairId::sequence),
                       csvColumn("pair", &PoseRow::id, &PairId::pair),
                       csvColumn("features", &PoseRow::features),
                       csvColumn("preselection", &PoseRow::preselection),
                       csvColumn("selector", &PoseRow::selector),
                       csvColumn("seed", &PoseRow::seed),
                       csvColumn("status", &PoseRow::status),
                       ifEvaluated(csvColumn("n_selected", &PoseRow::n_selected)),
                       ifPose(csvColumn("model", &PoseRow::model)),
                       ifPose(csvColumn("n_inliers", &PoseRow::n_inliers)),
                       csvColumn("rotation_deg", &PoseRow::rotation_error),
                       csvColumn("translation_deg", &PoseRow::translation_error),
                       csvColumn("pose_deg", &PoseRow::pose_error),
                       csvColumn("epipolar_precision", &PoseRow::epipolar_precision),
                       csvColumn("corner_px", &PoseRow::corner_error),
                       csvColumn("estimate_s", &PoseRow::seconds),
                       ownColumn(csvColumn("motion", &OwnPose::motion)),
                       ownColumn(csvColumn("true_motion", &OwnPose::true_motion)),
                       ownColumn(csvColumn("own_rotation_deg", &OwnPose::rotation_error)),
                       ownColumn(csvColumn("own_translation_deg", &OwnPose::translation_error)),
                       ownColumn(csvColumn("own_pose_deg", &OwnPose::pose_error)),
                       ownColumn(csvColumn("second_pose_deg", &OwnPose::second_error)),
                       ownColumn(csvColumn("nees", &OwnPose::normalized, &NormalizedError::squared)),
                       ownColumn(csvColumn("nees_degrees", &OwnPose::normalized, &NormalizedError::degrees)),
                       ownColumn(uncertainColumn()),
                   });
  return table;
}

const CsvTable<PoseSummaryRow>& poseSummaryTable() {
  static const CsvTable<PoseSummaryRow> table(
      "pose_summary.csv",
      {
          csvColumn("dataset", &PoseSummaryRow::dataset),
          csvColumn("features", &PoseSummaryRow::features),
          csvColumn("preselection", &PoseSummaryRow::preselection),
          csvColumn("selector", &PoseSummaryRow::selector),
          csvColumn("poses", &PoseSummaryRow::poses),
          csvColumn("no_pose", &PoseSummaryRow::no_pose),
          csvColumn("auc_5", &PoseSummaryRow::auc_5),
          csvColumn("auc_10", &PoseSummaryRow::auc_10),
          csvColumn("auc_10_lo", &PoseSummaryRow::auc_10_low),
          csvColumn("auc_10_hi", &PoseSummaryRow::auc_10_high),
          csvColumn("auc_20", &PoseSummaryRow::auc_20),
          csvColumn("maa_10", &PoseSummaryRow::accuracy),
          csvColumn("rotation_deg_median", &PoseSummaryRow::rotation_median),
          csvColumn("translation_deg_median", &PoseSummaryRow::translation_median),
          csvColumn("pose_deg_median", &PoseSummaryRow::pose_median),
          csvColumn("epipolar_precision", &PoseSummaryRow::epipolar_precision),
          csvColumn("homographies", &PoseSummaryRow::homographies),
          csvColumn("no_homography", &PoseSummaryRow::no_homography),
          csvColumn("corner_auc_1", &PoseSummaryRow::corner_auc_1),
          csvColumn("corner_auc_3", &PoseSummaryRow::corner_auc_3),
          csvColumn("corner_auc_3_lo", &PoseSummaryRow::corner_auc_3_low),
          csvColumn("corner_auc_3_hi", &PoseSummaryRow::corner_auc_3_high),
          csvColumn("corner_auc_5", &PoseSummaryRow::corner_auc_5),
          csvColumn("corner_px_median", &PoseSummaryRow::corner_median),
          csvColumn("estimate_s_median", &PoseSummaryRow::seconds_median),
          csvColumn("own_poses", &PoseSummaryRow::own, &OwnPoseSummary::poses),
          csvColumn("own_no_pose", &PoseSummaryRow::own, &OwnPoseSummary::no_pose),
          csvColumn("own_auc_5", &PoseSummaryRow::own, &OwnPoseSummary::auc_5),
          csvColumn("own_auc_10", &PoseSummaryRow::own, &OwnPoseSummary::auc_10),
          csvColumn("own_auc_10_lo", &PoseSummaryRow::own, &OwnPoseSummary::auc_10_low),
          csvColumn("own_auc_10_hi", &PoseSummaryRow::own, &OwnPoseSummary::auc_10_high),
          csvColumn("own_auc_20", &PoseSummaryRow::own, &OwnPoseSummary::auc_20),
          csvColumn("own_rotation_deg_median", &PoseSummaryRow::own, &OwnPoseSummary::rotation_median),
          csvColumn("own_translation_deg_median", &PoseSummaryRow::own, &OwnPoseSummary::translation_median),
          csvColumn("own_pose_deg_median", &PoseSummaryRow::own, &OwnPoseSummary::pose_median),
          csvColumn("uncertain", &PoseSummaryRow::own, &OwnPoseSummary::uncertain),
          csvColumn("nees_poses", &PoseSummaryRow::own, &OwnPoseSummary::with_translation,
                    &ConsistencySummary::poses),
          csvColumn("nees_mean", &PoseSummaryRow::own, &OwnPoseSummary::with_translation,
                    &ConsistencySummary::mean),
          csvColumn("nees_median", &PoseSummaryRow::own, &OwnPoseSummary::with_translation,
                    &ConsistencySummary::median),
          csvColumn("nees_inside_95", &PoseSummaryRow::own, &OwnPoseSummary::with_translation,
                    &ConsistencySummary::inside),
          csvColumn("nees_rotation_poses", &PoseSummaryRow::own, &OwnPoseSummary::rotations,
                    &ConsistencySummary::poses),
          csvColumn("nees_rotation_mean", &PoseSummaryRow::own, &OwnPoseSummary::rotations,
                    &ConsistencySummary::mean),
          csvColumn("nees_rotation_median", &PoseSummaryRow::own, &OwnPoseSummary::rotations,
                    &ConsistencySummary::median),
          csvColumn("nees_rotation_inside_95", &PoseSummaryRow::own, &OwnPoseSummary::rotations,
                    &ConsistencySummary::inside),
      });
  return table;
}

const CsvTable<SummaryRow>& summaryTable() {
  static const CsvTable<SummaryRow> table("summary.csv",
                                          {
                                              csvColumn("dataset", &SummaryRow::dataset),
                                              csvColumn("features", &SummaryRow::features),
                                              csvColumn("preselection", &SummaryRow::preselection),
                                              csvColumn("selector", &SummaryRow::selector),
                                              csvColumn("tau_px", &SummaryRow::tau),
                                              csvColumn("pairs", &SummaryRow::pairs),
                                              csvColumn("precision", &SummaryRow::precision),
                                              csvColumn("recall_paper", &SummaryRow::recall_paper),
                                              csvColumn("f_paper", &SummaryRow::f_paper),
                                              csvColumn("f_paper_lo", &SummaryRow::f_low),
                                              csvColumn("f_paper_hi", &SummaryRow::f_high),
                                              csvColumn("recall_same_tau", &SummaryRow::recall_same_tau),
                                              csvColumn("f_same_tau", &SummaryRow::f_same_tau),
                                              csvColumn("confidence_median", &SummaryRow::confidence_median),
                                              csvColumn("select_s_median", &SummaryRow::select_median),
                                              csvColumn("select_s_p95", &SummaryRow::select_p95),
                                          });
  return table;
}

const CsvTable<StageRow>& stagesTable() {
  static const CsvTable<StageRow> table("stages.csv",
                                        {
                                            stageNumber(),
                                            csvColumn("dataset", &StageRow::id, &PairId::dataset),
                                            csvColumn("sequence", &StageRow::id, &PairId::sequence),
                                            csvColumn("pair", &StageRow::id, &PairId::pair),
                                            csvColumn("stage", &StageRow::stage, &StageTime::stage),
                                            csvColumn("seconds", &StageRow::stage, &StageTime::seconds),
                                        });
  return table;
}

const CsvTable<ScalingRow>& scalingTable() {
  static const CsvTable<ScalingRow> table("scaling.csv",
                                          {
                                              csvColumn("selector", &ScalingRow::selector),
                                              csvColumn("threads", &ScalingRow::threads),
                                              csvColumn("n", &ScalingRow::n),
                                              csvColumn("round", &ScalingRow::round),
                                              csvColumn("n_selected", &ScalingRow::n_selected),
                                              csvColumn("status", &ScalingRow::status),
                                              csvColumn("select_s", &ScalingRow::select_seconds),
                                          });
  return table;
}

const CsvTable<Failure>& failuresTable() {
  static const CsvTable<Failure> table("failures.csv",
                                       {
                                           csvColumn("dataset", &Failure::id, &PairId::dataset),
                                           csvColumn("sequence", &Failure::id, &PairId::sequence),
                                           csvColumn("pair", &Failure::id, &PairId::pair),
                                           csvColumn("features", &Failure::features),
                                           csvColumn("stage", &Failure::stage),
                                           csvColumn("error", &Failure::error),
                                       });
  return table;
}

const CsvTable<TruthCheck>& truthChecksTable() {
  static const CsvTable<TruthCheck> table(
      "truth_check.csv", {
                             csvColumn("dataset", &TruthCheck::id, &PairId::dataset),
                             csvColumn("sequence", &TruthCheck::id, &PairId::sequence),
                             csvColumn("pair", &TruthCheck::id, &PairId::pair),
                             csvColumn("features", &TruthCheck::features),
                             csvColumn("truth", &TruthCheck::kind),
                             csvColumn("reading", &TruthCheck::reading),
                             csvColumn("tolerance_px", &TruthCheck::tolerance),
                             csvColumn("n_putative", &TruthCheck::n_putative),
                             csvColumn("n_truth", &TruthCheck::n_truth),
                             csvColumn("n_reading", &TruthCheck::n_reading),
                             csvColumn("n_truth_by_chance", &TruthCheck::n_truth_by_chance),
                             csvColumn("n_reading_by_chance", &TruthCheck::n_reading_by_chance),
                         });
  return table;
}

const CsvTable<Remark>& remarksTable() {
  static const CsvTable<Remark> table("remarks.csv", {
                                                         csvColumn("dataset", &Remark::dataset),
                                                         csvColumn("sequence", &Remark::sequence),
                                                         csvColumn("selector", &Remark::selector),
                                                         csvColumn("remark", &Remark::text),
                                                     });
  return table;
}

std::vector<Remark> readRemarks(const std::string& folder) {
  const std::filesystem::path file = std::filesystem::path(folder) / remarksTable().file();
  if (!std::filesystem::exists(file)) return {};
  return remarksTable().intactRows(readTextFile(file.string()));
}

const CsvTable<ExampleImage>& imagesTable() {
  static const CsvTable<ExampleImage> table("images/index.csv",
                                            {
                                                csvColumn("file", &ExampleImage::file),
                                                csvColumn("dataset", &ExampleImage::id, &PairId::dataset),
                                                csvColumn("sequence", &ExampleImage::id, &PairId::sequence),
                                                csvColumn("pair", &ExampleImage::id, &PairId::pair),
                                                csvColumn("features", &ExampleImage::features),
                                                csvColumn("preselection", &ExampleImage::preselection),
                                                csvColumn("selector", &ExampleImage::selector),
                                                csvColumn("n_selected", &ExampleImage::n_selected),
                                                csvColumn("n_correct", &ExampleImage::n_correct),
                                                csvColumn("n_wrong", &ExampleImage::n_wrong),
                                                csvColumn("n_missed", &ExampleImage::n_missed),
                                                csvColumn("tau_px", &ExampleImage::tau),
                                            });
  return table;
}

const CsvTable<SavedSelection>& savedMatchesTable() {
  static const CsvTable<SavedSelection> table(
      "matches/index.csv", {
                               csvColumn("file", &SavedSelection::file),
                               csvColumn("dataset", &SavedSelection::id, &PairId::dataset),
                               csvColumn("sequence", &SavedSelection::id, &PairId::sequence),
                               csvColumn("pair", &SavedSelection::id, &PairId::pair),
                               csvColumn("features", &SavedSelection::features),
                               csvColumn("preselection", &SavedSelection::preselection),
                               csvColumn("selector", &SavedSelection::selector),
                               csvColumn("seed", &SavedSelection::seed),
                               csvColumn("status", &SavedSelection::status),
                               csvColumn("n_putative", &SavedSelection::n_putative),
                               csvColumn("n_selected", &SavedSelection::n_selected),
                               csvColumn("model_kind", &SavedSelection::model_kind),
                               csvColumn("model", &SavedSelection::model),
                               csvColumn("putative", &SavedSelection::putative),
                               csvColumn("left_image", &SavedSelection::left_image),
                               csvColumn("right_image", &SavedSelection::right_image),
                               csvColumn("left_width", &SavedSelection::left_width),
                               csvColumn("left_height", &SavedSelection::left_height),
                               csvColumn("right_width", &SavedSelection::right_width),
                               csvColumn("right_height", &SavedSelection::right_height),
                           });
  return table;
}

}  // namespace corrsel::core
