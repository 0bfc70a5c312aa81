#include "corrsel/selection.h"

#include <stdexcept>
#include <utility>

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
  std::string valid;
  for (const auto& [value, name] : kStatusTexts) {
    if (text == name) return value;
    valid += std::string(valid.empty() ? "" : ", ") + name;
  }
  throw std::invalid_argument("unknown status '" + text + "'; valid: " + valid);
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
