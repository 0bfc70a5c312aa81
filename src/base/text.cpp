#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include "base/checksum.h"

namespace corrsel::core {
namespace {

std::string trim(const std::string& text) {
  const char* const blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// A name without what people confuse: case and separators.
std::string folded(const std::string& name) {
  std::string result;
  for (const char c : name) {
    if (c != '_' && c != '-' && c != ' ') {
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return result;
}

/// What typing errors cost. Swapped neighbours are the likeliest ones.
constexpr std::size_t kEditCost = 4, kSwapCost = 3;

/// Cost of the insertions, deletions, replacements and swaps of neighbours between two texts, where no part
/// is edited twice.
std::size_t editCost(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = kEditCost * j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = kEditCost * i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : kEditCost);
      row[j] = std::min({last[j] + kEditCost, row[j - 1] + kEditCost, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + kSwapCost);
      }
    }
  }
  return row.back();
}

/// Cost up to which one name may be the other one misspelt.
std::size_t largestEditCost(const std::string& a, const std::string& b) {
  return kEditCost * (std::max(a.size(), b.size()) / 3);
}

bool isFileNameCharacter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
         c == '+' || c == '-';
}

}  // namespace

std::string formatNumber(double value) {
  if (std::isnan(value)) return "";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[40];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(buffer, sizeof(buffer), "%.*g", digits, value);
    if (std::strtod(buffer, nullptr) == value) break;
  }
  return buffer;
}

double parseNumber(const std::string& text, const std::string& what) {
  const std::string trimmed = trim(text);
  char* end = nullptr;
  errno = 0;
  const double value = std::strtod(trimmed.c_str(), &end);
  // Subnormal numbers set ERANGE too, but are read correctly.
  const bool beyond_range = errno == ERANGE && (value == 0 || std::isinf(value));
  if (trimmed.empty() || *end != '\0' || beyond_range || std::isnan(value)) {
    throw std::invalid_argument(what + ": '" + text + "' is not a number");
  }
  return value;
}

int parseInteger(const std::string& text, const std::string& what) {
  const double value = parseNumber(text, what);
  if (value != std::floor(value) || value < std::numeric_limits<int>::min() ||
      value > std::numeric_limits<int>::max()) {
    throw std::invalid_argument(what + ": '" + text + "' is not a whole number in the range of int");
  }
  return static_cast<int>(value);
}

bool parseFlag(const std::string& text, const std::string& what) {
  const std::string trimmed = trim(text);
  if (trimmed == "true" || trimmed == "True" || trimmed == "1") return true;
  if (trimmed == "false" || trimmed == "False" || trimmed == "0") return false;
  throw std::invalid_argument(what + ": '" + text + "' is neither true nor false");
}

std::vector<std::string> splitList(const std::string& text, char separator) {
  std::vector<std::string> items;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    std::size_t end = text.find(separator, begin);
    if (end == std::string::npos) end = text.size();
    const std::string item = trim(text.substr(begin, end - begin));
    if (!item.empty()) items.push_back(item);
    begin = end + 1;
  }
  return items;
}

std::string joinList(const std::vector<std::string>& items, const std::string& separator) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) text += (i ? separator : "") + items[i];
  return text;
}

std::string nearestName(const std::string& word, const std::vector<std::string>& names) {
  constexpr std::size_t kMinBeginning = 3;
  const std::string wanted = folded(word);
  // Misspelt names come before those that begin with `word`.
  std::pair<bool, std::size_t> best;
  const std::string* nearest = nullptr;
  for (const std::string& name : names) {
    const std::string candidate = folded(name);
    const std::size_t cost = editCost(wanted, candidate);
    const bool misspelt = cost <= largestEditCost(wanted, candidate);
    const bool beginning = wanted.size() >= kMinBeginning && candidate.compare(0, wanted.size(), wanted) == 0;
    const std::pair<bool, std::size_t> rank = {!misspelt, cost};
    if ((misspelt || beginning) && (nearest == nullptr || rank < best)) {
      best = rank;
      nearest = &name;
    }
  }
  return nearest == nullptr ? "" : *nearest;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& names) {
  const std::string name = nearestName(word, names);
  return name.empty() ? "" : "; did you mean '" + name + "'?";
}

std::string validNames(const std::string& word, const std::vector<std::string>& names,
                       const std::string& heading) {
  const std::string question = didYouMean(word, names);
  return (question.empty() ? ";" : question) + " " + heading + ": " +
         (names.empty() ? "none" : joinList(names));
}

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += (c == '\n' || c == '\r') ? ' ' : c;
  }
  return quoted + '"';
}

std::vector<std::string> parseCsvLine(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else if (c == '"') {
        quoted = false;
      } else {
        fields.back() += c;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      fields.emplace_back();
    } else if (c != '\r' && c != '\n') {
      fields.back() += c;
    }
  }
  return fields;
}

std::string safeFileName(const std::string& text) {
  std::string name = text.empty() ? "_" : text;
  for (char& c : name) {
    if (!isFileNameCharacter(c)) c = '_';
  }
  if (name[0] == '.' || name[0] == '-') name[0] = '_';
  return name;
}

std::string uniqueFileName(const std::string& text) {
  constexpr std::size_t kMaxLength = 200, kKept = 180;
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string name = text.empty() ? "%" : "";
  for (const char c : text) {
    const bool plain = isFileNameCharacter(c) && !(c == '.' && name.empty());
    if (plain) {
      name += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      name += {'%', kDigits[byte / 16], kDigits[byte % 16]};
    }
  }
  if (name.size() <= kMaxLength) return name;
  Checksum checksum;
  checksum.add(text);
  return name.substr(0, kKept) + "%" + checksum.text();
}

std::string csvLine(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) line += (i ? "," : "") + csvField(fields[i]);
  return line;
}

std::vector<std::string> completeLines(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    lines.push_back(text.substr(begin, end - begin));
  }
  return lines;
}

std::string readTextFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace corrsel::core
