#include "datasets/homography_pairs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>

#include "datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDigits = 3;  // of an image's number; a longer one is a date or the like

using Name = std::string (*)(int number);

/// What a layout consists of. Images of a scene are numbered from 1.
struct Layout {
  HomographyLayout id;
  int images;       ///< of a scene; 0 = the highest number that one of its files has
  Name image;       ///< name of an image, without extension
  Name homography;  ///< name of the file that maps image 1 to the image of this number (from 2)
  const char* description;
  const char* remedy;
};

constexpr Layout kLayouts[] = {
    {HomographyLayout::kVgg, 6, [](int number) { return "img" + std::to_string(number); },
     [](int number) { return "H1to" + std::to_string(number) + "p"; }, "img1..img6 and H1to2p..H1to6p",
     "unpack the scene again (https://www.robots.ox.ac.uk/~vgg/research/affine/)"},
    {HomographyLayout::kNumbered, 0, [](int number) { return "img" + std::to_string(number); },
     [](int number) { return "H1to" + std::to_string(number) + "p"; }, "img1..imgN and H1to2p..H1toNp",
     "a scene's folder holds img1 to imgN and H1to2p to H1toNp"},
    {HomographyLayout::kHpatches, 0, [](int number) { return std::to_string(number); },
     [](int number) { return "H_1_" + std::to_string(number); }, "1.ppm..N.ppm and H_1_2..H_1_N",
     "a sequence's folder holds the images 1 to N and H_1_2 to H_1_N"},
    {HomographyLayout::kSymbench, 2, [](int number) { return "0" + std::to_string(number); },
     [](int number) { return "H1to" + std::to_string(number); }, "01.png, 02.png and H1to2",
     "unpack the pair again: a folder of SymBench (Hauagge and Snavely, CVPR 2012) holds 01.png, 02.png and "
     "H1to2"},
};

const Layout& layoutOf(HomographyLayout id) {
  return *std::find_if(std::begin(kLayouts), std::end(kLayouts),
                       [id](const Layout& layout) { return layout.id == id; });
}

/// Whether the file is the layout's image or homography of that number.
bool isFileOf(const Layout& layout, const std::string& name, int number) {
  return isImageOf(name, layout.image(number)) || (number > 1 && name == layout.homography(number));
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

/// Number of the image or homography that a file is in the layout; 0 where it is neither.
int numberOf(const Layout& layout, const std::string& name) {
  const int images = layout.images;
  const int found = lastNumber(fs::path(name).stem().string());
  const int first = images > 0 ? 1 : std::max(1, found), last = images > 0 ? images : found;
  for (int number = last; number >= first; --number) {
    if (isFileOf(layout, name, number)) return number;
  }
  return 0;
}

/// Highest number of the layout's files in a folder; 0 where it has none of them.
int highestNumber(const Layout& layout, const std::vector<std::string>& names) {
  int highest = 0;
  for (const std::string& name : names) highest = std::max(highest, numberOf(layout, name));
  return highest;
}

/// The files of a pair; the images without their extensions.
struct PairFiles {
  std::string left, right, homography;
};

PairFiles pairFiles(const Layout& layout, const std::string& folder, int right) {
  const fs::path path(folder);
  return {(path / layout.image(1)).string(), (path / layout.image(right)).string(),
          (path / layout.homography(right)).string()};
}

}  // namespace

HomographyPairReader::HomographyPairReader(const std::string& name, const std::string& root,
                                           HomographyLayout layout_id)
    : name_(name), root_(root), layout_(layout_id) {
  const Layout& layout = layoutOf(layout_id);
  const std::string remedy = "set the path to the folder that holds the folders of the " +
                             std::string(layout.images == 2 ? "pairs" : "scenes");
  requireFolder(root, "dataset '" + name + "'", remedy);
  for (const std::string& sequence : subfolders(root)) {
    const int highest = highestNumber(layout, fileNames((fs::path(root) / sequence).string()));
    if (highest == 0) {
      ignored_.push_back(sequence);
      continue;
    }
    const int images = layout.images > 0 ? layout.images : std::max(2, highest);
    for (int number = 2; number <= images; ++number) pairs_.push_back({sequence, number});
  }
}

PairId HomographyPairReader::id(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  return {name_, pair.sequence, "1-" + std::to_string(pair.right)};
}

ImagePair HomographyPairReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const PairFiles files = pairFiles(layoutOf(layout_), folderOf(index), pairs_[index].right);
  const std::string remedy = layoutOf(layout_).remedy;
  readImages(root_, requireImage(files.left, remedy), requireImage(files.right, remedy), remedy, pair);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = readHomographyFile(files.homography, remedy);
  return pair;
}

void HomographyPairReader::check(std::size_t index) const {
  const PairFiles files = pairFiles(layoutOf(layout_), folderOf(index), pairs_[index].right);
  const std::string remedy = layoutOf(layout_).remedy;
  requireImage(files.left, remedy);
  requireImage(files.right, remedy);
  readHomographyFile(files.homography, remedy);
}

std::vector<std::string> HomographyPairReader::files() const {
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const PairFiles files = pairFiles(layoutOf(layout_), folderOf(i), pairs_[i].right);
    const bool first_of_sequence = i == 0 || pairs_[i].sequence != pairs_[i - 1].sequence;
    const auto add = [&paths](const std::vector<std::string>& more) {
      paths.insert(paths.end(), more.begin(), more.end());
    };
    if (first_of_sequence) add(imagesOf(files.left));
    add(imagesOf(files.right));
    add(existingFiles({files.homography}));
  }
  return paths;
}

FolderFit HomographyPairReader::fit(HomographyLayout layout_id, const std::vector<std::string>& names) {
  const Layout& layout = layoutOf(layout_id);
  const auto lackingFor = [&](int number) {
    std::vector<std::string> lacking;
    for (const std::string& image : {layout.image(1), layout.image(number)}) {
      const auto isImage = [&image](const std::string& name) { return isImageOf(name, image); };
      if (std::none_of(names.begin(), names.end(), isImage)) lacking.push_back(image);
    }
    const std::string homography = layout.homography(number);
    if (std::find(names.begin(), names.end(), homography) == names.end()) lacking.push_back(homography);
    return lacking;
  };
  FolderFit result;
  for (const std::string& name : names) result.present += numberOf(layout, name) > 0 ? 1 : 0;
  result.lacking = lackingFor(2);
  const int highest = highestNumber(layout, names);
  for (int number = 3; number <= highest && !result.lacking.empty(); ++number) {
    std::vector<std::string> lacking = lackingFor(number);
    if (lacking.size() < result.lacking.size()) result.lacking = std::move(lacking);
  }
  return result;
}

const char* HomographyPairReader::describe(HomographyLayout layout) { return layoutOf(layout).description; }

std::string HomographyPairReader::folderOf(std::size_t index) const {
  return (fs::path(root_) / pairs_.at(index).sequence).string();
}

}  // namespace corrsel::core
