#include "programs/command_line.h"

#include <algorithm>
#include <sstream>

#include "base/text.h"

namespace corrsel {
namespace {

constexpr std::size_t kColumns = 110;
constexpr char kHelp[] = "help", kBool[] = "BOOL";

std::string typed(const std::string& name) { return "--" + name; }

std::string normalised(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

const Argument* find(const CommandLineTable& table, const std::string& name) {
  const auto found =
      std::find_if(table.arguments.begin(), table.arguments.end(),
                   [&](const Argument& argument) { return normalised(argument.name) == normalised(name); });
  return found == table.arguments.end() ? nullptr : &*found;
}

/// The name in a word that reads `--name`, `--name=value` or `name:=value`; any other word as it is.
std::string nameIn(const std::string& word) {
  if (word.compare(0, 1, "-") == 0) return word.substr(0, word.find('='));
  return word.substr(0, word.find(":="));
}

/// Whether a word is no value of the argument before it.
bool beginsArgument(const std::string& word) {
  return word.compare(0, 2, "--") == 0 || word.find(":=") != std::string::npos;
}

UsageError unknown(const CommandLineTable& table, const std::string& word) {
  std::vector<std::string> names;
  for (const Argument& argument : table.arguments) names.push_back(typed(argument.name));
  names.push_back(typed(kHelp));
  return UsageError("unknown argument '" + word + "'" + core::validNames(nameIn(word), names));
}

UsageError givenTwice(const Argument& argument, const std::string& first, const std::string& second) {
  return UsageError(typed(argument.name) + " is given twice" +
                    (argument.value.empty() ? "" : ", as '" + first + "' and as '" + second + "'") +
                    "; give it once");
}

void requirePositional(const CommandLineTable& table, std::size_t given) {
  if (given == table.positional.size()) return;
  throw UsageError(core::joinList(table.positional) + ": " + std::to_string(table.positional.size()) +
                   " arguments without a name are needed, " + std::to_string(given) + " given");
}

/// Runs a parser of base/text.h, whose errors are errors of usage here.
template <class Parse>
auto parsed(const Parse& parse) {
  try {
    return parse();
  } catch (const UsageError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

/// Words of `text` in lines of at most kColumns, all but the first indented.
std::string wrapped(const std::string& text, std::size_t indent) {
  std::string result;
  std::size_t column = indent;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (column > indent && column + 1 + word.size() > kColumns) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      result += " ";
      ++column;
    }
    result += word;
    column += word.size();
  }
  return result;
}

}  // namespace

bool ArgumentValues::given(const std::string& name) const {
  return std::find(given_.begin(), given_.end(), name) != given_.end();
}

double ArgumentValues::number(const std::string& name) const {
  return parsed([&] { return core::parseNumber(text(name), typed(name)); });
}

double ArgumentValues::number(const std::string& name, double low, double high) const {
  const double value = number(name);
  if (value >= low && value <= high) return value;
  throw UsageError(typed(name) + " must be between " + core::formatNumber(low) + " and " +
                   core::formatNumber(high) + ", not " + text(name));
}

int ArgumentValues::integer(const std::string& name) const {
  return parsed([&] { return core::parseInteger(text(name), typed(name)); });
}

int ArgumentValues::integer(const std::string& name, int low, int high) const {
  const int value = integer(name);
  if (value >= low && value <= high) return value;
  throw UsageError(typed(name) + " must be between " + std::to_string(low) + " and " + std::to_string(high) +
                   ", not " + text(name));
}

bool ArgumentValues::flag(const std::string& name) const {
  return parsed([&] { return core::parseFlag(text(name), typed(name)); });
}

std::string ArgumentValues::choice(const std::string& name, const std::vector<std::string>& choices) const {
  if (std::find(choices.begin(), choices.end(), text(name)) != choices.end()) return text(name);
  throw UsageError(typed(name) + " must be one of " + core::joinList(choices) + ", not '" + text(name) + "'" +
                   core::didYouMean(text(name), choices));
}

std::vector<std::string> ArgumentValues::list(const std::string& name) const {
  return core::splitList(text(name));
}

ArgumentValues parseCommandLine(const CommandLineTable& table, const std::vector<std::string>& words,
                                std::vector<std::string>* rest) {
  ArgumentValues result;
  for (const Argument& argument : table.arguments) {
    result.values_[argument.name] = argument.value.empty() ? "" : argument.default_value;
  }
  std::vector<std::string> positional;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--help" || word == "-h") {
      result.help = true;
      return result;
    }
    const bool dashed = word.compare(0, 2, "--") == 0;
    const std::size_t assignment = word.find(":="), equals = word.find('=');
    const bool assigned = !dashed && assignment != std::string::npos;
    if (assigned && word[0] == '_') continue;
    if (!dashed && !assigned) {
      const bool is_name = word.compare(0, 1, "-") == 0 && word.size() > 1;
      if (is_name || positional.size() == table.positional.size()) {
        if (!rest) throw unknown(table, word);
        rest->push_back(word);
      } else {
        positional.push_back(word);
      }
      continue;
    }
    const std::string name =
        assigned ? word.substr(0, assignment) : word.substr(2, std::min(equals, word.size()) - 2);
    const Argument* const argument = find(table, name);
    if (!argument) {
      if (!rest) throw unknown(table, word);
      rest->push_back(word);
      continue;
    }
    std::string& value = result.values_[argument->name];
    const std::string before = value;
    const bool twice = result.given(argument->name);
    result.given_.push_back(argument->name);
    const bool joined = assigned || equals != std::string::npos;
    if (argument->value.empty()) {
      if (joined) throw UsageError(typed(argument->name) + " takes no value, but '" + word + "' gives one");
      value = "true";
    } else if (joined) {
      value = word.substr(assigned ? assignment + 2 : equals + 1);
    } else if (argument->value == kBool && (i + 1 == words.size() || beginsArgument(words[i + 1]))) {
      value = "true";
    } else if (i + 1 < words.size()) {
      value = words[++i];
    } else {
      throw UsageError(typed(argument->name) + " needs a value: " + argument->meaning);
    }
    if (twice) throw givenTwice(*argument, before, value);
  }
  requirePositional(table, positional.size());
  for (std::size_t i = 0; i < positional.size(); ++i) result.values_[table.positional[i]] = positional[i];
  return result;
}

std::string helpText(const CommandLineTable& table) {
  std::string usage = "usage: " + table.program;
  for (const std::string& name : table.positional) usage += " " + name;
  std::string text = usage + " [--NAME VALUE | --NAME=VALUE | NAME:=VALUE | --SWITCH]...\n\n" +
                     wrapped(table.purpose, 0) + "\n\n";
  std::vector<Argument> arguments = table.arguments;
  arguments.push_back({kHelp, "", "", "print this text"});
  std::size_t width = 0;
  const auto left = [](const Argument& argument) {
    return "  " + typed(argument.name) + (argument.value.empty() ? "" : " " + argument.value) + "  ";
  };
  for (const Argument& argument : arguments) width = std::max(width, left(argument).size());
  for (const Argument& argument : arguments) {
    std::string line = left(argument);
    line.resize(width, ' ');
    const std::string value = argument.default_value.empty() ? "" : " [" + argument.default_value + "]";
    text += line + wrapped(argument.meaning + value, width) + "\n";
  }
  return text + (table.notes.empty() ? "" : "\n" + table.notes);
}

}  // namespace corrsel
