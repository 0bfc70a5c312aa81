#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace corrsel {

/// The command line cannot be used. The text names the argument, its value and what is valid.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// One argument of a program.
struct Argument {
  std::string name;           ///< as the help shows it; in a command line '-' and '_' are the same
  std::string value;          ///< placeholder of the value in the help, e.g. "FILE"; empty for a switch
  std::string default_value;  ///< empty: none
  std::string meaning;        ///< one sentence without a full stop
};

/// What a program is and which arguments it takes. This table is the only place where they are stated.
struct CommandLineTable {
  std::string program, purpose;         ///< purpose: a full sentence
  std::vector<std::string> positional;  ///< names of the arguments without a name, all of them needed
  std::vector<Argument> arguments;      ///< besides --help, which every program has
  std::string notes;                    ///< printed after the arguments: exit codes, examples
};

/// The values of a command line.
class ArgumentValues {
 public:
  /// Text of an argument, its default where it was not given; of a positional one too. Throws
  /// std::out_of_range where the table has no such argument.
  const std::string& text(const std::string& name) const { return values_.at(name); }

  /// Whether the command line has it.
  bool given(const std::string& name) const;

  /// Whether a switch is on.
  bool isOn(const std::string& name) const { return !values_.at(name).empty(); }

  // Each throws UsageError naming the argument, the value and what is valid.
  double number(const std::string& name) const;
  double number(const std::string& name, double low, double high) const;
  int integer(const std::string& name) const;
  int integer(const std::string& name, int low, int high) const;
  bool flag(const std::string& name) const;  ///< "true" or "false"
  std::string choice(const std::string& name, const std::vector<std::string>& choices) const;
  std::vector<std::string> list(const std::string& name) const;  ///< comma-separated

  bool help = false;

 private:
  friend ArgumentValues parseCommandLine(const CommandLineTable&, const std::vector<std::string>&,
                                         std::vector<std::string>*);
  std::map<std::string, std::string> values_;
  std::vector<std::string> given_;
};

/// Reads `--name value`, `--name=value`, `name:=value`, `--switch` and positional arguments, in any order. An
/// argument whose placeholder is BOOL is true where no value follows its name. Where `--help` or `-h` is
/// given, nothing else is checked. Names that roslaunch adds (`__name:=x`, `_parameter:=x`) are skipped.
/// @param words  without the program's name
/// @param rest   takes the words that the table does not know; without it they are an error
/// Throws UsageError for an unknown name (with the nearest and all valid ones), an argument that is given
/// twice, a missing value and a wrong number of positional arguments.
ArgumentValues parseCommandLine(const CommandLineTable& table, const std::vector<std::string>& words,
                                std::vector<std::string>* rest = nullptr);

/// The text of --help, at most 110 columns wide.
std::string helpText(const CommandLineTable& table);

}  // namespace corrsel
