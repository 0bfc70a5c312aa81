#include "datasets/match_list.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <opencv2/core/types.hpp>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "features/parts/feature_list.h"

namespace corrsel::core {
namespace {

constexpr double kAny = std::numeric_limits<float>::max();
constexpr double kMaxCount = std::numeric_limits<std::uint32_t>::max();

struct Column {
  const char* name;
  double min, max;
  bool whole = false;
  bool optional = true;
  bool may_be_nan = false;  ///< nan = there is none
};

constexpr Column kColumns[] = {
    {"x_left", -1e9, 1e9, false, false},
    {"y_left", -1e9, 1e9, false, false},
    {"x_right", -1e9, 1e9, false, false},
    {"y_right", -1e9, 1e9, false, false},
    {"distance", 0, kAny},
    {"second_distance", 0, kAny, false, true, true},
    {"ratio", 0, kAny},
    {"match_probability", 0, 1, false, true, true},
    {"size_left", 0, 1e9},
    {"angle_left", -1e9, 1e9},
    {"size_right", 0, 1e9},
    {"angle_right", -1e9, 1e9},
    {"index_left", 0, kMaxCount, true},
    {"index_right", 0, kMaxCount, true},
    {"label", 0, kMaxCount, true},
};

const Column* findColumn(const std::string& name) {
  const auto found = std::find_if(std::begin(kColumns), std::end(kColumns),
                                  [&name](const Column& column) { return name == column.name; });
  return found == std::end(kColumns) ? nullptr : found;
}

std::string knownColumns() {
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.push_back(column.name);
  return joinList(names);
}

/// The columns of a list while its file is read.
class ListFile {
 public:
  explicit ListFile(const std::string& path) : path_(path) {
    std::ifstream stream(path);
    if (!stream) fail("cannot be opened; check the permissions of the file");
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      if (splitList(line).empty()) continue;
      if (columns_.empty()) {
        readHeader(line);
      } else {
        readRow(line);
      }
    }
    if (columns_.empty())
      fail("is empty; its first line must name the columns, e.g. " + std::string(kExample));
  }

  [[noreturn]] void fail(const std::string& fault) const { throw DatasetError(path_ + ": " + fault); }

  bool has(const std::string& name) const { return values_.count(name) != 0; }
  const std::vector<double>& column(const std::string& name) const { return values_.at(name); }
  template <typename T>
  std::vector<T> as(const std::string& name) const {
    std::vector<T> result;
    if (!has(name)) return result;
    for (const double value : column(name)) result.push_back(static_cast<T>(value));
    return result;
  }

  /// Throws unless the file has all or none of the columns. @return whether it has them
  bool hasTogether(const std::vector<std::string>& names) const {
    std::vector<std::string> missing;
    for (const std::string& name : names) {
      if (!has(name)) missing.push_back(name);
    }
    if (!missing.empty() && missing.size() < names.size()) {
      fail("line 1: " + joinList(names) + " are used together, but " + joinList(missing, " and ") +
           (missing.size() == 1 ? " is missing" : " are missing"));
    }
    return missing.empty();
  }

 private:
  static constexpr const char* kExample = "x_left,y_left,x_right,y_right,label";

  [[noreturn]] void failInLine(const std::string& fault) const {
    fail("line " + std::to_string(line_) + ": " + fault);
  }

  void readHeader(const std::string& line) {
    const std::size_t begin = line.find_first_not_of("\xef\xbb\xbf# \t");  // byte-order mark, numpy's comment
    for (const std::string& name : splitList(line.substr(std::min(begin, line.size())))) {
      const Column* const column = findColumn(name);
      if (column == nullptr) {
        failInLine("'" + name +
                   "' is not a column of a match list; the first line names the columns, separated " +
                   "by commas, e.g. " + kExample + "; known columns: " + knownColumns());
      }
      if (!values_.emplace(name, std::vector<double>()).second) {
        failInLine("the column '" + name + "' stands there twice; remove one of them");
      }
      columns_.push_back(column);
    }
    for (const Column& column : kColumns) {
      if (!column.optional && !has(column.name)) {
        failInLine("the column '" + std::string(column.name) +
                   "' is missing; a match list needs x_left, y_left, " + "x_right and y_right");
      }
    }
  }

  void readRow(const std::string& line) {
    const std::vector<std::string> fields = parseCsvLine(line);
    if (fields.size() != columns_.size()) {
      failInLine("has " + std::to_string(fields.size()) + " values, the first line names " +
                 std::to_string(columns_.size()) + " columns; separate the values by commas");
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      values_[columns_[i]->name].push_back(valueOf(*columns_[i], fields[i]));
    }
  }

  double valueOf(const Column& column, const std::string& field) const {
    const std::string what = "column '" + std::string(column.name) + "'";
    const std::vector<std::string> words = splitList(field);
    const std::string text = words.empty() ? "" : words.front();
    if (column.may_be_nan && (text == "nan" || text == "NaN")) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    double value = 0;
    try {
      value = parseNumber(text, what);
    } catch (const std::invalid_argument& error) {
      failInLine(std::string(error.what()) + "; write a number");
    }
    const bool valid = value >= column.min && value <= column.max;
    if (!valid || (column.whole && value != std::floor(value))) {
      failInLine(what + ": '" + text + "' is not " +
                 (column.whole      ? "a whole number from 0"
                  : column.max == 1 ? "a probability from 0 to 1"
                  : column.min == 0 ? "a finite number from 0"
                                    : "a coordinate or an angle"));
    }
    return value;
  }

  std::string path_;
  std::size_t line_ = 0;
  std::vector<const Column*> columns_;  ///< in the order of the file
  std::map<std::string, std::vector<double>> values_;
};

/// The frames of one side.
std::vector<AffineFrame> framesOf(const ListFile& file, const std::string& side) {
  const std::vector<double>&x = file.column("x_" + side), &y = file.column("y_" + side),
        &size = file.column("size_" + side), &angle = file.column("angle_" + side);
  std::vector<cv::KeyPoint> keypoints;
  for (std::size_t i = 0; i < x.size(); ++i) {
    keypoints.emplace_back(static_cast<float>(x[i]), static_cast<float>(y[i]), static_cast<float>(size[i]),
                           static_cast<float>(angle[i]));
  }
  return similarityFrames(keypoints);
}

void readDistances(const ListFile& file, Correspondences& matches) {
  if (file.has("ratio") && file.has("second_distance")) {
    file.fail("line 1: the columns 'ratio' and 'second_distance' state the same; remove one of them");
  }
  if (file.has("second_distance") && !file.has("distance")) {
    file.fail("line 1: the column 'second_distance' needs the column 'distance', or give 'ratio' instead");
  }
  matches.distance = file.as<float>("distance");
  matches.second_distance = file.as<float>("second_distance");
  if (!file.has("ratio")) return;
  const std::vector<float> ratios = file.as<float>("ratio");
  if (matches.distance.empty()) {
    matches.distance = ratios;
    matches.second_distance.assign(ratios.size(), 1.0F);
    return;
  }
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (ratios[i] == 0 && matches.distance[i] > 0) {
      file.fail("match " + std::to_string(i + 1) + " has the ratio 0 and the distance " +
                formatNumber(matches.distance[i]) + "; only a distance of 0 has the ratio 0");
    }
    // A distance of 0 has the ratio 0 whatever the second distance is.
    matches.second_distance.push_back(ratios[i] == 0 ? 1.0F : matches.distance[i] / ratios[i]);
  }
}

}  // namespace

MatchList readMatchList(const std::string& path) {
  const ListFile file(path);
  MatchList list;
  Correspondences& matches = list.matches;
  matches.left_x = file.as<float>("x_left");
  matches.left_y = file.as<float>("y_left");
  matches.right_x = file.as<float>("x_right");
  matches.right_y = file.as<float>("y_right");
  readDistances(file, matches);
  matches.probability = file.as<float>("match_probability");
  if (file.hasTogether({"size_left", "angle_left", "size_right", "angle_right"})) {
    matches.left_frame = framesOf(file, "left");
    matches.right_frame = framesOf(file, "right");
  }
  if (file.hasTogether({"index_left", "index_right"})) {
    matches.left_index = file.as<std::uint32_t>("index_left");
    matches.right_index = file.as<std::uint32_t>("index_right");
  }
  list.labelled = file.has("label");
  list.labels = file.as<std::uint32_t>("label");
  return list;
}

}  // namespace corrsel::core
