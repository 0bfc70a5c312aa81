#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "test_support.h"

namespace corrsel::core::testing {

/// Compares how many matches of a pair of AdelaideRMF a selector selects, and how many of these are right.
/// @param expected  by name of the pair: selected, right
inline void expectCounts(const std::string& spec, const std::map<std::string, std::pair<int, int>>& expected,
                         int slack, const OptionMap& options = {}) {
  std::size_t compared = 0;
  for (const LabelledPair& pair : adelaidePairs()) {
    const auto found = expected.find(pair.name);
    if (found == expected.end()) continue;
    ++compared;
    const std::vector<std::uint8_t> mask = createSelector(spec, options)->select(pair.matches).mask;
    const std::vector<double> errors = groundTruthErrors(pair.truth, pair.matches);
    int selected = 0, right = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      selected += mask[i];
      right += mask[i] != 0 && errors[i] == 0 ? 1 : 0;
    }
    EXPECT_NEAR(selected, found->second.first, slack) << pair.name;
    EXPECT_NEAR(right, found->second.second, slack) << pair.name;
  }
  EXPECT_EQ(compared, expected.size());
}

}  // namespace corrsel::core::testing
