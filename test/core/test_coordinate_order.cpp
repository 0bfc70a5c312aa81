#include <gtest/gtest.h>

#include <limits>

#include "base/coordinate_order.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(CoordinateOrder, KeysCompareLikeTheValues) {
  const float values[] = {
      -std::numeric_limits<float>::infinity(), -1e6f, -1.5f, -1e-40f, 0.0f, 1e-40f, 1.5f, 1e6f};
  for (std::size_t i = 1; i < std::size(values); ++i) EXPECT_LT(sortKey(values[i - 1]), sortKey(values[i]));
  EXPECT_EQ(sortKey(-0.0f), sortKey(0.0f));
}

/// Keys that are spread evenly, that lie in two clusters, and that are few different ones.
std::vector<KeyedRow> makeRows(std::size_t n, int kind) {
  Random random(3);
  std::vector<KeyedRow> rows;
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto any = static_cast<std::uint32_t>(random.next());
    const std::uint32_t cluster = i % 2 == 0 ? 100000U : 4000000000U;
    rows.push_back({kind == 0 ? any : kind == 1 ? cluster + any % 5000 : 7 + any % 50, i});
  }
  return rows;
}

TEST(CoordinateOrder, RadixSortIsStable) {
  for (const std::size_t n : {0, 1, 2, 300, 5000, 300000}) {
    for (const int kind : {0, 1, 2}) {
      std::vector<KeyedRow> rows = makeRows(n, kind), expected = rows, scratch;
      std::stable_sort(expected.begin(), expected.end(),
                       [](const KeyedRow& a, const KeyedRow& b) { return a.key < b.key; });
      radixSort(rows, scratch);
      ASSERT_EQ(rows.size(), n);
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(rows[i].key, expected[i].key) << "n " << n << ", kind " << kind;
        ASSERT_EQ(rows[i].row, expected[i].row) << "n " << n << ", kind " << kind;
      }
    }
  }
}

TEST(CoordinateOrder, SortsByEveryCoordinateThenByDistance) {
  Correspondences m;
  const float rows_of_m[][5] = {{1, 2, 3, 4, 9},  {1, 2, 3, 4, 7},  {1, 2, 3, -4, 8},  {1, 2, -3, 4, 8},
                                {1, -2, 9, 9, 8}, {-1, 9, 9, 9, 8}, {1, 2, 3, 4, NAN}, {1, 2, 3, 4, 7}};
  for (const auto& row : rows_of_m) m.add({row[0], row[1]}, {row[2], row[3]});
  for (const auto& row : rows_of_m) m.distance.push_back(row[4]);
  std::vector<KeyedRow> rows, scratch;
  sortByCoordinates(m, rows, scratch);
  const std::uint32_t expected[] = {5, 4, 3, 2, 1, 7, 0, 6};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(rows[i].row, expected[i]) << i;
  EXPECT_EQ(compareCoordinates(m, 0, 1), 0);
  EXPECT_LT(compareCoordinates(m, 2, 0), 0);
  EXPECT_GT(compareCoordinates(m, 0, 5), 0);
}

TEST(CoordinateOrder, AllEqualComparesBothCoordinates) {
  EXPECT_TRUE(allEqual({}, {}));
  EXPECT_TRUE(allEqual({1, 1}, {2, 2}));
  EXPECT_FALSE(allEqual({1, 2}, {2, 2}));
  EXPECT_FALSE(allEqual({1, 1}, {2, 3}));
}

}  // namespace
}  // namespace corrsel::core
