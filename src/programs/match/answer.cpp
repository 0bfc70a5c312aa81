#include "programs/match/answer.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "base/text.h"
#include "corrsel/matching/match_drawing.h"

namespace corrsel {
namespace {

constexpr double kDegrees = 57.29577951308232;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[160];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

/// Numbers of the kept matches of every group; -1 = in no group.
std::map<std::int32_t, std::size_t> groupSizes(const core::Selection& selection) {
  std::map<std::int32_t, std::size_t> sizes;
  for (std::size_t i = 0; i < selection.group.size(); ++i) {
    if (selection.mask[i] != 0) ++sizes[selection.group[i]];
  }
  return sizes;
}

std::string line(const std::string& name, const std::string& value) {
  return formatted("%-12s", name.c_str()) + value + "\n";
}

std::string imageText(const MatchedImage& image) {
  return image.file + formatted(", %d x %d px, ", image.pixels.cols, image.pixels.rows) +
         std::to_string(image.features) + " features";
}

std::string sceneText(const MatchAnswer& answer) {
  const std::string words = core::inWords(answer.selection.scene);
  return words.empty() ? "unknown" : words;
}

std::string keptText(const MatchAnswer& answer) {
  const std::size_t kept = answer.selection.n_selected, all = answer.matches.size();
  std::string text = std::to_string(kept) + " of " + std::to_string(all) + " kept";
  if (all > 0) text += formatted(" (%.1f %%)", 100.0 * static_cast<double>(kept) / static_cast<double>(all));
  return text + ", by " + answer.selector + " of " + answer.features;
}

std::string groupText(const core::Selection& selection) {
  std::vector<std::string> parts;
  for (const auto& [group, size] : groupSizes(selection)) {
    if (group >= 0) parts.push_back(std::to_string(size));
  }
  return std::to_string(parts.size()) + " with " + core::joinList(parts) + " matches";
}

std::string confidenceText(double confidence) {
  // Less would be printed as 0.0.
  if (confidence < 0.05) return "0: chance explains the agreement";
  return formatted("%.1f: chance is expected to show 10^-%.1f agreements as good as this", confidence,
                   confidence);
}

std::string matrixLines(const std::string& name, const cv::Matx33d& matrix) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    text += line(row == 0 ? name : "",
                 formatted("%14.7g %14.7g %14.7g", matrix(row, 0), matrix(row, 1), matrix(row, 2)));
  }
  return text;
}

std::string poseLines(const core::PoseResult& found) {
  const cv::Matx33d& turned = found.pose.rotation;
  const cv::Vec3d& t = found.pose.translation;
  const cv::Vec3d twice(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0),
                        turned(1, 0) - turned(0, 1));
  const double sine = cv::norm(twice) / 2, cosine = (cv::trace(turned) - 1) / 2;
  std::string text =
      line("motion", core::toString(found.motion) +
                         formatted(", parallax %.3g px, noise %.3g px", found.parallax, found.noise));
  std::string rotation = formatted("%.4g degrees", kDegrees * std::atan2(sine, cosine));
  if (sine > 1e-12) {
    const cv::Vec3d axis = twice / (2 * sine);
    rotation += formatted(" about (%.4f, %.4f, %.4f)", axis[0], axis[1], axis[2]);
  }
  text += line("rotation", rotation);
  if (cv::norm(t) > 0)
    text += line("translation", formatted("(%.4f, %.4f, %.4f), a direction", t[0], t[1], t[2]));
  return text;
}

std::string meaningOf(core::ModelKind kind) {
  switch (kind) {
    case core::ModelKind::kHomography:
      return "maps points of the left image to the right one, px";
    case core::ModelKind::kFundamental:
      return "right^T F left = 0 for the points (x, y, 1) of both images, px";
    case core::ModelKind::kEssential:
      return "right^T E left = 0 for the rays of both cameras";
    case core::ModelKind::kRotation:
      return "turns rays of the left camera to those of the right one";
    case core::ModelKind::kNone:
      break;
  }
  return "";
}

std::string modelLines(const core::Selection& selection) {
  std::string text;
  if (selection.model_kind != core::ModelKind::kNone) {
    text += matrixLines(core::toString(selection.model_kind), selection.model);
    const bool unreliable = selection.status == core::Status::kUncertain;
    text += line("", meaningOf(selection.model_kind) + (unreliable ? "; do not rely on it" : ""));
  }
  if (selection.pose && selection.pose->motion != core::Motion::kNone) text += poseLines(*selection.pose);
  return text;
}

/// Texts in JSON (RFC 8259).
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += std::string("\\") + c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      result += formatted("\\u%04x", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

/// Numbers that are undefined are null, because JSON has no NaN.
std::string number(double value) { return std::isfinite(value) ? core::formatNumber(value) : "null"; }

template <class Numbers>
std::string list(const Numbers& values) {
  std::vector<std::string> texts;
  for (const auto value : values) texts.push_back(number(static_cast<double>(value)));
  return "[" + core::joinList(texts) + "]";
}

using Members = std::vector<std::pair<std::string, std::string>>;

std::string object(const Members& members, const std::string& separator = ", ") {
  std::vector<std::string> texts;
  for (const auto& [name, value] : members) texts.push_back(quoted(name) + ": " + value);
  return "{" + core::joinList(texts, separator) + "}";
}

std::string imageJson(const MatchedImage& image) {
  return object({{"file", quoted(image.file)},
                 {"width", number(image.pixels.cols)},
                 {"height", number(image.pixels.rows)},
                 {"features", number(static_cast<double>(image.features))}});
}

std::string poseJson(const std::optional<core::PoseResult>& pose) {
  if (!pose) return "null";
  return object({{"motion", quoted(core::toString(pose->motion))},
                 {"rotation", list(pose->pose.rotation.val)},
                 {"translation", list(pose->pose.translation.val)},
                 {"covariance", list(pose->covariance.val)},
                 {"noise", number(pose->noise)},
                 {"parallax", number(pose->parallax)}});
}

}  // namespace

std::string textOf(const MatchAnswer& answer) {
  const core::Selection& selection = answer.selection;
  std::string text = line("left", imageText(answer.left)) + line("right", imageText(answer.right)) +
                     line("scene", sceneText(answer)) + line("matches", keptText(answer));
  if (!selection.group.empty()) text += line("groups", groupText(selection));
  text += line("status", core::toString(selection.status) +
                             (selection.message.empty() ? "" : ": " + selection.message));
  if (std::isfinite(selection.confidence)) text += line("confidence", confidenceText(selection.confidence));
  if (std::isfinite(selection.sigma))
    text += line("noise", formatted("%.2f px, the standard deviation of each coordinate of the residuals",
                                    selection.sigma));
  text += modelLines(selection);
  return text +
         line("time", formatted("reading %.0f ms, features %.0f ms, matching %.0f ms, selection %.1f ms",
                                1e3 * answer.read_seconds, 1e3 * answer.features_seconds,
                                1e3 * answer.match_seconds, 1e3 * answer.select_seconds));
}

std::string writtenLine(const std::vector<std::string>& files) {
  return line("written", core::joinList(files, ", "));
}

std::string jsonOf(const MatchAnswer& answer) {
  const core::Selection& selection = answer.selection;
  std::vector<std::size_t> groups;
  for (const auto& [group, size] : groupSizes(selection)) {
    if (group >= 0) groups.push_back(size);
  }
  const bool has_model = selection.model_kind != core::ModelKind::kNone;
  return object({{"left", imageJson(answer.left)},
                 {"right", imageJson(answer.right)},
                 {"features", quoted(answer.features)},
                 {"selector", quoted(answer.selector)},
                 {"status", quoted(core::toString(selection.status))},
                 {"message", quoted(selection.message)},
                 {"scene", quoted(core::toString(selection.scene))},
                 {"n_putative", number(static_cast<double>(answer.matches.size()))},
                 {"n_selected", number(static_cast<double>(selection.n_selected))},
                 {"groups", list(groups)},
                 {"confidence", number(selection.confidence)},
                 {"sigma", number(selection.sigma)},
                 {"model_kind", quoted(core::toString(selection.model_kind))},
                 {"model", has_model ? list(selection.model.val) : "null"},
                 {"pose", poseJson(selection.pose)},
                 {"seconds", object({{"read", number(answer.read_seconds)},
                                     {"features", number(answer.features_seconds)},
                                     {"match", number(answer.match_seconds)},
                                     {"select", number(answer.select_seconds)}})}},
                ",\n ") +
         "\n";
}

}  // namespace corrsel
