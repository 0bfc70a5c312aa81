#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "base/deadline.h"
#include "corrsel/workspace.h"
#include "geometry/normalization.h"
#include "search/search.h"
#include "search/significance.h"

namespace corrsel::core {

/// What searchSignificantModel() found.
struct SignificantModel {
  SearchOutcome outcome;                     ///< of the search; its best candidate is that of the model below
  cv::Matx33d model = cv::Matx33d::zeros();  ///< in pixels; zero if there is none
  Significance significance;
};

/// Finds a model together with the threshold at which its agreement with the matches is the least explained
/// by chance.
///
/// Algorithm: search() finds the model that is the best one at 5 px. Its significance tells at which
/// threshold e chance explains it the least. The model is then fitted to the matches within 2 e, and tested
/// again. This is repeated, three times at most, as long as the significance rises and its threshold changes.
///
/// Input: all matches take part in the test. Only those of `best_first` take part in the search.
///
/// Cost: one search, and 2 to 5 tests of significance.
///
/// Source: Moisan and Stival, IJCV 2004. There, each model of the search is tested for its significance. Here
/// MSAC chooses among the hypotheses, because its score can be given up early.
/// @param matches     in random order
/// @param test        has been assigned the same matches
/// @param parameters  the threshold is ignored
/// @param best_first  see search()
/// @pre as for search()
SignificantModel searchSignificantModel(const NormalizedMatches& matches, SignificanceTest& test,
                                        const SearchParts& parts, SearchParameters parameters,
                                        const std::vector<std::uint32_t>* best_first,
                                        const Deadline& deadline, Workspace& workspace);

}  // namespace corrsel::core
