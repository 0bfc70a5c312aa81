#include "search/selecting.h"

#include <algorithm>
#include <string>

#include "base/text.h"
#include "geometry/residual.h"
#include "search/essential_model.h"
#include "search/frame_proposal.h"
#include "search/local_optimization.h"
#include "search/local_proposal.h"
#include "search/prosac_proposal.h"
#include "search/uniform_proposal.h"

namespace corrsel::core {
namespace {

struct PixelErrors {
  std::vector<double> squared;  // px^2
  RayMatches rays;
};

/// Fits the model to its inliers at the threshold by which matches are selected, where it differs from that
/// of the search.
void fitToSelection(const NormalizedMatches& matches, const Model& model, const SearchParameters& parameters,
                    Candidate& best) {
  const ModelTraits& traits = model.traits;
  if (!parameters.refine || traits.final_width == traits.search_width) return;
  const Verifier verifier(matches, traits.residual, traits.final_width * parameters.threshold * matches.scale,
                          parameters.msac);
  Candidate fitted;
  verifier.improve(best.model, fitted);
  optimizeLocally(model, verifier, fitted);
  best.model = fitted.model;
}

}  // namespace

const Model& modelOf(ModelKind kind, ConsensusOptions::Error error, Workspace& workspace) {
  return kind == ModelKind::kEssential ? workspace.part<EssentialModel>() : modelOf(kind, error);
}

Proposal& proposalOf(SearchOptions::Sampler sampler, Workspace& workspace) {
  switch (sampler) {
    case SearchOptions::Sampler::kProsac:
      return workspace.part<ProsacProposal>();
    case SearchOptions::Sampler::kLocal:
      return workspace.part<LocalProposal>();
    case SearchOptions::Sampler::kFrames:
      return workspace.part<FrameProposal>();
    case SearchOptions::Sampler::kUniform:
      break;
  }
  return workspace.part<UniformProposal>();
}

bool isEnough(std::size_t matches, const Model& model, Selection& result) {
  const int needed = model.traits.sample_size;
  if (matches >= static_cast<std::size_t>(needed)) return true;
  result.status = Status::kTooFew;
  const bool essential = model.traits.kind == ModelKind::kEssential;
  result.message = std::to_string(matches) + " matches, " +
                   (essential ? "an essential matrix" : "a " + toString(model.traits.kind)) + " needs " +
                   std::to_string(needed);
  return false;
}

bool SearchInput::takeAll(const Correspondences& all, const SearchParts& parts, std::uint64_t seed,
                          Selection& result) {
  if (parts.model.traits.uses_rays) {
    readRays(all, seed, result);
    if (!isEnough(rows_.size(), parts.model, result)) return false;
    takeWithRays(all, rows_, parts.proposal, result);
  } else {
    if (!isEnough(all.size(), parts.model, result)) return false;
    ordering_.shuffle(all, seed, rows_);
    take(all, rows_, parts.proposal, result);
  }
  return true;
}

void SearchInput::readRays(const Correspondences& all, std::uint64_t seed, Selection& result) {
  ordering_.shuffle(all, seed, rows_);
  result.n_ignored = unproject(all, rays_, exists_);
  if (result.n_ignored == 0) return;
  rows_.erase(std::remove_if(rows_.begin(), rows_.end(), [this](auto row) { return exists_[row] == 0; }),
              rows_.end());
}

void SearchInput::takeWithRays(const Correspondences& all, const std::vector<std::uint32_t>& some,
                               Proposal& proposal, Selection& result) {
  takeRays(all, rays_, some, matches);
  order(all, some, proposal, result);
}

void SearchInput::take(const Correspondences& all, const std::vector<std::uint32_t>& some, Proposal& proposal,
                       Selection& result) {
  normalizeMatches(all, some, matches);
  order(all, some, proposal, result);
}

void SearchInput::order(const Correspondences& all, const std::vector<std::uint32_t>& some,
                        Proposal& proposal, Selection& result) {
  best_first = nullptr;
  if (proposal.traits.uses_quality && ordering_.byQuality(all, some, by_quality_)) best_first = &by_quality_;
  if (proposal.traits.reports_missing_quality && best_first == nullptr) {
    addRemark(result,
              std::string("the matches have neither descriptor distances nor probabilities, so samples are "
                          "drawn uniformly instead of by ") +
                  proposal.traits.name);
  }
  proposal.read(all, some, best_first);
}

void addRemark(Selection& result, const std::string& text) {
  result.message += (result.message.empty() ? "" : "; ") + text;
}

void reportEnd(const SearchOutcome& outcome, double max_seconds, Selection& result) {
  result.iterations = outcome.iterations;
  if (outcome.timed_out) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    addRemark(result, "stopped after " + std::to_string(result.iterations) + " hypotheses" +
                          (outcome.best.exists() ? "" : ", none of them good enough") +
                          ", max_seconds = " + formatNumber(max_seconds));
  } else if (!outcome.best.exists() && outcome.no_valid_sample) {
    result.status = Status::kDegenerate;
    result.message = "no sample is valid: the matches are collinear, equal or differently oriented";
  } else if (!outcome.best.exists()) {
    result.status = Status::kNoModel;
    result.message = "no hypothesis could be fitted";
  }
}

std::size_t selectByModel(const Correspondences& matches, const Model& model, const cv::Matx33d& pixels,
                          double threshold, Workspace& workspace, Selection& result) {
  const std::size_t n = matches.size();
  result.model = pixels;
  result.model_kind = model.traits.kind;
  auto& [errors, rays] = workspace.part<PixelErrors>();
  if (model.traits.uses_rays) {
    selectionErrors(model.traits.kind, pixels, matches, rays, errors);
  } else {
    errors.resize(n);
    pixelErrors(model.traits.mask_residual, pixels, matches, errors.data());
  }
  result.score.resize(n);
  // Pointers, because a write to the mask might change the vectors otherwise.
  const double* const error = errors.data();
  std::uint8_t* const mask = result.mask.data();
  for (std::size_t i = 0; i < n; ++i) result.score[i] = static_cast<float>(-error[i]);
  for (std::size_t i = 0; i < n; ++i) mask[i] = error[i] <= threshold * threshold ? 1 : 0;
  return static_cast<std::size_t>(std::count(mask, mask + n, 1));
}

void selectByConsensus(const Correspondences& matches, const SearchParts& parts,
                       const SearchParameters& parameters, double max_seconds, Workspace& workspace,
                       Selection& result) {
  const Deadline deadline(max_seconds);
  SearchInput& input = workspace.part<SearchInput>();
  if (!input.takeAll(matches, parts, parameters.seed, result)) return;
  SearchOutcome outcome = search(input.matches, parts, parameters, input.best_first, deadline, workspace);
  Candidate& best = outcome.best;
  reportEnd(outcome, max_seconds, result);
  if (!best.exists()) return;
  fitToSelection(input.matches, parts.model, parameters, best);
  const std::size_t inliers =
      selectByModel(matches, parts.model, parts.model.toPixels(input.matches, best.model),
                    parameters.threshold, workspace, result);
  // Where every point counts once, the mask may hold more matches than count.
  if (std::min(inliers, best.distinct) > static_cast<std::size_t>(parts.model.traits.sample_size)) return;
  std::fill(result.mask.begin(), result.mask.end(), std::uint8_t{0});
  // With more time the search might have found a better model.
  if (result.status != Status::kTimeLimit) {
    result.status = Status::kDegenerate;
    result.message.clear();
  }
  addRemark(result, "only its own sample agrees with the best model, which is therefore unverified");
}

}  // namespace corrsel::core
