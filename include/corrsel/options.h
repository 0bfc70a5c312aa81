#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace corrsel::core {

/// Option names and their values as text, as they come from a command line, a YAML file or a ROS parameter.
using OptionMap = std::map<std::string, std::string>;

/// What a user must know about one numeric option.
struct NumberInfo {
  const char* name;         ///< lower_case_with_underscores, unique inside the option set
  double min;               ///< smallest accepted value
  double max;               ///< largest accepted value
  const char* unit;         ///< "px", "s", "-" for a plain number
  const char* description;  ///< one sentence
};

/// Visits the fields of an option set: the single place where name, range, unit and meaning are written down.
/// Range checks, command lines, YAML files, ROS parameters and the documentation are all visitors.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void number(const NumberInfo& info, double& value) = 0;
  virtual void integer(const NumberInfo& info, int& value) = 0;
  virtual void flag(const char* name, const char* description, bool& value) = 0;
  virtual void choice(const char* name, const std::vector<std::string>& choices, const char* description,
                      std::string& value) = 0;
};

/// Base of every per-algorithm option struct.
class OptionSet {
 public:
  virtual ~OptionSet() = default;

  /// Calls the visitor once per field, in declaration order.
  virtual void visit(OptionVisitor& visitor) = 0;

  /// Throws std::invalid_argument naming the option, its value and its range. Derived structs add the
  /// conditions that couple several options.
  virtual void check() const;
};

/// One option as text, for listings and files.
struct OptionText {
  std::string name, value, range, unit, description;
};

/// All options in declaration order. Values are written so that they read back bit-identically.
std::vector<OptionText> listOptions(const OptionSet& options);

/// Sets options by name. Throws std::invalid_argument for an unknown name (listing the valid ones) or a value
/// that cannot be read. Ranges are left to check().
/// @param context  what the options belong to, e.g. "gms"; used in the error text only
void setOptions(OptionSet& options, const OptionMap& values, const std::string& context);

/// Like setOptions(), but names that the set does not have are skipped: for values offered to every
/// algorithm, such as the seed.
void setOptionsWherePresent(OptionSet& options, const OptionMap& values, const std::string& context);

}  // namespace corrsel::core
