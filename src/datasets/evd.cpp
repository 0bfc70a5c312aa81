#include "datasets/evd.h"

#include <filesystem>
#include <set>

#include "datasets/files.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kLeft[] = "1", kRight[] = "2", kTruth[] = "h";
constexpr char kRemedy[] = "a pair of EVD is 1/NAME.png, 2/NAME.png and h/NAME.txt; unpack the dataset again";

/// Whether a file of a folder belongs to a pair.
bool belongs(const char* folder, const fs::path& file) {
  const std::string extension = file.extension().string();
  return folder == kTruth ? extension == ".txt" : isImageExtension(extension);
}

std::set<std::string> namesIn(const std::string& root, const char* folder) {
  std::set<std::string> names;
  for (const std::string& file : fileNames((fs::path(root) / folder).string())) {
    if (belongs(folder, file)) names.insert(fs::path(file).stem().string());
  }
  return names;
}

}  // namespace

EvdReader::EvdReader(const std::string& name, const std::string& root) : name_(name), root_(root) {
  requireFolder(root, "dataset '" + name + "'",
                "set the path to the folder that holds the folders 1, 2 and h");
  std::set<std::string> names;
  for (const char* const folder : {kLeft, kRight, kTruth}) names.merge(namesIn(root, folder));
  names_.assign(names.begin(), names.end());
}

std::string EvdReader::stemOf(const char* folder, std::size_t index) const {
  return (fs::path(root_) / folder / names_.at(index)).string();
}

ImagePair EvdReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  readImages(root_, requireImage(stemOf(kLeft, index), kRemedy), requireImage(stemOf(kRight, index), kRemedy),
             kRemedy, pair);
  pair.truth.kind = TruthKind::kHomography;
  pair.truth.matrix = readHomographyFile(stemOf(kTruth, index) + ".txt", kRemedy);
  return pair;
}

void EvdReader::check(std::size_t index) const {
  for (const char* const folder : {kLeft, kRight}) requireImage(stemOf(folder, index), kRemedy);
  readHomographyFile(stemOf(kTruth, index) + ".txt", kRemedy);
}

std::vector<std::string> EvdReader::files() const {
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    for (const char* const folder : {kLeft, kRight}) {
      for (const std::string& image : imagesOf(stemOf(folder, i))) paths.push_back(image);
    }
    paths.push_back(stemOf(kTruth, i) + ".txt");
  }
  return existingFiles(paths);
}

bool EvdReader::fits(const std::string& root) {
  for (const char* const folder : {kLeft, kRight, kTruth}) {
    if (namesIn(root, folder).empty()) return false;
  }
  return true;
}

}  // namespace corrsel::core
