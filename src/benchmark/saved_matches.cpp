#include "benchmark/saved_matches.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numeric>
#include <set>
#include <utility>

#include "base/text.h"
#include "benchmark/feature_cache.h"
#include "benchmark/files.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/results.h"

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

/// Shortest text that reads back as the same float. Undefined numbers are "nan", as in a match list.
std::string floatText(float value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[32];
  for (int digits = 6; digits <= 9; ++digits) {
    std::snprintf(buffer, sizeof(buffer), "%.*g", digits, static_cast<double>(value));
    if (std::strtof(buffer, nullptr) == value) break;
  }
  return buffer;
}

/// A column of a file of matches: its name and the text of a row.
struct MatchColumn {
  std::string name;
  std::function<std::string(std::size_t row)> text;
};

void addFloats(std::vector<MatchColumn>& columns, const std::string& name, const std::vector<float>& values) {
  if (!values.empty())
    columns.push_back({name, [&values](std::size_t row) { return floatText(values[row]); }});
}

template <class Number>
void addNumbers(std::vector<MatchColumn>& columns, const std::string& name,
                const std::vector<Number>& values) {
  if (!values.empty())
    columns.push_back({name, [&values](std::size_t row) { return std::to_string(values[row]); }});
}

void addFrames(std::vector<MatchColumn>& columns, const std::string& side,
               const std::vector<AffineFrame>& frames) {
  if (frames.empty()) return;
  const std::pair<const char*, std::size_t> entries[] = {{"a11_", 0}, {"a12_", 1}, {"a21_", 3}, {"a22_", 4}};
  for (const auto& [name, entry] : entries) {
    columns.push_back(
        {name + side, [&frames, entry = entry](std::size_t row) { return floatText(frames[row][entry]); }});
  }
}

/// The columns that the matches have. They refer to the matches. Coordinates are there without matches, too.
std::vector<MatchColumn> columnsOf(const Correspondences& matches) {
  std::vector<MatchColumn> columns;
  const std::pair<const char*, const std::vector<float>*> coordinates[] = {{"x_left", &matches.left_x},
                                                                           {"y_left", &matches.left_y},
                                                                           {"x_right", &matches.right_x},
                                                                           {"y_right", &matches.right_y}};
  for (const auto& [name, values] : coordinates) {
    columns.push_back({name, [values = values](std::size_t row) { return floatText((*values)[row]); }});
  }
  addFloats(columns, "distance", matches.distance);
  addFloats(columns, "second_distance", matches.second_distance);
  addFloats(columns, "match_probability", matches.probability);
  addNumbers(columns, "index_left", matches.left_index);
  addNumbers(columns, "index_right", matches.right_index);
  addFrames(columns, "left", matches.left_frame);
  addFrames(columns, "right", matches.right_frame);
  return columns;
}

std::string tableOf(const std::vector<MatchColumn>& columns, const std::vector<std::uint32_t>& rows) {
  std::string text;
  for (const MatchColumn& column : columns) text += (text.empty() ? "" : ",") + column.name;
  text += '\n';
  for (const std::uint32_t row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += ',';
      text += columns[i].text(row);
    }
    text += '\n';
  }
  return text;
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
  std::vector<std::uint32_t> rows(putative.size());
  std::iota(rows.begin(), rows.end(), 0U);
  writeFile((fs::path(root_) / common_.putative).string(), tableOf(columnsOf(putative), rows));
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
  std::vector<MatchColumn> columns = columnsOf(putative);
  columns.insert(columns.begin(), {"row", [](std::size_t row) { return std::to_string(row); }});
  addFloats(columns, "score", selection.score);
  addNumbers(columns, "group", selection.group);
  addFloats(columns, "probability", selection.probability);
  writeFile((fs::path(root_) / saved.file).string(), tableOf(columns, selectedRows(selection.mask)));
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
