#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace corrsel::core {

/// Option names and their values as text, as they come from a command line, a file or a program.
using OptionMap = std::map<std::string, std::string>;

class OptionSet;

enum class OptionType : std::uint8_t { kNumber, kInteger, kFlag, kChoice, kText };

/// "number", "integer", "flag", "choice" or "text".
std::string toString(OptionType type);

/// The value of an option: a flag, an integer, a number, or the name of a choice or a text.
using OptionValue = std::variant<bool, int, double, std::string>;

/// What a user must know about one numeric option.
struct NumberInfo {
  const char* name;         ///< lower_case_with_underscores, unique inside the option set
  double min;               ///< smallest accepted value
  double max;               ///< largest accepted value
  const char* unit;         ///< "px", "s", "-" for a plain number
  const char* description;  ///< one sentence
};

/// One value of a choice: the enumerator, its name in texts, and its meaning.
template <class E>
struct Choice {
  E value;
  const char* name;
  const char* meaning;
};

/// One field of an option set, with access to its value in any instance of that set.
struct OptionField {
  struct Named {
    std::string name, meaning;
  };

  std::string name;
  OptionType type = OptionType::kNumber;
  double min = 0, max = 0;  ///< numbers and integers only
  std::string unit = "-";
  std::string description;
  std::vector<Named> choices;  ///< choices only, in the order of their declaration

  /// Reads the value from an instance of the set that described the field. A choice that has none of its
  /// declared values gives its number as text.
  std::function<OptionValue(const OptionSet&)> get;
  /// Writes a value of the alternative that get() returns. A choice takes the name of one of `choices`.
  std::function<void(OptionSet&, const OptionValue&)> set;

  /// The accepted values as text: "[0, 100]", "true, false", the names of the choices, or "text".
  std::string range() const;

  /// The value as text, which setText() reads back to the same bits.
  std::string text(const OptionSet& options) const;

  /// Reads a value from text and writes it. Throws std::invalid_argument naming `label` and the text.
  void setText(OptionSet& options, const std::string& text, const std::string& label) const;

  /// Throws std::invalid_argument if the value is outside the range or not one of the choices.
  void check(const OptionSet& options) const;
};

/// Receives the fields of an option set, one call per field.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void field(OptionField field) = 0;

  template <class S>
  void number(const NumberInfo& info, double S::*member) {
    field(numeric(info, OptionType::kNumber, member));
  }

  template <class S>
  void integer(const NumberInfo& info, int S::*member) {
    field(numeric(info, OptionType::kInteger, member));
  }

  template <class S>
  void flag(const char* name, const char* description, bool S::*member) {
    field(plain(name, OptionType::kFlag, description, member));
  }

  /// A text without a list of valid values, e.g. the name of something that is not known at build time.
  template <class S>
  void text(const char* name, const char* description, std::string S::*member) {
    field(plain(name, OptionType::kText, description, member));
  }

  /// An enumeration. The names that files and messages use are stated here and nowhere else.
  template <class S, class E>
  void choice(const char* name, std::initializer_list<Choice<E>> choices, const char* description,
              E S::*member) {
    OptionField result;
    result.name = name;
    result.type = OptionType::kChoice;
    result.description = description;
    for (const Choice<E>& choice : choices) result.choices.push_back({choice.name, choice.meaning});
    const std::vector<Choice<E>> table = choices;
    result.get = [table, member](const OptionSet& options) -> OptionValue {
      const E value = static_cast<const S&>(options).*member;
      for (const Choice<E>& choice : table) {
        if (choice.value == value) return std::string(choice.name);
      }
      return std::to_string(static_cast<long long>(value));
    };
    result.set = [table, member](OptionSet& options, const OptionValue& value) {
      for (const Choice<E>& choice : table) {
        if (choice.name == std::get<std::string>(value)) static_cast<S&>(options).*member = choice.value;
      }
    };
    field(std::move(result));
  }

 private:
  template <class S, class T>
  static OptionField plain(const char* name, OptionType type, const char* description, T S::*member) {
    OptionField result;
    result.name = name;
    result.type = type;
    result.description = description;
    result.get = [member](const OptionSet& options) -> OptionValue {
      return static_cast<const S&>(options).*member;
    };
    result.set = [member](OptionSet& options, const OptionValue& value) {
      static_cast<S&>(options).*member = std::get<T>(value);
    };
    return result;
  }

  template <class S, class T>
  static OptionField numeric(const NumberInfo& info, OptionType type, T S::*member) {
    OptionField result = plain(info.name, type, info.description, member);
    result.min = info.min;
    result.max = info.max;
    result.unit = info.unit;
    return result;
  }
};

/// Base of every option struct.
class OptionSet {
 public:
  virtual ~OptionSet() = default;

  /// Describes the fields to the visitor, in declaration order. This is the only place where the name, range,
  /// unit, choices and meaning of an option are written: range checks, command lines, files, run-time
  /// parameters, Python and the documentation all read them from here.
  virtual void visit(OptionVisitor& visitor) const = 0;

  /// Throws std::invalid_argument naming the option, its value and its range. Derived structs add the
  /// conditions that couple several options.
  virtual void check() const;
};

/// For algorithms without options.
struct NoOptions : OptionSet {
  void visit(OptionVisitor&) const override {}
};

/// The fields of an option set in declaration order.
std::vector<OptionField> optionFields(const OptionSet& options);

/// One option as text, for listings and files.
struct OptionText {
  std::string name, value, range, unit, description;
};

/// All options in declaration order. Values are written so that they read back bit-identically.
std::vector<OptionText> listOptions(const OptionSet& options);

/// Sets options by name. Throws std::invalid_argument for an unknown name (listing the valid ones) or a value
/// that cannot be read. It does not check ranges; check() does.
/// @param context  what the options belong to, e.g. "gms"; used in the error text only
void setOptions(OptionSet& options, const OptionMap& values, const std::string& context);

/// Like setOptions(), but skips names that the set does not have. It serves values that are offered to every
/// algorithm, such as the seed.
void setOptionsWherePresent(OptionSet& options, const OptionMap& values, const std::string& context);

}  // namespace corrsel::core
