#include "selectors/parts/sequential_planes.h"

#include <algorithm>
#include <limits>

#include "base/gather.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;  // that are left, for a further plane
constexpr std::uint32_t kNowhere = 0xffffffffU;

}  // namespace

/// Gives matches within the threshold of one more plane its number, and lowers the smallest errors.
void SequentialPlanes::add(double threshold) {
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    const double error = errors_[i];
    const bool within = error <= threshold * threshold;
    // A match within the threshold of a plane takes the error of that plane, even if it is nearer to another
    // plane with a lower threshold.
    const bool first = within && group_[i] < 0;
    const bool nearer = error < smallest_[i] && (within || group_[i] < 0);
    if (!first && !nearer) continue;
    smallest_[i] = error;
    if (within) group_[i] = planes_;
  }
  ++planes_;
}

/// Writes the positions in `rows` of the trusted matches that are there.
void SequentialPlanes::takeTrusted(const std::vector<std::uint32_t>& rows,
                                   const std::vector<std::uint32_t>& trusted) {
  place_.assign(group_.size(), kNowhere);
  for (std::uint32_t i = 0; i < rows.size(); ++i) place_[rows[i]] = i;
  best_first_.clear();
  for (const std::uint32_t row : trusted)
    if (place_[row] != kNowhere) best_first_.push_back(place_[row]);
}

/// Finds the most significant homography of the matches at some rows.
SignificantModel SequentialPlanes::findOne(const Correspondences& matches,
                                           const std::vector<std::uint32_t>& rows, bool trusted,
                                           const SearchParts& parts, const SearchParameters& parameters,
                                           const Deadline& deadline, Workspace& workspace,
                                           Selection& remarks) {
  // Of all remarks, only the first search's.
  Selection later;
  if (trusted) {
    normalizeMatches(matches, rows, input_.matches);
  } else {
    input_.take(matches, rows, parts.proposal, planes_ == 0 ? remarks : later);
  }
  gather(matches, rows, rest_);
  significance_.assign(rest_);
  const SignificantModel found =
      searchSignificantModel(input_.matches, significance_, parts, parameters,
                             trusted ? &best_first_ : input_.best_first, deadline, workspace);
  all_.iterations += found.outcome.iterations;
  all_.timed_out = found.outcome.timed_out;
  if (planes_ == 0) {
    all_.best = found.outcome.best;
    all_.no_valid_sample = found.outcome.no_valid_sample;
  }
  return found;
}

void SequentialPlanes::find(const Correspondences& matches, std::vector<std::uint32_t>& rows,
                            const std::vector<std::uint32_t>* trusted, const SearchParts& parts,
                            const PlanesOptions& options, const Deadline& deadline, Workspace& workspace,
                            Selection& remarks) {
  SearchParameters parameters;
  parameters.max_iterations = options.max_iterations;
  parameters.seed = static_cast<std::uint64_t>(options.seed);
  planes_ = 0;
  model_ = cv::Matx33d::zeros();
  confidence_ = 0;
  all_ = {};
  group_.assign(matches.size(), -1);
  smallest_.assign(matches.size(), std::numeric_limits<double>::infinity());
  errors_.resize(matches.size());
  while (planes_ < options.max_planes && !all_.timed_out && (planes_ == 0 || rows.size() >= kMinMatches)) {
    if (trusted != nullptr) {
      takeTrusted(rows, *trusted);
      if (best_first_.size() < kMinMatches) break;
    }
    const SignificantModel found =
        findOne(matches, rows, trusted != nullptr, parts, parameters, deadline, workspace, remarks);
    const double confidence = found.significance.confidence;
    if (!found.outcome.best.exists() || confidence < kSignificantConfidence ||
        confidence < options.relative_cut * confidence_)
      break;
    if (planes_ == 0) {
      model_ = found.model;
      confidence_ = confidence;
    }
    const double threshold = std::clamp(options.widen * found.significance.threshold, options.min_threshold,
                                        std::max(options.min_threshold, options.max_threshold));
    pixelErrors(parts.model.traits.mask_residual, found.model, matches, errors_.data());
    add(threshold);
    const std::size_t before = rows.size();
    rows.erase(std::remove_if(rows.begin(), rows.end(),
                              [&](std::uint32_t row) { return errors_[row] <= threshold * threshold; }),
               rows.end());
    if (rows.size() == before) break;
  }
}

}  // namespace corrsel::core
