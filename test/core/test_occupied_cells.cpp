#include <gtest/gtest.h>

#include "points/occupied_cells.h"

namespace corrsel::core {
namespace {

TEST(OccupiedCells, CountsTheSmallerNumberOfPlaces) {
  Correspondences m;
  for (int i = 0; i < 10; ++i) m.add({20.0F * static_cast<float>(i), 5}, {5, 5});
  OccupiedCells cells;
  EXPECT_EQ(cells.count(m, std::vector<std::uint8_t>(10, 1)), 1U);
  for (std::size_t i = 0; i < 10; ++i) m.right_y[i] = 20.0F * static_cast<float>(i / 2);
  EXPECT_EQ(cells.count(m, std::vector<std::uint8_t>(10, 1)), 5U);
}

TEST(OccupiedCells, CountsWhatTheMaskHolds) {
  Correspondences m;
  for (int i = 0; i < 10; ++i) m.add({20.0F * static_cast<float>(i), 5}, {20.0F * static_cast<float>(i), 5});
  OccupiedCells cells;
  EXPECT_EQ(cells.count(m, {1, 0, 1, 0, 1, 0, 0, 0, 0, 0}), 3U);
  EXPECT_EQ(cells.count(m, std::vector<std::uint8_t>(10, 0)), 0U);
}

TEST(OccupiedCells, TellsNegativeCoordinatesApart) {
  Correspondences m;
  m.add({-1, -1}, {-1, -1});
  m.add({1, 1}, {1, 1});
  m.add({-1, 1}, {-1, 1});
  OccupiedCells cells;
  EXPECT_EQ(cells.count(m, {1, 1, 1}), 3U);
}

TEST(OccupiedCells, TellsTheEndsOfTheRangeApart) {
  Correspondences m;
  m.add({-1e30F, 1e30F}, {-1e30F, 1e30F});
  m.add({1e30F, 1e30F}, {1e30F, 1e30F});
  OccupiedCells cells;
  EXPECT_EQ(cells.count(m, {1, 1}), 2U);
}

}  // namespace
}  // namespace corrsel::core
