#include "corrsel/database/pair_verifier.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/database/ambiguity.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/selectors/selector.h"
#include "database/competing_models.h"

namespace corrsel::core {
namespace {

constexpr double kReferenceWidth = 1200;  // px: image width for which epipolar_threshold is stated
constexpr float kOutside = 1;             // px by which a position may lie outside its image

OptionMap commonOptions(const PairVerifierOptions& options, double threshold) {
  return {{"fundamental_threshold", formatNumber(threshold)}, {"seed", std::to_string(options.seed)}};
}

/// Whether a point lies more than kOutside away from the image, whose first pixel begins at -0.5.
bool isOutside(const cv::Point2f& p, const cv::Size& size) {
  constexpr float kBorder = kOutside + 0.5F;
  return p.x < -kBorder || p.y < -kBorder || p.x > static_cast<float>(size.width) - 1 + kBorder ||
         p.y > static_cast<float>(size.height) - 1 + kBorder;
}

/// A sentence about what is wrong with the rows of one image, or an empty text.
std::string faultOf(const PairInput& input, std::size_t side, const StoredImage& image,
                    const std::vector<cv::Point2f>& positions) {
  for (std::size_t i = 0; i < input.matches.rows.size(); ++i) {
    const std::uint32_t number = input.matches.rows[i][side];
    if (number >= positions.size())
      return "match " + std::to_string(i) + " names keypoint " + std::to_string(number) + " of image '" +
             image.name + "', which has " + std::to_string(positions.size()) + "; match the pair again";
    const cv::Point2f& p = positions[number];
    if (image.size.area() > 0 && isOutside(p, image.size))
      return "keypoint " + std::to_string(number) + " of image '" + image.name + "' is at (" +
             formatNumber(p.x) + ", " + formatNumber(p.y) + "), outside the image of " +
             sizeText(image.size) + " px; features of a reduced image must be scaled to the original one";
  }
  return "";
}

std::string faultOf(const PairInput& input) {
  if (input.pair.first == input.pair.second) return "the pair is an image with itself; remove the row";
  const std::string fault = faultOf(input, 0, *input.first, input.first_keypoints->positions);
  if (!fault.empty()) return fault;
  return faultOf(input, 1, *input.second, input.second_keypoints->positions);
}

/// The putative matches of a pair with every column that the store has.
Correspondences correspondencesOf(const PairInput& input) {
  Correspondences result;
  const StoredKeypoints &first = *input.first_keypoints, &second = *input.second_keypoints;
  const bool frames = !first.frames.empty() && !second.frames.empty();
  for (const KeypointPair& row : input.matches.rows) {
    result.add(first.positions[row[0]], second.positions[row[1]]);
    result.left_index.push_back(row[0]);
    result.right_index.push_back(row[1]);
    if (!frames) continue;
    result.left_frame.push_back(first.frames[row[0]]);
    result.right_frame.push_back(second.frames[row[1]]);
  }
  result.probability = input.matches.probability;
  result.left_size = input.first->size;
  result.right_size = input.second->size;
  return result;
}

/// The rows of a mask, so that no keypoint is in two of them: those with the best probability, or else the
/// best score, and of equal ones the first in the order of the keypoints' numbers.
std::vector<std::uint32_t> distinctRows(const Correspondences& matches, const std::vector<std::uint8_t>& mask,
                                        const Selection& selection) {
  const std::vector<float>& value =
      selection.probability.size() == mask.size() ? selection.probability : selection.score;
  std::vector<std::uint32_t> rows = selectedRows(mask);
  const auto key = [&](std::uint32_t row) {
    return value.empty() || std::isnan(value[row]) ? 0 : value[row];
  };
  std::sort(rows.begin(), rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (key(a) != key(b)) return key(a) > key(b);
    if (matches.left_index[a] != matches.left_index[b]) return matches.left_index[a] < matches.left_index[b];
    return matches.right_index[a] < matches.right_index[b];
  });
  std::vector<std::uint8_t> left_used, right_used;
  const auto use = [](std::vector<std::uint8_t>& used, std::uint32_t number) {
    if (number >= used.size()) used.resize(number + 1, 0);
    return used[number]++ == 0;
  };
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t row : rows) {
    const std::uint32_t left = matches.left_index[row], right = matches.right_index[row];
    const bool taken = (left < left_used.size() && left_used[left] != 0) ||
                       (right < right_used.size() && right_used[right] != 0);
    if (taken) continue;
    use(left_used, left);
    use(right_used, right);
    kept.push_back(row);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

void PairVerifierOptions::visit(OptionVisitor& visitor) const {
  visitor.text("selector", "Name, preset and options of the selector", &PairVerifierOptions::selector);
  visitor.number({"epipolar_threshold", 0.01, 1000, "px",
                  "Inlier threshold of the epipolar relation in images of 1200 px width; it scales with the "
                  "width. Selectors with a threshold of their own keep that"},
                 &PairVerifierOptions::epipolar_threshold);
  visitor.integer({"min_matches", 5, 1000000, "-", "Smallest number of inliers of an accepted pair"},
                  &PairVerifierOptions::min_matches);
  visitor.number({"min_confidence", 0, 1e6, "-", "Smallest confidence of an accepted pair"},
                 &PairVerifierOptions::min_confidence);
  visitor.flag("ambiguity", "Examine whether a second relation explains the matches of an accepted pair",
               &PairVerifierOptions::ambiguity);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the selectors"}, &PairVerifierOptions::seed);
}

PairVerifier::PairVerifier(const PairVerifierOptions& options) : options_(options) {
  options_.check();
  createSelector(options_.selector, {}, commonOptions(options_, options_.epipolar_threshold));
}

std::string PairVerifier::configuration() const {
  std::string text = "version=1";  // of the algorithm
  for (const OptionText& option : listOptions(options_)) text += " " + option.name + "=" + option.value;
  return text;
}

VerifiedPair PairVerifier::verify(const PairInput& input, Workspace& workspace) const {
  VerifiedPair result;
  result.pair = input.pair;
  result.ambiguity = std::numeric_limits<double>::quiet_NaN();
  result.putative = input.matches.rows.size();
  result.message = faultOf(input);
  result.faulty = !result.message.empty();
  if (result.faulty) return result;
  const Correspondences matches = correspondencesOf(input);
  const int width = std::max(input.first->size.width, input.second->size.width);
  const double threshold = options_.epipolar_threshold * (width > 0 ? width / kReferenceWidth : 1);
  const CompetingModels models(options_.selector, commonOptions(options_, threshold), threshold);
  Selection selection = models.select(matches, workspace);
  result.status = selection.status;
  result.scene = selection.scene;
  result.confidence = selection.confidence;
  result.message = selection.message;
  if (selection.status != Status::kOk || selection.confidence < options_.min_confidence) return result;
  const double second = options_.ambiguity ? ambiguity(matches, selection, workspace)
                                           : std::numeric_limits<double>::quiet_NaN();
  std::optional<PairCameras> cameras;
  if (input.first->calibrated && input.second->calibrated)
    cameras = {*input.first->camera, *input.second->camera};
  TwoViewGeometry geometry = models.geometryOf(matches, cameras ? &*cameras : nullptr, workspace, selection);
  for (const std::uint32_t row : distinctRows(matches, selection.mask, selection))
    geometry.inliers.push_back({matches.left_index[row], matches.right_index[row]});
  if (geometry.inliers.size() < static_cast<std::size_t>(options_.min_matches)) {
    result.message = std::to_string(geometry.inliers.size()) + " inliers, " +
                     std::to_string(options_.min_matches) + " are needed";
    return result;
  }
  result.message.clear();
  result.geometry = std::move(geometry);
  result.ambiguity = second;
  return result;
}

}  // namespace corrsel::core
