#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/text.h"
#include "corrsel/ground_truth.h"
#include "corrsel/pose/estimator.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The text of a cell. An undefined number is NaN; its cell in the file is empty.
using CellValue = std::variant<std::string, std::size_t, int, double>;

std::string cellText(const CellValue& cell);

/// Reads a cell into a field of a row. An empty cell leaves a count or a number as it is in a row that was
/// just constructed. Throws std::invalid_argument naming the column and the text.
void readCell(const std::string& text, const std::string& column, std::string& field);
void readCell(const std::string& text, const std::string& column, std::size_t& field);
void readCell(const std::string& text, const std::string& column, int& field);
void readCell(const std::string& text, const std::string& column, double& field);
void readCell(const std::string& text, const std::string& column, Status& field);
void readCell(const std::string& text, const std::string& column, SceneKind& field);
void readCell(const std::string& text, const std::string& column, PoseModel& field);
void readCell(const std::string& text, const std::string& column, TruthKind& field);
void readCell(const std::string& text, const std::string& column, Motion& field);

/// A column of a table: its name, how its cell is written and how it is read.
template <class Row>
struct CsvColumn {
  std::string name;
  std::function<CellValue(const Row&)> cell;
  std::function<void(const std::string& text, Row& row)> read;
};

inline CellValue toCell(Status status) { return toString(status); }
inline CellValue toCell(SceneKind scene) { return toString(scene); }
inline CellValue toCell(PoseModel model) { return toString(model); }
inline CellValue toCell(TruthKind kind) { return toString(kind); }
inline CellValue toCell(Motion motion) { return toString(motion); }
template <class Field>
CellValue toCell(const Field& field) {
  return CellValue(field);
}

/// The column of a field of the row.
template <class Row, class Field>
CsvColumn<Row> csvColumn(const std::string& name, Field Row::*field) {
  return {name, [field](const Row& row) { return toCell(row.*field); },
          [name, field](const std::string& text, Row& row) { readCell(text, name, row.*field); }};
}

/// The column of a field in a part of the row.
template <class Row, class Part, class Field>
CsvColumn<Row> csvColumn(const std::string& name, Part Row::*part, Field Part::*field) {
  return {
      name, [part, field](const Row& row) { return toCell((row.*part).*field); },
      [name, part, field](const std::string& text, Row& row) { readCell(text, name, (row.*part).*field); }};
}

/// The column of a field in a part of a part of the row.
template <class Row, class Part, class Inner, class Field>
CsvColumn<Row> csvColumn(const std::string& name, Part Row::*part, Inner Part::*inner, Field Inner::*field) {
  return {name, [part, inner, field](const Row& row) { return toCell(((row.*part).*inner).*field); },
          [name, part, inner, field](const std::string& text, Row& row) {
            readCell(text, name, ((row.*part).*inner).*field);
          }};
}

/// A CSV file of a run's folder. Its list of columns is stated here only: rows are written and read by it.
template <class Row>
class CsvTable {
 public:
  /// @param file    path inside the run's folder
  /// @param format  a line that stands before the header and tells the version of the file's format; empty:
  ///                there is none
  CsvTable(const std::string& file, std::vector<CsvColumn<Row>> columns, const std::string& format = "")
      : file_(file), columns_(std::move(columns)), format_(format) {}

  const std::string& file() const { return file_; }
  const std::vector<CsvColumn<Row>>& columns() const { return columns_; }

  /// The names of the columns in one line, without its end.
  std::string header() const {
    std::vector<std::string> names;
    for (const CsvColumn<Row>& column : columns_) names.push_back(column.name);
    return csvLine(names);
  }

  /// The lines before the rows, with their ends: the format, where the file tells it, and the header.
  std::string head() const { return (format_.empty() ? "" : format_ + "\n") + header() + "\n"; }
  std::size_t headLines() const { return format_.empty() ? 1 : 2; }

  /// Number of a column, from 0. Throws std::logic_error if the table has no such column.
  std::size_t indexOf(const std::string& name) const {
    const auto found = std::find_if(columns_.begin(), columns_.end(),
                                    [&name](const CsvColumn<Row>& column) { return column.name == name; });
    if (found == columns_.end()) throw std::logic_error(file_ + " has no column " + name);
    return static_cast<std::size_t>(found - columns_.begin());
  }

  /// The line of a row, with its end.
  std::string line(const Row& row) const {
    std::vector<std::string> fields;
    for (const CsvColumn<Row>& column : columns_) fields.push_back(cellText(column.cell(row)));
    return csvLine(fields) + "\n";
  }

  /// Throws std::invalid_argument where the line is no complete row; the text names the column.
  Row parse(const std::string& line) const {
    const std::vector<std::string> fields = parseCsvLine(line);
    if (fields.size() != columns_.size()) {
      throw std::invalid_argument("row has " + std::to_string(fields.size()) + " columns instead of " +
                                  std::to_string(columns_.size()) + ": " + line);
    }
    Row row;
    for (std::size_t i = 0; i < fields.size(); ++i) columns_[i].read(fields[i], row);
    return row;
  }

  /// Head and rows: the text of the whole file.
  std::string text(const std::vector<Row>& rows) const {
    std::string result = head();
    for (const Row& row : rows) result += line(row);
    return result;
  }

  /// The rows of a file's text; damaged lines, and a last line that was cut off, are left out.
  std::vector<Row> intactRows(const std::string& text) const {
    std::vector<Row> rows;
    const std::vector<std::string> lines = completeLines(text);
    for (std::size_t i = headLines(); i < lines.size(); ++i) {
      try {
        rows.push_back(parse(lines[i]));
      } catch (const std::invalid_argument&) {
        continue;
      }
    }
    return rows;
  }

 private:
  std::string file_;
  std::vector<CsvColumn<Row>> columns_;
  std::string format_;
};

}  // namespace corrsel::core
