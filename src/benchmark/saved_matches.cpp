#include "benchmark/saved_matches.h"

#include <filesystem>
#include <set>

#include "base/text.h"
#include "benchmark/feature_cache.h"
#include "benchmark/files.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/results.h"
#include "matching/match_table.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

fs::path matchesFolder(const std::string& run) {
  return (fs::path(run) / savedMatchesTable().file()).parent_path();
}

void createFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw RunFolderError("cannot create the folder " + folder.string() + ": " + error.message());
}

std::string nameOf(const std::string& name, const cv::Mat& image) {
  if (!name.empty() || image.empty()) return name;
  return "#" + checksumOf(image).text();
}

std::string modelText(const Selection& selection) {
  if (selection.model_kind == ModelKind::kNone) return "";
  std::vector<std::string> numbers;
  for (const double number : selection.model.val) numbers.push_back(formatNumber(number));
  return joinList(numbers, " ");
}

}  // namespace

SavedMatches::SavedMatches(const std::string& folder, const ImagePair& pair, bool seeds)
    : root_(matchesFolder(folder).string()), seeds_(seeds) {
  common_.id = pair.id;
  common_.left_image = nameOf(pair.left_name, pair.left);
  common_.right_image = nameOf(pair.right_name, pair.right);
}

void SavedMatches::writePutative(const Cell& cell, const Correspondences& putative) {
  fs::path folder = "csv";
  for (const std::string& part :
       {common_.id.dataset, common_.id.sequence, common_.id.pair, cell.features, cell.preselection}) {
    folder /= uniqueFileName(part);
  }
  createFolder(fs::path(root_) / folder);
  cell_folder_ = folder.string();
  common_.putative = (folder / "putative.csv").string();
  common_.features = cell.features;
  common_.preselection = cell.preselection;
  common_.n_putative = putative.size();
  common_.left_width = static_cast<std::size_t>(putative.left_size.width);
  common_.left_height = static_cast<std::size_t>(putative.left_size.height);
  common_.right_width = static_cast<std::size_t>(putative.right_size.width);
  common_.right_height = static_cast<std::size_t>(putative.right_size.height);
  writeFile((fs::path(root_) / common_.putative).string(), putativeTable(putative));
}

void SavedMatches::write(const Correspondences& putative, const std::string& selector, int seed,
                         const Selection& selection) {
  SavedSelection saved = common_;
  const std::string name = uniqueFileName(selector) + (seeds_ ? "@" + std::to_string(seed) : "") + ".csv";
  saved.file = (fs::path(cell_folder_) / name).string();
  saved.selector = selector;
  saved.seed = seed;
  saved.status = selection.status;
  saved.n_selected = selection.n_selected;
  saved.model_kind = toString(selection.model_kind);
  saved.model = modelText(selection);
  writeFile((fs::path(root_) / saved.file).string(), selectedTable(putative, selection));
  selections_.push_back(saved);
}

void copySavedMatches(const std::string& from, const std::string& to,
                      const std::vector<SavedSelection>& selections) {
  const fs::path source = matchesFolder(from), target = matchesFolder(to);
  std::set<std::string> copied;  // the selections of a cell share one file of putative matches
  for (const SavedSelection& selection : selections) {
    createFolder((target / selection.file).parent_path());
    for (const std::string& file : {selection.putative, selection.file}) {
      if (!copied.insert(file).second) continue;
      std::error_code error;
      fs::copy_file(source / file, target / file, fs::copy_options::overwrite_existing, error);
      if (error) {
        throw RunFolderError("cannot copy " + (source / file).string() + " to " + (target / file).string() +
                             ": " + error.message());
      }
    }
  }
}

}  // namespace corrsel::core
