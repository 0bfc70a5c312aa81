#include "datasets/homography_pairs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr int kVggImages = 6;
constexpr std::size_t kMaxDigits = 3;  // of an image's number; a longer one is a date or the like

/// Images of a scene; 0 = as many as its files tell.
int imagesPerScene(HomographyLayout layout) {
  switch (layout) {
    case HomographyLayout::kVgg:
      return kVggImages;
    case HomographyLayout::kNumbered:
    case HomographyLayout::kHpatches:
      return 0;
    case HomographyLayout::kSymbench:
    case HomographyLayout::kPairs:
      break;
  }
  return 2;
}

/// Name of image `number` (from 1), without extension.
std::string imageStem(HomographyLayout layout, int number) {
  switch (layout) {
    case HomographyLayout::kVgg:
    case HomographyLayout::kNumbered:
      return "img" + std::to_string(number);
    case HomographyLayout::kHpatches:
      return std::to_string(number);
    case HomographyLayout::kSymbench:
      return "0" + std::to_string(number);
    case HomographyLayout::kPairs:
      break;
  }
  return number == 1 ? "left" : "right";
}

/// Name of the file with the homography from image 1 to image `number` (from 2).
std::string homographyName(HomographyLayout layout, int number) {
  switch (layout) {
    case HomographyLayout::kVgg:
    case HomographyLayout::kNumbered:
      return "H1to" + std::to_string(number) + "p";
    case HomographyLayout::kHpatches:
      return "H_1_" + std::to_string(number);
    case HomographyLayout::kSymbench:
      return "H1to" + std::to_string(number);
    case HomographyLayout::kPairs:
      break;
  }
  return "H.txt";
}

/// Whether the file is the layout's image or homography of that number.
bool isFileOf(HomographyLayout layout, const fs::path& name, int number) {
  const bool image = name.stem().string() == imageStem(layout, number);
  return (image && isImageExtension(name.extension().string())) ||
         (number > 1 && name.string() == homographyName(layout, number));
}

/// The last number in a file's name; 0 where it has none, a long one or one that begins with 0.
int lastNumber(const std::string& name) {
  std::size_t end = name.size();
  while (end > 0 && !std::isdigit(static_cast<unsigned char>(name[end - 1]))) --end;
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1]))) --begin;
  const std::string digits = name.substr(begin, end - begin);
  return digits.empty() || digits.size() > kMaxDigits || digits[0] == '0' ? 0 : std::stoi(digits);
}

/// Highest number of the layout's files in a folder; 0 where it has none of them.
int highestNumber(HomographyLayout layout, const std::string& folder) {
  const int images = imagesPerScene(layout);
  int highest = 0;
  for (const std::string& name : fileNames(folder)) {
    const int found = lastNumber(fs::path(name).stem().string());
    const int first = images > 0 ? 1 : std::max(1, found), last = images > 0 ? images : found;
    for (int number = first; number <= last; ++number) {
      if (isFileOf(layout, name, number)) highest = std::max(highest, number);
    }
  }
  return highest;
}

/// The files of a pair; the images without their extensions.
struct PairFiles {
  std::string left, right, homography;
};

PairFiles pairFiles(HomographyLayout layout, const std::string& folder, int right) {
  const fs::path path(folder);
  return {(path / imageStem(layout, 1)).string(), (path / imageStem(layout, right)).string(),
          (path / homographyName(layout, right)).string()};
}

const char* remedyOf(HomographyLayout layout) {
  switch (layout) {
    case HomographyLayout::kVgg:
      return "unpack the scene again (https://www.robots.ox.ac.uk/~vgg/research/affine/)";
    case HomographyLayout::kNumbered:
      return "a scene's folder has img1 to imgN and H1to2p to H1toNp in it";
    case HomographyLayout::kHpatches:
      return "a sequence's folder has images 1 to N and H_1_2 to H_1_N in it";
    case HomographyLayout::kSymbench:
      return "unpack the pair again: SymBench (Hauagge and Snavely, CVPR 2012) has 01.png, 02.png and H1to2 "
             "in it";
    case HomographyLayout::kPairs:
      break;
  }
  return "a pair's folder has left and right (.png, .jpg, ...) and H.txt in it";
}

}  // namespace

HomographyPairReader::HomographyPairReader(const std::string& name, const std::string& root,
                                           HomographyLayout layout)
    : name_(name), root_(root), layout_(layout) {
  const std::string remedy = "set the path to the folder that holds the folders of the " +
                             std::string(imagesPerScene(layout) == 2 ? "pairs" : "scenes");
  requireFolder(root, "dataset '" + name + "'", remedy);
  for (const std::string& sequence : subfolders(root)) {
    const int highest = highestNumber(layout, (fs::path(root) / sequence).string());
    if (highest == 0) {
      ignored_.push_back(sequence);
      continue;
    }
    const int images = imagesPerScene(layout) > 0 ? imagesPerScene(layout) : std::max(2, highest);
    for (int number = 2; number <= images; ++number) pairs_.push_back({sequence, number});
  }
  if (pairs_.empty()) {
    throw DatasetError("dataset '" + name + "': '" + root + "' has no folder with " + describe(layout) +
                       "; " + remedy);
  }
}

PairId HomographyPairReader::id(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  return {name_, pair.sequence, "1-" + std::to_string(pair.right)};
}

ImagePair HomographyPairReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const PairFiles files = pairFiles(layout_, folderOf(index), pairs_[index].right);
  const std::string remedy = remedyOf(layout_);
  pair.left = readImageFile(requireImage(files.left, remedy), remedy);
  pair.right = readImageFile(requireImage(files.right, remedy), remedy);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = readHomographyFile(files.homography, remedy);
  return pair;
}

void HomographyPairReader::check(std::size_t index) const {
  const PairFiles files = pairFiles(layout_, folderOf(index), pairs_[index].right);
  const std::string remedy = remedyOf(layout_);
  requireImage(files.left, remedy);
  requireImage(files.right, remedy);
  readHomographyFile(files.homography, remedy);
}

std::vector<std::string> HomographyPairReader::files() const {
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const PairFiles files = pairFiles(layout_, folderOf(i), pairs_[i].right);
    const bool first_of_sequence = i == 0 || pairs_[i].sequence != pairs_[i - 1].sequence;
    if (first_of_sequence) paths.push_back(findImage(files.left));
    paths.push_back(findImage(files.right));
    paths.push_back(files.homography);
  }
  return existingFiles(paths);
}

bool HomographyPairReader::recognises(const std::string& root, HomographyLayout layout) {
  for (const std::string& sequence : subfolders(root)) {
    const std::string folder = (fs::path(root) / sequence).string();
    const int highest = highestNumber(layout, folder);
    for (int number = 2; number <= highest; ++number) {
      const PairFiles files = pairFiles(layout, folder, number);
      if (!existingFiles({files.homography}).empty() && !findImage(files.left).empty() &&
          !findImage(files.right).empty()) {
        return true;
      }
    }
  }
  return false;
}

const char* HomographyPairReader::describe(HomographyLayout layout) {
  switch (layout) {
    case HomographyLayout::kVgg:
      return "img1..img6 and H1to2p..H1to6p";
    case HomographyLayout::kNumbered:
      return "img1..imgN and H1to2p..H1toNp";
    case HomographyLayout::kHpatches:
      return "1.ppm..N.ppm and H_1_2..H_1_N";
    case HomographyLayout::kSymbench:
      return "01.png, 02.png and H1to2";
    case HomographyLayout::kPairs:
      break;
  }
  return "left.png, right.png and H.txt";
}

std::string HomographyPairReader::folderOf(std::size_t index) const {
  return (fs::path(root_) / pairs_.at(index).sequence).string();
}

}  // namespace corrsel::core
