#include <algorithm>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/adelaide_rmf.h"
#include "datasets/calibrated_generated.h"
#include "datasets/colmap.h"
#include "datasets/euroc.h"
#include "datasets/evd.h"
#include "datasets/files.h"
#include "datasets/heinly_generated.h"
#include "datasets/homography_pairs.h"
#include "datasets/pair_folders.h"
#include "datasets/pair_list.h"
#include "datasets/posed_pairs.h"
#include "datasets/sample.h"
#include "datasets/tum_rgbd.h"
#include "datasets/unreadable.h"
#include "datasets/unrelated.h"
#include "datasets/wxbs.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using Reader = std::unique_ptr<DatasetReader>;
using Open = Reader (*)(const std::string& name, const std::string& path, int seed);

template <HomographyLayout layout>
Reader openHomographies(const std::string& name, const std::string& path, int) {
  return std::make_unique<HomographyPairReader>(name, path, layout);
}

template <typename NamedReader>
Reader openNamed(const std::string& name, const std::string& path, int) {
  return std::make_unique<NamedReader>(name, path);
}

template <PosedDataset (*find)(const std::string& name, const std::string& root)>
Reader openPosed(const std::string& name, const std::string& path, int) {
  return std::make_unique<PosedPairReader>(find(name, path), path);
}

template <typename Generated>
Reader openGenerated(const std::string&, const std::string& path, int seed) {
  return std::make_unique<Generated>(path, seed);
}

Reader openCalibrated(const std::string& name, const std::string&, int seed) {
  return std::make_unique<CalibratedGeneratedReader>(name, seed);
}

struct Entry {
  const char* name;
  Open open;
};

constexpr Entry kDatasets[] = {
    {"adelaidermf", openNamed<AdelaideRmfReader>},
    {"adelaidermf_reconstructed", openNamed<AdelaideRmfReader>},
    {"calibrated30_generated", openCalibrated},
    {"calibrated70_generated", openCalibrated},
    {"calibrated95_generated", openCalibrated},
    {"colmap", openPosed<readColmap>},
    {"euroc", openPosed<readEuroc>},
    {"evd", openNamed<EvdReader>},
    {"heinly", openHomographies<HomographyLayout::kNumbered>},
    {"heinly_generated", openGenerated<HeinlyGeneratedReader>},
    {"hpatches", openHomographies<HomographyLayout::kHpatches>},
    {"pair_list", openPosed<readPairList>},
    {"pairs", openNamed<PairFolderReader>},
    {"sample", openGenerated<SampleReader>},
    {"symbench", openHomographies<HomographyLayout::kSymbench>},
    {"tum_rgbd", openPosed<readTumRgbd>},
    {"vgg", openHomographies<HomographyLayout::kVgg>},
    {"wxbs", openNamed<WxbsReader>},
};

struct Layout {
  FolderLayout folders;
  Open open;
};

template <HomographyLayout layout>
Layout homographyLayout(const char* dataset) {
  return {{dataset, HomographyPairReader::describe(layout),
           [](const std::vector<std::string>& names) { return HomographyPairReader::fit(layout, names); }},
          openHomographies<layout>};
}

/// Layouts with a folder for each pair or scene that a dataset with an unknown name may have. That of VGG is
/// a case of the numbered one.
std::vector<Layout> layouts() {
  return {homographyLayout<HomographyLayout::kNumbered>("heinly"),
          homographyLayout<HomographyLayout::kHpatches>("hpatches"),
          homographyLayout<HomographyLayout::kSymbench>("symbench"),
          {{"pairs", PairFolderReader::describe(), PairFolderReader::fit}, openNamed<PairFolderReader>}};
}

/// Layouts that are recognised from the folder as a whole, by the names that mean them.
std::vector<RootLayout> rootLayouts() {
  return {
      {"adelaidermf", "NAME.mat", hasMatFile},
      {"evd", "1/NAME.png, 2/NAME.png and h/NAME.txt", EvdReader::fits},
      {"wxbs", "KIND/SCENE/ with 01.png, 02.png and corrs.txt", WxbsReader::fits},
      {"pair_list", "pairs.txt with lines image_a image_b turns_a turns_b K_a K_b T_ab", hasPairList},
      {"colmap", "NAME/sparse/0 (or NAME/sparse) with cameras and images (.bin or .txt)", hasColmap, true},
      {"tum_rgbd", "NAME/ with rgb.txt and groundtruth.txt", hasTumRgbd, true},
      {"euroc", "NAME/mav0/ with cam0/data.csv and cam0/sensor.yaml", hasEuroc, true}};
}

SearchedLayouts allLayouts() {
  SearchedLayouts result{{}, rootLayouts()};
  for (const Layout& layout : layouts()) result.folders.push_back(layout.folders);
  return result;
}

/// Null where the name is not known.
const Entry* findEntry(const std::string& name) {
  const auto* const found = std::find_if(std::begin(kDatasets), std::end(kDatasets),
                                         [&name](const Entry& known) { return name == known.name; });
  return found == std::end(kDatasets) ? nullptr : found;
}

[[noreturn]] void failUnreadable(const std::string& name, const std::string& path,
                                 const SearchedLayouts& searched) {
  throw DatasetError("dataset '" + name + "': " + explainUnreadable(path, searched, allLayouts()));
}

/// Opens a dataset of datasetNames().
Reader openKnown(const Entry& entry, const std::string& path, int seed) {
  std::error_code ignored;
  for (const RootLayout& layout : rootLayouts()) {
    const bool expected = entry.open == findEntry(layout.dataset)->open;
    if (expected && fs::is_directory(path, ignored) && !layout.has(path)) {
      failUnreadable(entry.name, path, {{}, {layout}});
    }
  }
  Reader reader = entry.open(entry.name, path, seed);
  if (reader->size() > 0) return reader;
  std::vector<Layout> expected = layouts();
  expected.push_back(homographyLayout<HomographyLayout::kVgg>("vgg"));
  for (const Layout& layout : expected) {
    if (layout.folders.dataset == entry.name) failUnreadable(entry.name, path, {{layout.folders}, {}});
  }
  return reader;
}

/// Throws where `path` is missing because the folder of all datasets is given wrongly.
void requireNotMisplaced(const std::string& name, const std::string& path) {
  const std::string fault = explainMissing(path, allLayouts());
  if (!fault.empty()) throw DatasetError("dataset '" + name + "': '" + path + "' is not a folder. " + fault);
}

Reader openUnknown(const std::string& name, const std::string& path, int seed) {
  std::vector<std::string> recognised;
  Open open = nullptr;
  for (const Layout& layout : layouts()) {
    if (!hasPairOf(layout.folders, path)) continue;
    recognised.push_back("folders with " + layout.folders.files);
    open = layout.open;
  }
  for (const RootLayout& layout : rootLayouts()) {
    if (!layout.has(path)) continue;
    recognised.push_back(layout.files);
    open = findEntry(layout.dataset)->open;
  }
  if (recognised.size() > 1) {
    throw DatasetError("dataset '" + name + "': '" + path + "' holds several layouts (" +
                       joinList(recognised, "; ") + "); give each a folder of its own");
  }
  if (!open) failUnreadable(name, path, allLayouts());
  return open(name, path, seed);
}

/// Why there is no dataset in `path`, and which one is probably meant.
std::string whatIsThere(const std::string& name, const std::string& path) {
  const fs::path folder = (fs::absolute(path) / "").lexically_normal().parent_path();
  const fs::path root = folder.parent_path();
  const std::string missing = "'" + path + "' is not a folder; ";
  std::error_code ignored;
  if (fs::is_directory(root, ignored) && root.filename() == name) {
    return missing + "'" + root.string() +
           "' seems to be a dataset itself: give the folder that holds it, '" + root.parent_path().string() +
           "'";
  }
  const std::string contents = describeDataRoot(root.string());
  if (!fs::is_directory(root, ignored)) {
    return missing + contents + ": give the folder that holds one folder per dataset";
  }
  std::vector<std::string> names = subfolders(root.string());
  const std::vector<std::string> known = datasetNames();
  const bool is_known = std::find(known.begin(), known.end(), name) != known.end();
  if (!is_known) names.insert(names.end(), known.begin(), known.end());
  const std::string near = nearestName(name, names);
  return missing + (near.empty() ? "" : "did you mean '" + near + "'? ") + contents +
         (is_known ? ""
                   : "; known datasets: " + joinList(known) +
                         "; any other folder must have one of the layouts that docs/datasets.md describes");
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
  const Entry* const entry = findEntry(name);
  if (!needsFolder(name)) return entry->open(name, path, seed);
  requireNotMisplaced(name, path);
  const bool is_known = entry != nullptr;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored) && !needsSamplePhotographs(name)) {
    if (is_known) throw DatasetError("dataset '" + name + "': " + whatIsThere(name, path));
    throw std::invalid_argument("unknown dataset '" + name + "': " + whatIsThere(name, path));
  }
  if (is_known) return openKnown(*entry, path, seed);
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

bool needsFolder(const std::string& name) { return !CalibratedGeneratedReader::isName(imageDataset(name)); }

bool needsSamplePhotographs(const std::string& name) {
  const std::string images = imageDataset(name);
  return images == "sample" || images == "heinly_generated";
}

}  // namespace corrsel::core
