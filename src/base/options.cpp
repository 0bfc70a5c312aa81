#include "corrsel/options.h"

#include <algorithm>
#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {
namespace {

class Collector : public OptionVisitor {
 public:
  void field(OptionField field) override { fields.push_back(std::move(field)); }
  std::vector<OptionField> fields;
};

std::vector<std::string> choiceNames(const OptionField& field) {
  std::vector<std::string> names;
  for (const OptionField::Named& choice : field.choices) names.push_back(choice.name);
  return names;
}

/// Whether `name` is one of the field's choices; always for other types.
bool valid(const OptionField& field, const std::string& name) {
  return field.type != OptionType::kChoice ||
         std::any_of(field.choices.begin(), field.choices.end(),
                     [&name](const OptionField::Named& choice) { return choice.name == name; });
}

OptionValue parse(const OptionField& field, const std::string& text, const std::string& label) {
  switch (field.type) {
    case OptionType::kNumber:
      return parseNumber(text, label);
    case OptionType::kInteger:
      return parseInteger(text, label);
    case OptionType::kFlag:
      return parseFlag(text, label);
    default:
      if (valid(field, text)) return text;
      throw std::invalid_argument(label + ": '" + text + "' is not one of " + field.range() +
                                  didYouMean(text, choiceNames(field)));
  }
}

std::string label(const std::string& context, const OptionField& field) {
  return "option " + context + "." + field.name;
}

}  // namespace

std::string toString(OptionType type) {
  constexpr const char* kNames[] = {"number", "integer", "flag", "choice", "text"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string OptionField::range() const {
  switch (type) {
    case OptionType::kFlag:
      return "true, false";
    case OptionType::kChoice:
      return joinList(choiceNames(*this));
    case OptionType::kText:
      return "text";
    default:
      return "[" + formatNumber(min) + ", " + formatNumber(max) + "]";
  }
}

std::string OptionField::text(const OptionSet& options) const {
  const OptionValue value = get(options);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<int>(&value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value)) return formatNumber(*number);
  return std::get<std::string>(value);
}

void OptionField::setText(OptionSet& options, const std::string& text, const std::string& label) const {
  set(options, parse(*this, text, label));
}

void OptionField::check(const OptionSet& options) const {
  const OptionValue value = get(options);
  const auto* integer = std::get_if<int>(&value);
  const auto* number = std::get_if<double>(&value);
  // Written so that NaN fails.
  const auto within = [this](double v) { return v >= min && v <= max; };
  if ((integer != nullptr && !within(*integer)) || (number != nullptr && !within(*number))) {
    throw std::invalid_argument("option " + name + " = " + text(options) + " is outside " + range());
  }
  const auto* words = std::get_if<std::string>(&value);
  if (words != nullptr && !valid(*this, *words)) {
    throw std::invalid_argument("option " + name + " = '" + *words + "' is not one of " + range());
  }
}

void OptionSet::check() const {
  for (const OptionField& field : optionFields(*this)) field.check(*this);
}

std::vector<OptionField> optionFields(const OptionSet& options) {
  Collector collector;
  options.visit(collector);
  return std::move(collector.fields);
}

std::vector<OptionText> listOptions(const OptionSet& options) {
  std::vector<OptionText> rows;
  for (const OptionField& field : optionFields(options)) {
    rows.push_back({field.name, field.text(options), field.range(), field.unit, field.description});
  }
  return rows;
}

void setOptions(OptionSet& options, const OptionMap& values, const std::string& context) {
  setOptionsWherePresent(options, values, context);
  std::vector<std::string> known;
  for (const OptionField& field : optionFields(options)) known.push_back(field.name);
  for (const auto& [name, value] : values) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw std::invalid_argument("unknown option " + context + "." + name + validNames(name, known));
    }
  }
}

void setOptionsWherePresent(OptionSet& options, const OptionMap& values, const std::string& context) {
  for (const OptionField& field : optionFields(options)) {
    const auto found = values.find(field.name);
    if (found != values.end()) field.setText(options, found->second, label(context, field));
  }
}

}  // namespace corrsel::core
