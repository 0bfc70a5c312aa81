#pragma once

#include <map>
#include <string>
#include <vector>

#include "corrsel/options.h"

namespace corrsel::core {

/// A column of the grid: the features that the putative matches are made of, and the preselection that
/// reduces these matches.
struct Cell {
  std::string features, preselection;

  /// "features/preselection".
  std::string text() const { return features + "/" + preselection; }
  bool operator==(const Cell& other) const {
    return features == other.features && preselection == other.preselection;
  }
};

/// Everything that decides what a benchmark run computes. The output folder and switches such as the
/// verbosity are not part of it.
struct BenchmarkConfig {
  std::string experiment;                         ///< name of the preset that filled this in; empty = none
  std::vector<std::string> sections;              ///< experiments that the report shows; empty without preset
  std::vector<std::string> datasets;              ///< names for openDataset(); empty if bags are given
  std::string data_root;                          ///< folder that holds one folder per dataset
  std::vector<std::string> bags;                  ///< bags, instead of datasets
  std::map<std::string, std::string> bag_topics;  ///< how to read the bags: BagTopics by name
  std::vector<std::string> features = {"sift+sift", "orb+orb"};  ///< "all" = the named combinations
  std::vector<std::string> preselection = {"none", "nnsr"};
  std::vector<Cell> cells;  ///< if not empty, replaces the grid of features and preselection
  std::vector<std::string> selectors = {
      "all"};  ///< names for createSelector(); "all" = usualSelectorNames(), "every" = selectorNames()
  std::vector<double> tolerances = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};  ///< tau, px, above 0, ascending
  double ground_truth_tolerance = 10.0;                              ///< t_gt, px
  int repetitions = 1;  ///< runs of every selector on every pair, with seeds seed, seed + 1...
  int threads = 1;      ///< 0 = all cores
  int seed = 0;
  int max_pairs = 0;                         ///< first pairs of every dataset or bag; 0 = all
  bool save_matches = false;                 ///< whether the matches of every selection are written, too
  std::map<std::string, OptionMap> options;  ///< per algorithm ("gms", "sift"): options given by the user

  /// Replaces "all", adds the baseline keep_all and the variants of the preset, drops repeated names, and
  /// makes cells, features and preselection agree. Every value is checked; each extractor and selector is
  /// created once for that. Throws std::invalid_argument naming the argument, the value and what is valid.
  void resolve();

  /// The resolved configuration as YAML, every option of every algorithm with its value.
  std::string toYaml() const;

  /// Options given by the user for the algorithm of "name", "name:preset" or "name[option=value]", without
  /// those in the brackets.
  OptionMap optionsOf(const std::string& spec) const;

  /// What the benchmark offers a selector beside optionsOf(): the seed of the repetition, and the kind of
  /// model that the ground truth is of. A selector whose own default is to find the kind of model, such as
  /// `auto`, is not told.
  OptionMap offeredTo(const std::string& spec, bool homography, int repetition) const;

  /// The columns of the grid.
  std::vector<Cell> grid() const;

  /// The tolerance of tables and pictures, px: the paper's 5 px if it is evaluated, otherwise the largest
  /// one.
  double tableTolerance() const;

  /// Preselections for putative matches of these features. A preset does not preselect the matches that a
  /// dataset provides ("given"): they lack what NNSR needs, and the paper does not preselect them either.
  std::vector<std::string> preselectionsOf(const std::string& features_name) const;

  /// Returns whether the preset measures selection times against the number of matches.
  bool measuresScaling() const;
};

/// Whether the selector is NNSR, whatever its preset and options. It is not run on the matches that it has
/// preselected.
bool isNnsr(const std::string& spec);

/// The name of a bag in results: its file name without folder and extension. It is the dataset of the bag's
/// pairs, so BenchmarkConfig::resolve() refuses two bags that share it.
std::string bagName(const std::string& path);

/// Reads "gms.alpha=3,lpm.k=6" (comma-separated "algorithm.option=value") into config.options.
/// Throws std::invalid_argument where an assignment has another form or an option is given twice.
void parseOptionAssignments(const std::string& text, std::map<std::string, OptionMap>& options);

/// Keys whose values differ between two YAML documents, as "key: old -> new" (nested keys joined by '.').
/// Throws std::invalid_argument if one is not YAML.
std::vector<std::string> yamlDifferences(const std::string& before, const std::string& now);

}  // namespace corrsel::core
