#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selectors/selector.h"

namespace corrsel {

/// Matches that show a special case, with all optional columns.
struct DegenerateInput {
  std::string name;  ///< e.g. "points on a line"
  core::Correspondences matches;
};

/// One input of at most 500 matches for each column of the table in docs/data/special_cases.md. Every call
/// returns the same.
std::vector<DegenerateInput> degenerateInputs();

/// Status and share of the selected matches: "`ok`: all", most (at least half), some, few (less than 5 %) or
/// none.
std::string describeSelection(const core::Selector& selector, core::Correspondences matches);

/// The smallest number of matches of a scene with which the status is not `too_few`.
std::size_t minMatches(const core::Selector& selector);

}  // namespace corrsel
