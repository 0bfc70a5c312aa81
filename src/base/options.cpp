#include "corrsel/options.h"

#include <algorithm>
#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {
namespace {

std::string rangeText(const NumberInfo& info) {
  return "[" + formatNumber(info.min) + ", " + formatNumber(info.max) + "]";
}

class Checker : public OptionVisitor {
 public:
  void number(const NumberInfo& info, double& value) override {
    // Written so that NaN fails.
    if (!(value >= info.min && value <= info.max)) {
      throw std::invalid_argument("option " + std::string(info.name) + " = " + formatNumber(value) +
                                  " is outside " + rangeText(info));
    }
  }
  void integer(const NumberInfo& info, int& value) override {
    double as_number = value;
    number(info, as_number);
  }
  void flag(const char*, const char*, bool&) override {}
  void choice(const char* name, const std::vector<std::string>& choices, const char*,
              std::string& value) override {
    if (std::find(choices.begin(), choices.end(), value) == choices.end()) {
      throw std::invalid_argument("option " + std::string(name) + " = '" + value + "' is not one of " +
                                  joinList(choices));
    }
  }
};

class Lister : public OptionVisitor {
 public:
  void number(const NumberInfo& info, double& value) override { add(info, formatNumber(value)); }
  void integer(const NumberInfo& info, int& value) override { add(info, std::to_string(value)); }
  void flag(const char* name, const char* description, bool& value) override {
    rows.push_back({name, value ? "true" : "false", "true, false", "-", description});
  }
  void choice(const char* name, const std::vector<std::string>& choices, const char* description,
              std::string& value) override {
    rows.push_back({name, value, joinList(choices), "-", description});
  }
  std::vector<OptionText> rows;

 private:
  void add(const NumberInfo& info, const std::string& value) {
    rows.push_back({info.name, value, rangeText(info), info.unit, info.description});
  }
};

class Setter : public OptionVisitor {
 public:
  Setter(const OptionMap& values, const std::string& context) : values_(values), context_(context) {}
  void number(const NumberInfo& info, double& value) override {
    if (const std::string* text = find(info.name)) value = parseNumber(*text, label(info.name));
  }
  void integer(const NumberInfo& info, int& value) override {
    if (const std::string* text = find(info.name)) value = parseInteger(*text, label(info.name));
  }
  void flag(const char* name, const char*, bool& value) override {
    if (const std::string* text = find(name)) value = parseFlag(*text, label(name));
  }
  void choice(const char* name, const std::vector<std::string>&, const char*, std::string& value) override {
    if (const std::string* text = find(name)) value = *text;
  }
  std::vector<std::string> known;

 private:
  std::string label(const char* name) const { return "option " + context_ + "." + name; }
  const std::string* find(const char* name) {
    known.push_back(name);
    const auto found = values_.find(name);
    return found == values_.end() ? nullptr : &found->second;
  }
  const OptionMap& values_;
  const std::string& context_;
};

}  // namespace

void OptionSet::check() const {
  Checker checker;
  // The checker only reads; visit() is shared with visitors that write.
  const_cast<OptionSet*>(this)->visit(checker);
}

std::vector<OptionText> listOptions(const OptionSet& options) {
  Lister lister;
  const_cast<OptionSet&>(options).visit(lister);
  return lister.rows;
}

void setOptions(OptionSet& options, const OptionMap& values, const std::string& context) {
  Setter setter(values, context);
  options.visit(setter);
  for (const auto& [name, value] : values) {
    if (std::find(setter.known.begin(), setter.known.end(), name) == setter.known.end()) {
      throw std::invalid_argument("unknown option " + context + "." + name +
                                  "; valid: " + (setter.known.empty() ? "none" : joinList(setter.known)));
    }
  }
}

void setOptionsWherePresent(OptionSet& options, const OptionMap& values, const std::string& context) {
  Setter setter(values, context);
  options.visit(setter);
}

}  // namespace corrsel::core
