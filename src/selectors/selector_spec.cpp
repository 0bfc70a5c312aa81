#include "corrsel/selectors/selector_spec.h"

#include <algorithm>
#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& fault) {
  throw std::invalid_argument("selector '" + text + "': " + fault +
                              "; options in brackets read name[option=value;option=value]");
}

/// The options between the brackets of a text.
OptionMap optionsIn(const std::string& inside, const std::string& text) {
  OptionMap options;
  for (const std::string& piece : splitList(inside, ';')) {
    if (piece.find(',') != std::string::npos) refuse(text, "'" + piece + "' contains a comma");
    const std::vector<std::string> sides = splitList(piece, '=');
    const auto equals = std::count(piece.begin(), piece.end(), '=');
    if (equals != 1 || sides.size() != 2) refuse(text, "'" + piece + "' is not an option with its value");
    if (!options.emplace(sides[0], sides[1]).second) refuse(text, "option " + sides[0] + " is given twice");
  }
  if (options.empty()) refuse(text, "the brackets are empty");
  return options;
}

}  // namespace

SelectorSpec SelectorSpec::fromText(const std::string& text) {
  SelectorSpec spec;
  const std::size_t open = text.find('['), close = text.find(']');
  if (open == std::string::npos && close != std::string::npos) refuse(text, "']' stands without '['");
  if (open != std::string::npos) {
    if (close == std::string::npos) refuse(text, "']' is missing");
    if (close + 1 != text.size()) refuse(text, "something follows the first ']'");
    if (close < open) refuse(text, "']' stands without '['");
    spec.options = optionsIn(text.substr(open + 1, close - open - 1), text);
  }
  const std::string beginning = text.substr(0, open);
  const std::size_t colon = beginning.find(':');
  spec.name = beginning.substr(0, colon);
  if (colon != std::string::npos) spec.preset = beginning.substr(colon + 1);
  return spec;
}

std::string SelectorSpec::text() const {
  std::vector<std::string> assignments;
  for (const auto& [option, value] : options) assignments.push_back(option + "=" + value);
  return name + (preset ? ":" + *preset : "") +
         (assignments.empty() ? "" : "[" + joinList(assignments, ";") + "]");
}

std::vector<std::string> splitSelectors(const std::string& list) {
  std::vector<std::string> specs(1);
  bool inside = false;
  for (const char c : list) {
    if (c == '[' || c == ']') inside = c == '[';
    if (c == ',' && !inside) {
      specs.emplace_back();
    } else {
      specs.back() += c;
    }
  }
  std::vector<std::string> named;
  for (const std::string& spec : specs) {
    // Without a comma outside of brackets the pieces are the text without the blanks around it.
    const std::vector<std::string> pieces = splitList(spec, '\n');
    named.insert(named.end(), pieces.begin(), pieces.end());
  }
  return named;
}

}  // namespace corrsel::core
