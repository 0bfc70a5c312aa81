#include "corrsel/features/image_faults.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/text.h"

namespace corrsel::core {
namespace {

// Limits beyond which features are lost; see docs/studies/image_quality.md.
constexpr double kDark = 0.5, kOverexposed = 0.35;    // share of the pixels
constexpr double kBlurred = 2.0;                      // px, whatever the images before
constexpr double kMoved = 1.2, kRelativeBlur = 1.75;  // px, and as a multiple of sharp images
constexpr double kNoisy = 12;                         // of 255
constexpr double kCells = 64, kFewCells = 8;          // of the texture
constexpr double kTurns = 10 * M_PI / 180;            // rad/s, a turn that is worth mentioning

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string percent(double share) { return number("%.0f %%", 100 * share); }

std::string cells(const ImageQuality& quality) {
  return "features in " + number("%.0f", quality.texture * kCells) + " of " + number("%.0f", kCells) +
         " cells";
}

bool isBlurred(const ImageQuality& quality) {
  return quality.blur > kBlurred || (quality.blur > kMoved && quality.relative_blur > kRelativeBlur);
}

std::string blurText(const ImageQuality& quality, double turn_rate) {
  std::string text = "is blurred: edges " + number("%.1f px", quality.blur) + " wide";
  if (quality.relative_blur > kRelativeBlur) {
    text += ", " + number("%.1f", quality.relative_blur) + " times those of the sharp images before";
  }
  if (turn_rate > kTurns) text += "; turn of " + number("%.0f deg/s", turn_rate * 180 / M_PI);
  return text;
}

}  // namespace

std::string faultsOf(const ImageQuality& quality, const std::string& name, double turn_rate) {
  std::vector<std::string> faults;
  if (quality.black > kDark) {
    faults.push_back("is dark: " + percent(quality.black) + " of the pixels are black");
  }
  if (quality.saturated > kOverexposed) {
    faults.push_back("is overexposed: " + percent(quality.saturated) + " of the pixels are saturated");
  }
  if (isBlurred(quality)) faults.push_back(blurText(quality, turn_rate));
  if (quality.noise > kNoisy) {
    faults.push_back("is noisy: standard deviation " + number("%.0f of 255", quality.noise));
  }
  // Each of the others has few features as its consequence.
  if (faults.empty() && quality.texture * kCells < kFewCells) {
    faults.push_back("has little texture: " + cells(quality));
  }
  return faults.empty() ? "" : "the " + name + " " + joinList(faults, ", and ");
}

std::string faultsOf(const ImageQuality& left, const ImageQuality& right, double turn_rate) {
  std::string text = faultsOf(left, "left image", turn_rate);
  const std::string of_right = faultsOf(right, "right image", turn_rate);
  if (!text.empty() && !of_right.empty()) text += "; ";
  return text + of_right;
}

std::string toText(const ImageQuality& quality) {
  std::vector<std::string> parts;
  const auto add = [&parts](double value, const std::string& text) {
    if (!std::isnan(value)) parts.push_back(text);
  };
  add(quality.black, "black " + percent(quality.black));
  add(quality.saturated, "saturated " + percent(quality.saturated));
  add(quality.blur, "blur " + number("%.1f px", quality.blur));
  add(quality.relative_blur, number("%.1f", quality.relative_blur) + " times that of sharp images");
  add(quality.noise, "noise " + number("%.1f of 255", quality.noise));
  add(quality.texture, cells(quality));
  return parts.empty() ? "not measured" : joinList(parts);
}

double turnRate(const cv::Matx33d& rotation, double seconds) {
  if (seconds == 0) return std::numeric_limits<double>::quiet_NaN();
  const double cosine = std::clamp((cv::trace(rotation) - 1) / 2, -1.0, 1.0);
  return std::acos(cosine) / std::abs(seconds);
}

}  // namespace corrsel::core
