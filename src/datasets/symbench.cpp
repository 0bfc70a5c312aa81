#include "corrsel/datasets/symbench.h"

#include <algorithm>
#include <filesystem>

#include "corrsel/datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLeft = "/01.png";
constexpr const char* kRight = "/02.png";
constexpr const char* kHomography = "/H1to2";
constexpr const char* kRemedy =
    "unpack the pair again: SymBench (Hauagge and Snavely, CVPR 2012) has 01.png, 02.png and H1to2 in it";

std::vector<std::string> pairFiles(const std::string& folder) {
  return existingFiles({folder + kLeft, folder + kRight, folder + kHomography});
}

}  // namespace

SymbenchReader::SymbenchReader(const std::string& root) {
  requireFolder(root, "SymBench dataset", "set the path to the folder that holds the pairs' folders");
  for (const fs::directory_entry& entry : fs::directory_iterator(root)) {
    if (entry.is_directory() && !pairFiles(entry.path().string()).empty()) {
      folders_.push_back(entry.path().string());
    }
  }
  if (folders_.empty()) {
    throw DatasetError("SymBench dataset: '" + root +
                       "' has no subfolder with 01.png, 02.png or H1to2; set the path to the folder that "
                       "holds the pairs' folders");
  }
  std::sort(folders_.begin(), folders_.end());
}

PairId SymbenchReader::id(std::size_t index) const {
  return {"symbench", fs::path(folders_.at(index)).filename().string(), "1-2"};
}

ImagePair SymbenchReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  const std::string& folder = folders_.at(index);
  pair.left = readImageFile(folder + kLeft, kRemedy);
  pair.right = readImageFile(folder + kRight, kRemedy);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = readHomographyFile(folder + kHomography, kRemedy);
  return pair;
}

std::vector<std::string> SymbenchReader::files() const {
  std::vector<std::string> paths;
  for (const std::string& folder : folders_) {
    const std::vector<std::string> of_pair = pairFiles(folder);
    paths.insert(paths.end(), of_pair.begin(), of_pair.end());
  }
  return paths;
}

}  // namespace corrsel::core
