#include "programs/verify/arguments.h"

#include <algorithm>
#include <thread>

#include "base/text.h"
#include "corrsel/database/pair_verifier.h"
#include "programs/command_line.h"

namespace corrsel {
namespace {

constexpr int kMostThreads = 1024;
constexpr double kMostMemory = 1e6;  // GiB

constexpr char kPurpose[] =
    "Decides for all pairs of images in a database of COLMAP, or in files of hloc, whether both images show "
    "the same scene, and stores inliers, matrices and poses. A run that was killed continues when the same "
    "command is given again.";

constexpr char kNotes[] =
    "examples:\n"
    "  corrsel_verify house.db --output verified.db --report pairs.csv,pairs.html\n"
    "  corrsel_verify new.db --extract photos --match      from a folder of images to a verified database\n"
    "  corrsel_verify matches.h5 --features features.h5 --output verified.h5\n"
    "exit code: 0 = all pairs are verified, 1 = faulty pairs or images, which are printed, 2 = wrong\n"
    "arguments or unusable files, 3 = another program writes to the database, 4 = a file cannot be read or\n"
    "written, 130 = interrupted\n";

const CommandLineTable& table() {
  static const CommandLineTable result = {
      "corrsel_verify",
      kPurpose,
      {"DATABASE"},
      {
          {"output", "FILE", "",
           "write a copy, called FILE.part until it is complete; default: DATABASE itself changes"},
          {"features", "FILE", "", "DATABASE is a file of matches of hloc, and FILE its file of features"},
          {"pairs", "FILE", "", "only these pairs: two names of images a line"},
          {"selector", "NAME", core::PairVerifierOptions().selector,
           "what selects among the matches, with presets and options as in the benchmark"},
          {"options", "LIST", "",
           "options of verification, comma-separated (min_matches=20), of matching (match.ratio=0.9) and of "
           "extraction "
           "(extract.max_features=5000)"},
          {"extract", "FOLDER", "",
           "first add the images of FOLDER with their features; DATABASE is created if necessary"},
          {"camera", "LIST", "",
           "camera of all extracted images, trusted: COLMAP's name of the model and its parameters, e.g. "
           "PINHOLE,1000,1000,600,400"},
          {"match", "", "", "match descriptors first, every pair that has no matches yet"},
          {"sequential", "K", "0", "match every image with the K next ones by name; 0 = with all"},
          {"threads", "N", "0", "threads, 0 = all cores; results do not depend on it"},
          {"memory", "GIB", "1",
           "memory for keypoints, and for descriptors, that are kept for further pairs"},
          {"again", "", "", "also verify pairs that are verified already, by corrsel or by another program"},
          {"shard", "I/N", "",
           "verify only the i-th of n parts of the pairs and write them into the small file --output"},
          {"merge", "LIST", "", "files of such parts, comma-separated, that are taken over first"},
          {"tracks", "FILE", "",
           "write the tracks through the verified matches as CSV, without pairs that contradict others"},
          {"report", "LIST", "",
           "files to write, comma-separated: .csv (pairs), .json (summary), .html (page)"},
          {"dry-run", "", "", "verify and report, and write no database"},
          {"strict", "", "", "stop at the first faulty pair"},
      },
      kNotes};
  return result;
}

/// Sets "name=value" in the set of options that the name's prefix means.
void setOption(const std::string& assignment, VerifyArguments& arguments) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw UsageError("--options: '" + assignment + "' does not read as name=value, e.g. min_matches=20");
  }
  const std::string name = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  const std::size_t dot = name.find('.');
  const std::string prefix = dot == std::string::npos ? "" : name.substr(0, dot);
  if (prefix.empty()) return core::setOptions(arguments.verifier, {{name, value}}, "verification");
  const core::OptionMap values = {{name.substr(dot + 1), value}};
  if (prefix == "match") return core::setOptions(arguments.matching, values, prefix);
  if (prefix == "extract") return core::setOptions(arguments.extraction, values, prefix);
  throw UsageError("--options: '" + name + "' begins with neither match. nor extract.");
}

std::optional<core::ColmapCamera> cameraFromList(const std::vector<std::string>& words) {
  if (words.empty()) return std::nullopt;
  core::ColmapCamera camera;
  camera.model = words[0];
  for (std::size_t i = 1; i < words.size(); ++i) {
    camera.parameters.push_back(core::parseNumber(words[i], "--camera"));
  }
  return camera;
}

void readPaths(const ArgumentValues& values, VerifyArguments& arguments) {
  arguments.database = values.text("DATABASE");
  arguments.features = values.text("features");
  arguments.output = values.text("output");
  arguments.pairs = values.text("pairs");
  arguments.images = values.text("extract");
  arguments.tracks = values.text("tracks");
  for (const std::string& part : values.list("merge")) arguments.merge.emplace_back(part);
  for (const std::string& report : values.list("report")) {
    const std::filesystem::path path = report;
    const std::string ending = path.extension().string();
    if (ending != ".csv" && ending != ".json" && ending != ".html") {
      throw UsageError("--report: '" + report + "' ends in none of .csv, .json, .html");
    }
    arguments.reports.push_back(path);
  }
}

void require(bool condition, const std::string& message) {
  if (!condition) throw UsageError(message);
}

/// Throws UsageError for arguments that contradict each other.
void checkTogether(const VerifyArguments& arguments) {
  const bool divided = arguments.shard.count > 1, hloc = !arguments.features.empty();
  const bool output = !arguments.output.empty(), dry = arguments.run.dry_run;
  require(!output || arguments.output != arguments.database,
          "--output is DATABASE itself; leave it out to change the database");
  require(!divided || output || dry, "--shard needs --output: the file that takes the results of the part");
  require(!divided || arguments.merge.empty(), "--shard and --merge are given: leave one");
  require(!(divided || !arguments.merge.empty()) || !hloc,
          "--shard and --merge need a database of COLMAP; divide files of hloc with --pairs");
  require(!arguments.match || !hloc, "--match needs a database of COLMAP with descriptors, not --features");
  require(!arguments.match || !divided, "--match and --shard are given: match before the run is divided");
  require(arguments.images.empty() || (!hloc && !divided && !output),
          "--extract fills DATABASE itself: give it without --output, --features and --shard");
  require(!dry || (!arguments.match && arguments.images.empty() && arguments.merge.empty()),
          "--dry-run writes nothing, so it cannot --extract, --match or --merge");
  require(arguments.tracks.empty() || !(divided || dry),
          "--tracks needs all stored pairs: give it without --shard and --dry-run");
  require(!hloc || output || dry, "files of hloc are never changed: give --output");
  require(!arguments.camera || !arguments.images.empty(), "--camera is given without --extract");
  require(arguments.sequential == 0 || (arguments.match && arguments.pairs.empty()),
          "--sequential needs --match, and no --pairs");
}

}  // namespace

VerifyArguments parseVerifyArguments(const std::vector<std::string>& words) {
  const ArgumentValues values = parseCommandLine(table(), words);
  VerifyArguments arguments;
  if (values.help) {
    arguments.help = helpText(table());
    return arguments;
  }
  readPaths(values, arguments);
  arguments.verifier.selector = values.text("selector");
  arguments.camera = cameraFromList(values.list("camera"));
  arguments.match = values.isOn("match");
  arguments.sequential = values.integer("sequential", 0, 1000000);
  arguments.shard = core::Shard::fromText(values.text("shard"));
  const int threads = values.integer("threads", 0, kMostThreads);
  arguments.run.threads =
      threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  arguments.run.memory_gib = values.number("memory", 0, kMostMemory);
  arguments.matching.memory_gib = arguments.run.memory_gib;
  arguments.run.again = values.isOn("again");
  arguments.run.strict = values.isOn("strict");
  arguments.run.dry_run = values.isOn("dry-run");
  for (const std::string& assignment : values.list("options")) setOption(assignment, arguments);
  checkTogether(arguments);
  return arguments;
}

}  // namespace corrsel
