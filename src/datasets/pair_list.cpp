#include "datasets/pair_list.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <vector>

#include "base/text.h"
#include "datasets/files.h"
#include "datasets/text_rows.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kUsualName[] = "pairs.txt";
constexpr char kMeaning[] = "image_a image_b turns_a turns_b K_a (9) K_b (9) T_ab (16)";
constexpr std::size_t kTurns = 2, kLeftCamera = 4, kRightCamera = 13, kMotion = 22, kWords = 38;

bool isImageName(const std::string& word) { return isImageExtension(fs::path(word).extension().string()); }

/// Whether the first line of a file that is neither empty nor a comment begins with two images.
bool isList(const std::string& path) {
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    const std::vector<std::string> words = splitList(line, ' ');
    if (words.empty() || words.front()[0] == '#') continue;
    return words.size() >= 2 && isImageName(words[0]) && isImageName(words[1]);
  }
  return false;
}

/// The lists of a folder: the one with the usual name, or else all.
std::vector<std::string> listsOf(const std::string& root) {
  std::vector<std::string> lists;
  for (const std::string& name : fileNames(root)) {
    const std::string path = (fs::path(root) / name).string();
    if (fs::path(name).extension() != ".txt" || !isList(path)) continue;
    if (name == kUsualName) return {path};
    lists.push_back(path);
  }
  return lists;
}

/// "scene_images" for "scene/images/1.jpg"
std::string sequenceOf(const std::string& image, const std::string& list) {
  std::string folder = fs::path(image).parent_path().string();
  std::replace(folder.begin(), folder.end(), '/', '_');
  return folder.empty() ? fs::path(list).stem().string() : folder;
}

cv::Matx33d readCamera(const TextRow& row, std::size_t first) {
  return cv::Matx33d(row.numbers(first, 9).data());
}

/// A camera matrix that a list holds is used for many images.
class Lenses {
 public:
  std::shared_ptr<const Lens> get(const TextRow& row, std::size_t first) {
    const std::vector<double> numbers = row.numbers(first, 9);
    std::shared_ptr<const Lens>& lens = lenses_[numbers];
    if (lens != nullptr) return lens;
    const cv::Matx33d camera = readCamera(row, first);
    const std::string which = first == kLeftCamera ? "K_a" : "K_b";
    if (camera(0, 1) != 0 || camera(1, 0) != 0 || camera(2, 0) != 0 || camera(2, 1) != 0 ||
        camera(2, 2) != 1) {
      row.fail(which + " (entries " + std::to_string(first + 1) + " to " + std::to_string(first + 9) +
               ") is not of the form fx 0 cx 0 fy cy 0 0 1; " + kMeaning + " are expected");
    }
    try {
      Camera pinhole;
      pinhole.matrix = camera;
      lens = std::make_shared<Lens>(which, pinhole);
    } catch (const std::invalid_argument& error) {
      row.fail(error.what());
    }
    return lens;
  }

 private:
  std::map<std::vector<double>, std::shared_ptr<const Lens>> lenses_;
};

int readTurns(const TextRow& row, std::size_t word) {
  const double turns = row.number(word);
  if (turns != 0 && turns != 1 && turns != 2 && turns != 3) {
    row.fail("entry " + std::to_string(word + 1) + ": '" + row.words[word] +
             "' is not a number of quarter turns (0, 1, 2 or 3)");
  }
  return static_cast<int>(turns);
}

RigidMotion readMotion(const TextRow& row) {
  try {
    return motionOf(cv::Matx44d(row.numbers(kMotion, 16).data()));
  } catch (const std::invalid_argument& error) {
    row.fail("T_ab (entries 23 to 38) is not a rigid motion: " + std::string(error.what()));
  }
}

PosedPair readPair(const TextRow& row, const std::string& root, Lenses& lenses) {
  PosedPair pair;
  row.requireWords(kWords, kMeaning);
  pair.left.path = (fs::path(root) / row.words[0]).string();
  pair.right.path = (fs::path(root) / row.words[1]).string();
  pair.left.quarter_turns = readTurns(row, kTurns);
  pair.right.quarter_turns = readTurns(row, kTurns + 1);
  pair.left.lens = lenses.get(row, kLeftCamera);
  pair.right.lens = lenses.get(row, kRightCamera);
  pair.motion = readMotion(row);
  return pair;
}

}  // namespace

PosedDataset readPairList(const std::string& name, const std::string& root) {
  requireFolder(root, "dataset '" + name + "'", "set the path to the folder that holds the list of pairs");
  const std::vector<std::string> lists = listsOf(root);
  if (lists.size() != 1) {
    std::vector<std::string> names;
    for (const std::string& list : lists) names.push_back(fs::path(list).filename().string());
    failWithoutPairs(name, root,
                     names.empty() ? "it has no list of pairs; put one there as pairs.txt, with a line " +
                                         std::string(kMeaning) + " for each pair"
                                   : "it has several lists of pairs, " + joinList(names) +
                                         "; call the one that is meant pairs.txt, or give each a folder");
  }
  const std::string& list = lists.front();
  PosedDataset dataset;
  dataset.files = {list};
  dataset.remedy = "the names in " + list + " are paths below " + root;
  Lenses lenses;
  std::size_t without_truth = 0;
  const std::vector<TextRow> rows = readTextRows(list, "");
  for (const TextRow& row : rows) {
    PosedPair pair;
    const bool two = row.words.size() >= 2;
    const std::string left = row.words.front(), right = two ? row.words[1] : "";
    try {
      if (row.words.size() == 2 || row.words.size() == 4) {
        ++without_truth;
        row.fail(
            "has no ground truth: names, without calibration and pose; a line of a list with ground "
            "truth has 38 entries, " +
            std::string(kMeaning));
      }
      pair = readPair(row, root, lenses);
    } catch (const DatasetError& error) {
      pair.fault = error.what();
    }
    const std::string sequence = sequenceOf(left, list);
    const std::string stems = fs::path(left).stem().string() + "-" + fs::path(right).stem().string();
    pair.id = {name, sequence, two ? stems : "line" + std::to_string(row.line)};
    dataset.pairs.push_back(std::move(pair));
  }
  if (without_truth == rows.size()) {
    failWithoutPairs(name, root,
                     list + " has no ground truth: its " + std::to_string(rows.size()) +
                         " lines name images, without calibration and pose; take the list with 38 entries a "
                         "line (" +
                         kMeaning + "), which is usually called ..._with_gt.txt");
  }
  return dataset;
}

bool hasPairList(const std::string& root) { return !listsOf(root).empty(); }

}  // namespace corrsel::core
