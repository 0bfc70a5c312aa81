#include "programs/benchmark/argument_table.h"

#include "base/text.h"
#include "corrsel/benchmark/experiments.h"

namespace corrsel {
namespace {

constexpr char kPurpose[] =
    "Compares correspondence selectors on image pairs with ground truth and writes the results into a "
    "folder. "
    "It needs no ROS master; where there is one, ~progress and ~score are published.";

constexpr char kExitCodes[] =
    "exit code: 0 = run complete, 1 = incomplete (failed pairs, see failures.csv; dry_run: the data have\n"
    "problems), 2 = wrong arguments or unusable data or folder, 130 = interrupted (continue with --resume "
    "true)\n";

/// An argument whose texts are known when the program is compiled.
struct Row {
  const char *name, *value, *default_value, *meaning;
};

constexpr Row kRows[] = {
    {"dataset", "LIST", "",
     "datasets, comma-separated: the names that --list prints, or any folder below data_root in one of "
     "their layouts; default: those of the experiment, or sample"},
    {"data_root", "FOLDER", "", "folder that holds one folder per dataset, named like the dataset"},
    {"bag", "LIST", "", "bags, comma-separated, instead of datasets: made by make_dataset_bag, or your own"},
    {"left", "TOPIC", "", "topic of the left images in a bag of your own"},
    {"right", "TOPIC", "", "topic of the right images in a bag of your own"},
    {"left_info", "TOPIC", "", "topic of the left camera_info; default: beside the left images"},
    {"right_info", "TOPIC", "", "topic of the right camera_info; default: beside the right images"},
    {"ground_truth", "TOPIC", "", "topic of corrsel/GroundTruth in the bag; default: /ground_truth"},
    {"correspondences", "TOPIC", "",
     "topic of recorded matches, used instead of images; default: found where a bag has no images"},
    {"images", "KIND", "",
     "whether the images are raw or rectified: raw, rectified or auto; default: auto, by the name of "
     "their topic"},
    {"max_stamp_difference", "S", "", "between the two images of a pair, s; default: 0.01"},
    {"features", "LIST", "",
     "detector+descriptor combinations, comma-separated, or all; default: those of the experiment, or "
     "sift+sift,orb+orb"},
    {"preselection", "LIST", "",
     "what reduces the putative matches first: none, nnsr; default: that of the experiment, or "
     "none,nnsr"},
    {"selectors", "LIST", "",
     "selectors, comma-separated, each optionally with a preset (lpm:v2) and options in brackets "
     "('lpm[k=5;lambda_first=4]'), or all (the paper's eight and auto), or every, or package/Class of "
     "another package; default: all"},
    {"options", "LIST", "", "options of the algorithms, comma-separated: gms.alpha=6,sift.max_features=2000"},
    {"tolerances", "LIST", "1,2,3,4,5,6,7,8,9,10", "evaluation tolerances tau, px, comma-separated"},
    {"ground_truth_tolerance", "PX", "10", "error up to which a match is a ground-truth inlier, px"},
    {"repetitions", "N", "1", "runs of every selector on every pair, with the seeds seed, seed+1..."},
    {"threads", "N", "0", "threads, 0 = all cores; results do not depend on it, times do"},
    {"seed", "N", "0", "seed of the selectors and of the generated pairs"},
    {"max_pairs", "N", "0", "number of pairs taken from the beginning of every dataset, 0 = all"},
    {"output_dir", "FOLDER", "",
     "folder of the run; default: a new one below $ROS_HOME/corrsel (~/.ros/corrsel), without ROS "
     "below ~/.local/share/corrsel"},
    {"resume", "BOOL", "false", "continue the run that output_dir holds"},
    {"shard", "I/N", "", "run only the i-th of n parts of the pairs; merge joins the parts"},
    {"merge", "LIST", "",
     "folders of such parts, comma-separated, whose pairs are copied before the run continues"},
    {"save_matches", "LIST", "",
     "save what every selector keeps of every pair, comma-separated: csv, npz, colmap; default: "
     "nothing"},
    {"report", "BOOL", "true", "write report.html at the end"},
    {"verbose", "BOOL", "false",
     "print every evaluated selection, and at the end the tables of all selectors"},
    {"dry_run", "BOOL", "false",
     "check the arguments and the data, print what the run would do and take, and exit; nothing is "
     "kept"},
    {"working_dir", "FOLDER", "", "folder that relative paths start from; default: the current one"},
    {"list", "", "", "print datasets, features, selectors with presets, and their options, and exit"},
};

}  // namespace

const CommandLineTable& benchmarkArguments() {
  static const CommandLineTable table = [] {
    CommandLineTable result = {"benchmark", kPurpose, {}, {}, kExitCodes};
    result.arguments.push_back(
        {"experiment", "NAME", "",
         "preset: " + core::joinList(core::experimentNames()) + "; paper comprises those before it"});
    for (const Row& row : kRows)
      result.arguments.push_back({row.name, row.value, row.default_value, row.meaning});
    return result;
  }();
  return table;
}

}  // namespace corrsel
