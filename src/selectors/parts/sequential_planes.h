#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/planes.h"
#include "search/selecting.h"
#include "search/significance.h"
#include "search/significant_model.h"

namespace corrsel::core {

/// Finds planes one after another: the search of PlanesSelector, whose header describes the algorithm.
///
/// Cost: that of PlanesSelector. Memory is kept between calls.
class SequentialPlanes {
 public:
  /// Looks for planes among some of the matches. Only these are searched and tested, but group() and errors()
  /// cover all.
  /// @param rows     rows of `matches` in random order; those that no plane explains remain on return
  /// @param trusted  rows of `matches`, best first. Samples consist of those of them that are in `rows`, and
  ///                 other matches only take part in the test of significance; there is no plane where
  ///                 fewer than 8 are left. nullptr: all take part, in the order of their quality
  /// @param parts    a homography and a proposal
  /// @param options  the number of hypotheses, the seed, and what decides on planes
  /// @param remarks  its message receives what the proposal lacks
  void find(const Correspondences& matches, std::vector<std::uint32_t>& rows,
            const std::vector<std::uint32_t>* trusted, const SearchParts& parts, const PlanesOptions& options,
            const Deadline& deadline, Workspace& workspace, Selection& remarks);

  /// Number of planes.
  std::int32_t planes() const { return planes_; }

  /// Of the first plane, in pixels; zero if there is none.
  const cv::Matx33d& model() const { return model_; }
  double confidence() const { return confidence_; }

  /// Hypotheses and time limit of all searches, and the best candidate of the first one.
  const SearchOutcome& outcome() const { return all_; }

  /// Per match, also for those that were not in `rows`: the number of its plane, or -1.
  const std::vector<std::int32_t>& group() const { return group_; }

  /// Per match: its squared error under its plane, or else the smallest one under all planes, px^2.
  const std::vector<double>& errors() const { return smallest_; }

 private:
  void add(double threshold);
  SignificantModel findOne(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                           bool trusted, const SearchParts& parts, const SearchParameters& parameters,
                           const Deadline& deadline, Workspace& workspace, Selection& remarks);
  void takeTrusted(const std::vector<std::uint32_t>& rows, const std::vector<std::uint32_t>& trusted);

  std::int32_t planes_ = 0;
  cv::Matx33d model_ = cv::Matx33d::zeros();
  double confidence_ = 0;
  SearchOutcome all_;
  std::vector<std::int32_t> group_;
  std::vector<double> errors_, smallest_;
  SearchInput input_;
  std::vector<std::uint32_t> best_first_, place_;
  Correspondences rest_;  // the matches at `rows`
  SignificanceTest significance_;
};

}  // namespace corrsel::core
