#include "datasets/pair_folders.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "base/size_text.h"
#include "base/text.h"
#include "datasets/match_list.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kHomography[] = "H.txt", kFundamental[] = "F.txt", kMatches[] = "matches.csv",
               kSizes[] = "size.txt";
constexpr char kRemedy[] =
    "a pair's folder holds left and right (.png, .jpg, ...) and H.txt or F.txt, or matches.csv";
constexpr float kBeyondBorder = 1;  // px that a match may lie outside its image

bool has(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool hasImage(const std::vector<std::string>& names, const char* stem) {
  return std::any_of(names.begin(), names.end(),
                     [stem](const std::string& name) { return isImageOf(name, stem); });
}

/// One pair's folder and the names of its files.
class PairFolder {
 public:
  PairFolder(const std::string& root, const std::string& path)
      : root_(root), path_(path), names_(fileNames(path)) {}

  /// @param decode  whether to decode the images
  ImagePair read(bool decode) const {
    ImagePair pair;
    const bool listed = has(names_, kMatches);
    const MatchList list = listed ? readMatchList(file(kMatches)) : MatchList();
    pair.truth = truth(listed, list);
    const bool images = !listed || hasImage(names_, "left") || hasImage(names_, "right");
    if (images) {
      requireNames();
      const std::string left = requireImage(file("left"), kRemedy),
                        right = requireImage(file("right"), kRemedy);
      if (decode) readImages(root_, left, right, kRemedy, pair);
    }
    if (!listed) return pair;
    Correspondences matches = list.matches;
    if (has(names_, kSizes)) {
      if (images) fail(kSizes, "the images state their sizes themselves; remove this file or the images");
      readSizes(matches);
    } else {
      matches.left_size = pair.left.size();
      matches.right_size = pair.right.size();
    }
    requireInside("left", matches.left_x, matches.left_y, matches.left_size);
    requireInside("right", matches.right_x, matches.right_y, matches.right_size);
    pair.given = std::move(matches);
    return pair;
  }

 private:
  std::string file(const char* name) const { return (fs::path(path_) / name).string(); }

  [[noreturn]] void fail(const char* name, const std::string& fault) const {
    throw DatasetError(file(name) + ": " + fault);
  }

  /// Throws where the folder has images, but under other names.
  void requireNames() const {
    std::vector<std::string> images;
    for (const std::string& name : names_) {
      if (isImageExtension(fs::path(name).extension().string())) images.push_back(name);
    }
    if (images.empty() || hasImage(names_, "left") || hasImage(names_, "right")) return;
    throw DatasetError(path_ + ": the images " + joinList(images) +
                       " are neither called left nor right; rename them");
  }

  GroundTruth truth(bool listed, const MatchList& list) const {
    std::vector<std::string> truths;
    for (const char* name : {kHomography, kFundamental}) {
      if (has(names_, name)) truths.push_back(name);
    }
    if (list.labelled) truths.push_back("the column 'label' of matches.csv");
    if (truths.size() > 1) {
      throw DatasetError(path_ + ": " + joinList(truths, " and ") +
                         " are several ground truths for one pair; keep one of them");
    }
    if (truths.empty() && listed) {
      throw DatasetError(path_ +
                         ": there is no ground truth; add H.txt, F.txt or the column 'label' (1 = inlier, "
                         "0 = outlier) to matches.csv");
    }
    if (truths.empty()) throw DatasetError(path_ + ": H.txt or F.txt is missing; " + kRemedy);
    GroundTruth result;
    if (list.labelled) {
      result.kind = TruthKind::kLabels;
      result.labels = list.labels;
    } else if (truths.front() == kHomography) {
      result.kind = TruthKind::kHomography;
      result.matrix = readHomographyFile(file(kHomography), kRemedy);
    } else {
      result.kind = TruthKind::kFundamental;
      result.matrix = readFundamentalFile(file(kFundamental), kRemedy);
    }
    return result;
  }

  void readSizes(Correspondences& matches) const {
    const std::string remedy =
        "; write width and height of the left image, then of the right one, e.g. 640 480 640 480";
    constexpr int kMaxSide = 1 << 20;  // px; OpenCV reads images up to this
    std::vector<int> sides;
    std::ifstream stream(file(kSizes));
    for (std::string word; stream >> word;) {
      double side = 0;
      try {
        side = parseNumber(word, "entry " + std::to_string(sides.size() + 1));
      } catch (const std::invalid_argument& error) {
        fail(kSizes, error.what() + remedy);
      }
      if (!(side >= 1 && side <= kMaxSide && side == static_cast<int>(side))) {
        fail(kSizes,
             "'" + word + "' is not a number of pixels from 1 to " + std::to_string(kMaxSide) + remedy);
      }
      sides.push_back(static_cast<int>(side));
    }
    if (sides.size() != 4) fail(kSizes, "holds " + std::to_string(sides.size()) + " numbers, not 4" + remedy);
    matches.left_size = {sides[0], sides[1]};
    matches.right_size = {sides[2], sides[3]};
  }

  void requireInside(const std::string& side, const std::vector<float>& x, const std::vector<float>& y,
                     const cv::Size& size) const {
    if (size.empty()) return;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto outside = [](float coordinate, int length) {
        return coordinate < -kBeyondBorder || coordinate > static_cast<float>(length - 1) + kBeyondBorder;
      };
      if (!outside(x[i], size.width) && !outside(y[i], size.height)) continue;
      fail(kMatches, "match " + std::to_string(i + 1) + " lies at (" + formatNumber(x[i]) + ", " +
                         formatNumber(y[i]) + "), outside the " + side + " image of " + sizeText(size) +
                         " px; give the matches in px of the images as they are stored");
    }
  }

  std::string root_, path_;
  std::vector<std::string> names_;
};

}  // namespace

PairFolderReader::PairFolderReader(const std::string& name, const std::string& root)
    : name_(name), root_(root) {
  requireFolder(root, "dataset '" + name + "'",
                "set the path to the folder that holds the folders of the pairs");
  for (const std::string& folder : subfolders(root)) {
    const bool fits = fit(fileNames((fs::path(root) / folder).string())).present > 0;
    (fits ? sequences_ : ignored_).push_back(folder);
  }
}

PairId PairFolderReader::id(std::size_t index) const { return {name_, sequences_.at(index), "1-2"}; }

ImagePair PairFolderReader::read(std::size_t index) const {
  ImagePair pair = PairFolder(root_, folderOf(index)).read(true);
  pair.id = id(index);
  return pair;
}

void PairFolderReader::check(std::size_t index) const { PairFolder(root_, folderOf(index)).read(false); }

std::vector<std::string> PairFolderReader::files() const {
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < sequences_.size(); ++i) {
    const fs::path folder = folderOf(i);
    for (const std::string& name : fileNames(folder.string())) {
      const bool used = name == kSizes || fit({name}).present > 0;
      if (used) paths.push_back((folder / name).string());
    }
  }
  return paths;
}

FolderFit PairFolderReader::fit(const std::vector<std::string>& names) {
  FolderFit result;
  const bool listed = has(names, kMatches), truth = has(names, kHomography) || has(names, kFundamental);
  const bool left = hasImage(names, "left"), right = hasImage(names, "right");
  result.present = static_cast<std::size_t>(listed) + static_cast<std::size_t>(truth) +
                   static_cast<std::size_t>(left) + static_cast<std::size_t>(right);
  if (listed) return result;
  if (!left) result.lacking.emplace_back("left");
  if (!right) result.lacking.emplace_back("right");
  if (!truth) result.lacking.emplace_back("H.txt or F.txt");
  return result;
}

std::string PairFolderReader::folderOf(std::size_t index) const {
  return (fs::path(root_) / sequences_.at(index)).string();
}

}  // namespace corrsel::core
