#include <gtest/gtest.h>

#include <cmath>

#include "corrsel/benchmark/results.h"
#include "result_rows.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;
using testing::rowsOf;

TEST(Results, SummaryIsTheMeanOfPerPairValues) {
  std::vector<ResultRow> rows = rowsOf("1-2", 0.2), more = rowsOf("1-3", 0.8), none = rowsOf("1-4", 0.1);
  for (ResultRow& row : none) row.n_ground_truth = 0;
  std::vector<ResultRow> unsupported = rowsOf("1-5", 0.1);
  for (ResultRow& row : unsupported) row.status = Status::kUnsupportedInput;
  // A second repetition of the first pair counts within the pair, not as a pair.
  std::vector<ResultRow> again = rowsOf("1-2", 0.4);
  for (const auto* list : {&more, &none, &unsupported, &again})
    rows.insert(rows.end(), list->begin(), list->end());
  rows[0].metrics.precision = kUndefined;
  for (ResultRow& row : rows) row.confidence = row.selector == "gms" ? 7 : 0;
  rows[0].confidence = 3;
  const std::vector<SummaryRow> summary = summarize(rows);
  ASSERT_EQ(summary.size(), 4U);
  EXPECT_EQ(summary[0].selector, "gms");
  EXPECT_EQ(summary[0].tau, 5.0);
  EXPECT_EQ(summary[0].pairs, 2U);
  EXPECT_NEAR(summary[0].f_paper, (0.3 + 0.8) / 2, 1e-12);
  EXPECT_NEAR(summary[0].precision, 0.75, 1e-12);
  EXPECT_LE(summary[0].f_low, summary[0].f_paper);
  EXPECT_GE(summary[0].f_high, summary[0].f_paper);
  EXPECT_EQ(summary[0].confidence_median, 7);
  EXPECT_EQ(summary[2].confidence_median, 0);
  EXPECT_NEAR(summary[0].select_median, 0.001, 1e-12);
}

}  // namespace
}  // namespace corrsel::core
