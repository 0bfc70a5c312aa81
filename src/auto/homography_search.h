#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "auto/memory.h"
#include "corrsel/selectors/auto.h"
#include "search/verifier.h"

namespace corrsel::core {

/// A match is near the homography, and not left over by it, within this many times the threshold.
inline constexpr double kNearHomography = 2;

/// Hypotheses or seeds of a search where there is local support: as many as given, and a quarter of them
/// without the hard search, for callers in a hurry.
int hypothesesOf(const AutoOptions& options, int hypotheses);

/// Hypotheses of a search where nothing else has found a model: as many as the option states, and more for
/// fewer than 1500 matches, of which each takes less time.
/// @param max_factor  times the option, at most
int hardHypotheses(int option, std::size_t matches, double max_factor);

/// Finds the homography that most matches agree with, where every point counts once.
///
/// Algorithm: candidates come from cheap sources first, and the search ends as soon as the best one is good
/// enough:
///  1. Local maps of well supported matches are grown (affine_growing.h). A homography that explains 90 % of
///     the local set ends the search if it is significant.
///  2. PROSAC in the order of local support on the local set, the survivors and the best supported matches.
///     A significant homography with 40 inliers and 60 % of the size of the local set ends the search.
///  3. The maps that the frames of single matches give (frame_hypotheses.h), and PROSAC on all matches.
///  4. Where nothing is significant, `hard_search` hypotheses in the order of the descriptor distances.
/// Each candidate is refined on all matches at twice the threshold and then at sqrt(2) times the threshold
/// (symmetric transfer error), and the lowest MSAC cost at the latter wins.
class HomographySearch {
 public:
  /// @param memory  with matches, order by support and local support; must outlive the search
  HomographySearch(const AutoOptions& options, AutoMemory& memory, Effort& effort);

  /// Writes homography_errors and homography_inliers of the memory.
  void run();

  bool found() const { return best_.exists(); }
  const cv::Matx33d& normalizedModel() const { return best_.model; }
  const cv::Matx33d& model() const { return model_; }  ///< px
  double confidence() const { return confidence_; }

 private:
  void growSeeds();
  void search(const AutoMemory::Rows& order, int hypotheses);
  void searchFrames();
  void addBest(const SearchOutcome& outcome);
  void consider(const cv::Matx33d& normalized);
  void evaluate();
  bool explainsLocalSet() const;
  void gatherSupported();

  const AutoOptions& options_;
  AutoMemory& memory_;
  Effort& effort_;
  Verifier wide_, narrow_;      // 10 and 7 px for a threshold of 5 px
  std::int64_t best_gain_ = 0;  // of a candidate over no model, scored by wide_
  Candidate best_;              // normalised, scored by narrow_
  cv::Matx33d model_ = cv::Matx33d::zeros();
  double confidence_ = 0;
};

}  // namespace corrsel::core
