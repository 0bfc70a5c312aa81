#include <filesystem>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/adelaide_rmf.h"
#include "datasets/files.h"
#include "datasets/heinly_generated.h"
#include "datasets/homography_pairs.h"
#include "datasets/sample.h"
#include "datasets/unrelated.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using Reader = std::unique_ptr<DatasetReader>;
using Open = Reader (*)(const std::string& name, const std::string& path, int seed);

template <HomographyLayout layout>
Reader openHomographies(const std::string& name, const std::string& path, int) {
  return std::make_unique<HomographyPairReader>(name, path, layout);
}

Reader openAdelaideRmf(const std::string& name, const std::string& path, int) {
  return std::make_unique<AdelaideRmfReader>(name, path);
}

template <typename Generated>
Reader openGenerated(const std::string&, const std::string& path, int seed) {
  return std::make_unique<Generated>(path, seed);
}

struct Entry {
  const char* name;
  Open open;
};

constexpr Entry kDatasets[] = {
    {"adelaidermf", openAdelaideRmf},
    {"adelaidermf_reconstructed", openAdelaideRmf},
    {"heinly", openHomographies<HomographyLayout::kNumbered>},
    {"heinly_generated", openGenerated<HeinlyGeneratedReader>},
    {"hpatches", openHomographies<HomographyLayout::kHpatches>},
    {"pairs", openHomographies<HomographyLayout::kPairs>},
    {"sample", openGenerated<SampleReader>},
    {"symbench", openHomographies<HomographyLayout::kSymbench>},
    {"vgg", openHomographies<HomographyLayout::kVgg>},
};

struct Layout {
  std::string description;
  bool (*recognises)(const std::string& root);
  Open open;
};

template <HomographyLayout layout>
Layout homographyLayout() {
  return {std::string("folders with ") + HomographyPairReader::describe(layout),
          [](const std::string& root) { return HomographyPairReader::recognises(root, layout); },
          openHomographies<layout>};
}

bool hasMatFile(const std::string& root) {
  for (const std::string& name : fileNames(root)) {
    if (fs::path(name).extension() == ".mat") return true;
  }
  return false;
}

/// Layouts that a folder with an unknown name may have. The layout of VGG is a case of the numbered one.
std::vector<Layout> layouts() {
  return {homographyLayout<HomographyLayout::kNumbered>(),
          homographyLayout<HomographyLayout::kHpatches>(),
          homographyLayout<HomographyLayout::kSymbench>(),
          homographyLayout<HomographyLayout::kPairs>(),
          {"NAME.mat files with img1, img2, data and label", hasMatFile, openAdelaideRmf}};
}

Reader openUnknown(const std::string& name, const std::string& path, int seed) {
  std::vector<std::string> tried, recognised;
  Open open = nullptr;
  for (const Layout& layout : layouts()) {
    tried.push_back(layout.description);
    if (!layout.recognises(path)) continue;
    recognised.push_back(layout.description);
    open = layout.open;
  }
  if (recognised.size() > 1) {
    throw DatasetError("dataset '" + name + "': '" + path + "' holds several layouts (" +
                       joinList(recognised, "; ") + "); give each a folder of its own");
  }
  if (!open) {
    throw DatasetError("dataset '" + name + "': '" + path +
                       "' has no complete pair in a known layout; tried: " + joinList(tried, "; ") +
                       " (docs/datasets.md)");
  }
  return open(name, path, seed);
}

void requirePlainName(const std::string& name) {
  if (name.empty() || name == "." || name == ".." || name.find_first_of("/\\") != std::string::npos) {
    throw std::invalid_argument("dataset name '" + name +
                                "' must be the plain name of a folder, without path separators; the folder "
                                "that holds it is given separately");
  }
}

}  // namespace

std::unique_ptr<DatasetReader> openDataset(const std::string& name, const std::string& path, int seed) {
  requirePlainName(name);
  if (isUnrelated(name)) {
    return std::make_unique<UnrelatedReader>(openDataset(imageDataset(name), path, seed), seed);
  }
  for (const Entry& entry : kDatasets) {
    if (name == entry.name) return entry.open(name, path, seed);
  }
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    throw std::invalid_argument("unknown dataset '" + name + "', and '" + path +
                                "' is not a folder; known: " + joinList(datasetNames()) +
                                "; any other folder must exist and have one of the layouts that "
                                "docs/datasets.md describes");
  }
  return openUnknown(name, path, seed);
}

std::vector<std::string> datasetNames() {
  std::vector<std::string> names;
  for (const Entry& entry : kDatasets) names.push_back(entry.name);
  return names;
}

bool isUnrelated(const std::string& name) { return name.rfind(kUnrelatedPrefix, 0) == 0; }

std::string imageDataset(const std::string& name) {
  return isUnrelated(name) ? name.substr(std::char_traits<char>::length(kUnrelatedPrefix)) : name;
}

bool needsSamplePhotographs(const std::string& name) {
  const std::string images = imageDataset(name);
  return images == "sample" || images == "heinly_generated";
}

}  // namespace corrsel::core
