#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "measurement.h"

namespace corrsel::performance {

/// The outcome of a target.
struct Verdict {
  std::string text;  ///< the target and the measurement
  bool passed;
};

/// One selector and its alternative, on the same matches.
struct Row {
  std::string comparison;  ///< name of the benchmark
  SceneSpec scene;
  Measurement ours, peer;     ///< peer.name is empty where there is no alternative
  bool same_mask = false;     ///< the masks must be identical
  std::size_t differing = 0;  ///< number of matches that the two select differently, over all scenes
};

/// One selector at several sizes.
struct GrowthRow {
  std::string comparison;
  std::vector<std::size_t> sizes;     ///< numbers of matches, rising
  std::vector<Measurement> measured;  ///< one per size
  double exponent;                    ///< p of time ~ N^p for the larger sizes
};

/// Features of one photograph and of one alternative.
struct FeatureRow {
  std::string comparison;
  std::string image;             ///< its size
  std::size_t limit;             ///< max_features; 0 = all
  Measurement ours, peer;        ///< peer.name is empty where there is no alternative
  std::size_t ours_n, peer_n;    ///< features found
  bool must_be_identical, same;  ///< the features
};

/// Where the time of a pair of photographs goes.
struct StageRow {
  std::string comparison;
  std::string image;  ///< its size
  std::size_t limit;  ///< max_features; 0 = all
  std::size_t n;      ///< features of the left image
  Measurement features, matching, selection;
};

/// What the stages of a detector and its descriptor cost.
struct CostRow {
  std::string comparison, features;
  std::string image;  ///< its size
  std::size_t n;      ///< features found
  Measurement search, detection, all;
};

/// The search for a model among few inliers, one row per method.
struct HardRow {
  std::string comparison, method;
  double inlier_ratio;
  int seeds, found;     ///< number of runs, and of runs that found the model
  double milliseconds;  ///< median
};

/// Collects the measurements and writes them as tables.
class Report {
 public:
  void add(const Row& row);
  void add(const GrowthRow& row);
  void add(const FeatureRow& row);
  void add(const StageRow& row);
  void add(const CostRow& row);
  void add(const HardRow& row);
  void add(const Verdict& verdict);
  /// A comparison that could not be made, e.g. because a selector does not exist.
  void addFailure(const std::string& comparison, const std::string& reason);

  /// The lines of the console's table since the last call.
  std::string newLines();

  /// The targets, one line each, and how many are met.
  std::string targets() const;

  /// Everything as Markdown tables. @param command  the command, for the heading
  std::string markdown(const std::string& command) const;

  /// One line per row, with the machine.
  void writeCsv(std::ostream& out) const;

  /// Whether all comparisons were made, all masks that must agree do, and all targets are met.
  bool good() const;

  static std::string consoleHeader();
  /// Processor, compiler, OpenCV, instruction set of the kernels, commit: one line.
  static std::string machine();

 private:
  std::vector<Row> rows_;
  std::vector<GrowthRow> growth_;
  std::vector<FeatureRow> features_;
  std::vector<StageRow> stages_;
  std::vector<CostRow> costs_;
  std::vector<HardRow> hard_;
  std::vector<Verdict> verdicts_;
  std::vector<std::pair<std::string, std::string>> failures_;
  std::string new_lines_;
};

/// Writes `text` to the file. Throws std::runtime_error where that fails.
void writeMarkdown(const std::string& file, const std::string& text);

/// Three significant digits; empty for NaN.
std::string shortNumber(double value);

}  // namespace corrsel::performance
