#include "datasets/text_rows.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "datasets/files.h"

namespace corrsel::core {
namespace {

constexpr char kSeparators[] = " \t\r,";

std::vector<std::string> splitWords(const std::string& line) {
  std::vector<std::string> words;
  for (std::size_t begin = line.find_first_not_of(kSeparators); begin != std::string::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return words;
}

bool isDigit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

void TextRow::fail(const std::string& fault) const { throw DatasetError(place() + ": " + fault); }

void TextRow::requireWords(std::size_t count, const std::string& meaning) const {
  if (words.size() == count) return;
  fail("has " + std::to_string(words.size()) + " entries where " + std::to_string(count) + " are expected (" +
       meaning + ")");
}

double TextRow::number(std::size_t word) const {
  const std::string what = "entry " + std::to_string(word + 1);
  double value = 0;
  try {
    value = parseNumber(words.at(word), what);
  } catch (const std::invalid_argument& error) {
    fail(std::string(error.what()) + "; write a number");
  }
  if (!std::isfinite(value)) fail(what + ": '" + words[word] + "' is not finite; write a number");
  return value;
}

std::vector<double> TextRow::numbers(std::size_t first, std::size_t count) const {
  std::vector<double> values;
  for (std::size_t i = first; i < first + count; ++i) values.push_back(number(i));
  return values;
}

std::int64_t TextRow::time(std::size_t word, int decimals) const {
  const std::string& text = words.at(word);
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string whole = text.substr(0, point);
  std::string part = point < text.size() ? text.substr(point + 1) : "";
  if (whole.empty() || !std::all_of(whole.begin(), whole.end(), isDigit) ||
      !std::all_of(part.begin(), part.end(), isDigit) || (decimals == 0 && point < text.size())) {
    fail("entry " + std::to_string(word + 1) + ": '" + text + "' is not a time; write it in " +
         (decimals == 0 ? "nanoseconds" : "seconds"));
  }
  part.resize(static_cast<std::size_t>(decimals), '0');
  try {
    return std::stoll(whole + part);
  } catch (const std::out_of_range&) {
    fail("entry " + std::to_string(word + 1) + ": '" + text + "' has too many digits for a time in " +
         (decimals == 0 ? "nanoseconds" : "seconds"));
  }
}

std::vector<TextRow> readTextRows(const std::string& path, const std::string& remedy) {
  if (existingFiles({path}).empty()) throw DatasetError(path + ": the file is missing; " + remedy);
  std::ifstream stream(path);
  if (!stream) throw DatasetError(path + ": cannot be opened; check the permissions of the file");
  std::vector<TextRow> rows;
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::vector<std::string> words = splitWords(line);
    if (words.empty() || words.front()[0] == '#') continue;
    rows.push_back({path, number, std::move(words)});
  }
  return rows;
}

}  // namespace corrsel::core
