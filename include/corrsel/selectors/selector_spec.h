#pragma once

#include <optional>
#include <string>
#include <vector>

#include "corrsel/options.h"

namespace corrsel::core {

/// What a text names that stands for a selector: "gms", "lpm:v2", "package/Class:preset". Options of one
/// variant may follow in brackets, separated by semicolons: "usac:h[max_seconds=0.01]",
/// "lpm[lambda_first=4;lambda_second=4]".
struct SelectorSpec {
  std::string name;
  std::optional<std::string> preset;
  OptionMap options;  ///< those in the brackets

  /// Takes a text apart. Only its form is checked; createSelector() checks names and values. Throws
  /// std::invalid_argument naming the text and what is wrong with its brackets.
  static SelectorSpec fromText(const std::string& text);

  /// The text from which fromText() makes this; options are in the order of their names.
  std::string text() const;
};

/// Splits a comma-separated list of such texts. Commas inside brackets do not separate.
std::vector<std::string> splitSelectors(const std::string& list);

}  // namespace corrsel::core
