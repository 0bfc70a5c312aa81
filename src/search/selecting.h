#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/search/options.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"
#include "geometry/normalization.h"
#include "search/model.h"
#include "search/ordering.h"
#include "search/parameters.h"
#include "search/proposal.h"
#include "search/search.h"

namespace corrsel::core {

/// The model that a user's choice names; the essential matrix is part of the workspace.
const Model& modelOf(ModelKind kind, ConsensusOptions::Error error, Workspace& workspace);

/// The proposal that a user's choice names; part of the workspace.
Proposal& proposalOf(SearchOptions::Sampler sampler, Workspace& workspace);

/// Returns whether there are as many matches as a sample of the model has. Otherwise sets the status kTooFew.
bool isEnough(std::size_t matches, const Model& model, Selection& result);

/// Matches in the form that searches take. Keeps its memory between calls.
class SearchInput {
 public:
  /// Takes all matches, in random order. For models of rays, those whose rays exist.
  /// @return isEnough()
  bool takeAll(const Correspondences& all, const SearchParts& parts, std::uint64_t seed, Selection& result);

  /// Takes the matches at some rows, which are in random order, and prepares the proposal for them.
  /// @param result  the message receives what the proposal lacks
  void take(const Correspondences& all, const std::vector<std::uint32_t>& some, Proposal& proposal,
            Selection& result);

  /// For models of rays: computes the rays of all matches and the rows of those whose rays exist, in random
  /// order. The others are counted as ignored.
  void readRays(const Correspondences& all, std::uint64_t seed, Selection& result);

  /// Takes matches after readRays(). @param some  a part of rows(), in their order
  void takeWithRays(const Correspondences& all, const std::vector<std::uint32_t>& some, Proposal& proposal,
                    Selection& result);

  const std::vector<std::uint32_t>& rows() const { return rows_; }
  const RayMatches& rays() const { return rays_; }

  NormalizedMatches matches;                               ///< in random order
  const std::vector<std::uint32_t>* best_first = nullptr;  ///< positions in `matches`; nullptr = unknown

 private:
  void order(const Correspondences& all, const std::vector<std::uint32_t>& some, Proposal& proposal,
             Selection& result);

  Ordering ordering_;
  RayMatches rays_;
  std::vector<std::uint8_t> exists_;
  std::vector<std::uint32_t> rows_, by_quality_;
};

/// Appends a remark to the message.
void addRemark(Selection& result, const std::string& text);

/// Writes iterations, and status and message where the search found no model or ended at the time limit.
/// @param max_seconds  the limit, s
void reportEnd(const SearchOutcome& outcome, double max_seconds, Selection& result);

/// Turns a model into a selection: writes model and kind, and mask and score by the errors under it, in
/// double precision. The score is the negated squared error, px^2.
/// @param pixels     the model in pixels
/// @param threshold  px
/// @return number of selected matches
std::size_t selectByModel(const Correspondences& matches, const Model& model, const cv::Matx33d& pixels,
                          double threshold, Workspace& workspace, Selection& result);

/// Searches all matches for a model and selects by it. This is what `ransac` and `usac` do.
///
/// Failure: without a model the mask is all zero and the status is kTooFew, kDegenerate (no valid sample, or
/// only the sample itself agrees) or kNoModel. At max_seconds, counted from the call, the best model so far
/// is refined as usual and returned with kTimeLimit. The status is also kTimeLimit if no hypothesis was good
/// enough, and kTooLarge if there was no time for a single one.
/// @param max_seconds  s; 0 = no limit
void selectByConsensus(const Correspondences& matches, const SearchParts& parts,
                       const SearchParameters& parameters, double max_seconds, Workspace& workspace,
                       Selection& result);

}  // namespace corrsel::core
