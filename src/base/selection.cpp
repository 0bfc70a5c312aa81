#include "corrsel/selection.h"

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"

namespace corrsel::core {
namespace {

constexpr std::pair<Status, const char*> kStatusTexts[] = {
    {Status::kOk, "ok"},
    {Status::kTooFew, "too_few"},
    {Status::kDegenerate, "degenerate"},
    {Status::kNoModel, "no_model"},
    {Status::kUnsupportedInput, "unsupported_input"},
    {Status::kTooLarge, "too_large"},
    {Status::kTimeLimit, "time_limit"},
    {Status::kFailed, "failed"},
    {Status::kUncertain, "uncertain"},
};

}  // namespace

std::string toString(Status status) {
  for (const auto& [value, text] : kStatusTexts) {
    if (value == status) return text;
  }
  throw std::invalid_argument("unknown status " + std::to_string(static_cast<int>(status)));
}

Status statusFromString(const std::string& text) {
  std::vector<std::string> valid;
  for (const auto& [value, name] : kStatusTexts) {
    if (text == name) return value;
    valid.emplace_back(name);
  }
  throw std::invalid_argument("unknown status '" + text + "'" + validNames(text, valid));
}

std::string toString(ModelKind kind) {
  switch (kind) {
    case ModelKind::kNone:
      return "none";
    case ModelKind::kHomography:
      return "homography";
    case ModelKind::kFundamental:
      return "fundamental";
  }
  throw std::invalid_argument("unknown model kind " + std::to_string(static_cast<int>(kind)));
}

}  // namespace corrsel::core
