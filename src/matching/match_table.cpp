#include "matching/match_table.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

namespace corrsel::core {
namespace {

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

}  // namespace

std::string putativeTable(const Correspondences& putative) {
  std::vector<std::uint32_t> rows(putative.size());
  std::iota(rows.begin(), rows.end(), 0U);
  return tableOf(columnsOf(putative), rows);
}

std::string selectedTable(const Correspondences& putative, const Selection& selection) {
  std::vector<MatchColumn> columns = columnsOf(putative);
  columns.insert(columns.begin(), {"row", [](std::size_t row) { return std::to_string(row); }});
  addFloats(columns, "score", selection.score);
  addNumbers(columns, "group", selection.group);
  addFloats(columns, "probability", selection.probability);
  return tableOf(columns, selectedRows(selection.mask));
}

}  // namespace corrsel::core
