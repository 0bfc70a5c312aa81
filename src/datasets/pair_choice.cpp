#include "datasets/pair_choice.h"

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/files.h"

namespace corrsel::core {
namespace {

/// The names of earlier versions, which files of users may still hold.
std::string currentName(const std::string& name) {
  static const std::map<std::string, std::string> renamed = {{"most_pairs", "max_pairs"},
                                                             {"least_baseline", "min_baseline"},
                                                             {"most_gap", "max_gap"},
                                                             {"least_points", "min_points"}};
  const auto found = renamed.find(name);
  return found == renamed.end() ? name : found->second;
}

}  // namespace

void PairChoice::visit(OptionVisitor& visitor) const {
  visitor.integer({"step", 1, 100000, "frames", "From the left to the right image of a pair of a sequence."},
                  &PairChoice::step);
  visitor.integer(
      {"max_pairs", 1, 1000000, "-",
       "Of a sequence and kind of pairs, or of a reconstruction; they are spread evenly over those "
       "that there are."},
      &PairChoice::max_pairs);
  visitor.number({"min_baseline", 0, 1000, "m",
                  "Of a pair of a sequence; a shorter one has no reliable direction of its translation."},
                 &PairChoice::min_baseline);
  visitor.number({"max_gap", 0, 10, "s", "From an image to the ground-truth poses before and after it."},
                 &PairChoice::max_gap);
  visitor.choice("pairs",
                 {{FramePairs::kStereo, "stereo", "left and right camera at one time"},
                  {FramePairs::kSteps, "steps", "images of the left camera, `step` frames apart"},
                  {FramePairs::kBoth, "both", "both"}},
                 "Of a stereo camera that moves.", &PairChoice::pairs);
  visitor.integer({"min_points", 1, 1000000, "-", "That both images of a pair of a reconstruction see."},
                  &PairChoice::min_points);
}

PairChoice readPairChoice(const std::string& folder) {
  PairChoice choice;
  const std::string path = (std::filesystem::path(folder) / PairChoice::kFile).string();
  if (existingFiles({path}).empty()) return choice;
  OptionMap values;
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root.IsMap() && !root.IsNull()) {
      throw DatasetError(path + ": has no lines 'option: value'; write one option a line, e.g. step: 30");
    }
    for (const auto& entry : root) {
      values[currentName(entry.first.as<std::string>())] = entry.second.as<std::string>();
    }
    setOptions(choice, values, "choice");
    choice.check();
  } catch (const YAML::Exception& error) {
    throw DatasetError(path + ": not readable as YAML: " + error.what() +
                       "; write one option a line, e.g. step: 30");
  } catch (const std::invalid_argument& error) {
    throw DatasetError(path + ": " + error.what());
  }
  return choice;
}

}  // namespace corrsel::core
