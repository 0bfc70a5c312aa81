#include <gtest/gtest.h>

#include <limits>

#include "corrsel/correspondences.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Three matches with every column in use; element i of column c is 10 c + i.
Correspondences threeMatches() {
  Correspondences m;
  m.left_x = {0, 1, 2};
  m.left_y = {10, 11, 12};
  m.right_x = {20, 21, 22};
  m.right_y = {30, 31, 32};
  m.distance = {40, 41, 42};
  m.second_distance = {50, 51, 52};
  m.probability = {0, 0.5F, 1};
  m.left_frame = {AffineFrame{60}, AffineFrame{61}, AffineFrame{62}};
  m.right_frame = {AffineFrame{70}, AffineFrame{71}, AffineFrame{72}};
  m.left_index = {80, 81, 82};
  m.right_index = {90, 91, 92};
  m.left_size = {640, 480};
  m.right_size = {320, 240};
  return m;
}

TEST(Correspondences, AddFillsTheCoordinates) {
  Correspondences m;
  EXPECT_TRUE(m.empty());
  m.add({1, 2}, {3, 4});
  m.add({5, 6}, {7, 8});
  EXPECT_EQ(m.size(), 2u);
  EXPECT_FALSE(m.empty());
  EXPECT_EQ(m.left_x, (std::vector<float>{1, 5}));
  EXPECT_EQ(m.left_y, (std::vector<float>{2, 6}));
  EXPECT_EQ(m.right_x, (std::vector<float>{3, 7}));
  EXPECT_EQ(m.right_y, (std::vector<float>{4, 8}));
  EXPECT_EQ(m.inconsistency(), "");
}

TEST(Correspondences, SubsetTakesEveryColumnInTheGivenOrder) {
  const Correspondences s = threeMatches().subset({2, 0, 2});
  EXPECT_EQ(s.left_x, (std::vector<float>{2, 0, 2}));
  EXPECT_EQ(s.left_y, (std::vector<float>{12, 10, 12}));
  EXPECT_EQ(s.right_x, (std::vector<float>{22, 20, 22}));
  EXPECT_EQ(s.right_y, (std::vector<float>{32, 30, 32}));
  EXPECT_EQ(s.distance, (std::vector<float>{42, 40, 42}));
  EXPECT_EQ(s.second_distance, (std::vector<float>{52, 50, 52}));
  EXPECT_EQ(s.probability, (std::vector<float>{1, 0, 1}));
  EXPECT_EQ(s.left_frame, (std::vector<AffineFrame>{{62}, {60}, {62}}));
  EXPECT_EQ(s.right_frame, (std::vector<AffineFrame>{{72}, {70}, {72}}));
  EXPECT_EQ(s.left_index, (std::vector<std::uint32_t>{82, 80, 82}));
  EXPECT_EQ(s.right_index, (std::vector<std::uint32_t>{92, 90, 92}));
  EXPECT_EQ(s.left_size, cv::Size(640, 480));
  EXPECT_EQ(s.right_size, cv::Size(320, 240));
  EXPECT_EQ(s.inconsistency(), "");
}

TEST(Correspondences, SubsetLeavesAbsentColumnsAbsent) {
  Correspondences m;
  m.add({1, 2}, {3, 4});
  const Correspondences s = m.subset({0});
  EXPECT_EQ(s.size(), 1u);
  EXPECT_TRUE(s.distance.empty() && s.second_distance.empty() && s.probability.empty() &&
              s.left_frame.empty() && s.right_frame.empty() && s.left_index.empty() && s.right_index.empty());
  EXPECT_TRUE(threeMatches().subset({}).empty());
}

TEST(Correspondences, NamesTheColumnOfAnotherLength) {
  EXPECT_EQ(threeMatches().inconsistency(), "");
  const auto complaint = [](auto column, std::size_t length) {
    Correspondences m = threeMatches();
    (m.*column).resize(length);
    return m.inconsistency();
  };
  using C = Correspondences;
  EXPECT_EQ(complaint(&C::left_y, 2), "column left_y has 2 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::left_y, 0), "column left_y has 0 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::right_x, 4), "column right_x has 4 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::right_y, 0), "column right_y has 0 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::left_x, 1), "column left_y has 3 elements, left_x has 1");
  // The other columns may be absent, but not of another length.
  EXPECT_EQ(complaint(&C::distance, 2), "column distance has 2 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::second_distance, 4), "column second_distance has 4 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::probability, 2), "column probability has 2 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::left_frame, 1), "column left_frame has 1 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::right_frame, 2), "column right_frame has 2 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::left_index, 2), "column left_index has 2 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::right_index, 9), "column right_index has 9 elements, left_x has 3");
  EXPECT_EQ(complaint(&C::distance, 0), "");
  EXPECT_EQ(complaint(&C::second_distance, 0), "");
  EXPECT_EQ(complaint(&C::probability, 0), "");
  EXPECT_EQ(complaint(&C::left_frame, 0), "");
  EXPECT_EQ(complaint(&C::right_frame, 0), "");
  EXPECT_EQ(complaint(&C::left_index, 0), "");
  EXPECT_EQ(complaint(&C::right_index, 0), "");
}

TEST(Correspondences, NamesAValueThatIsNoProbability) {
  Correspondences m = threeMatches();
  m.probability[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(m.inconsistency(), "") << "a matcher need not know the probability of every match";
  m.probability[2] = 1.5F;
  EXPECT_EQ(m.inconsistency(),
            "column probability holds 1.5 in row 2, expected 0 to 1, or NaN where it is not known");
  m.probability = {1, 1, -0.25F};
  EXPECT_EQ(m.inconsistency(),
            "column probability holds -0.25 in row 2, expected 0 to 1, or NaN where it is not known");
  m.probability = {std::numeric_limits<float>::infinity(), 1, 1};
  EXPECT_EQ(m.inconsistency(),
            "column probability holds inf in row 0, expected 0 to 1, or NaN where it is not known");
}

TEST(Correspondences, SelectedRowsAreThoseNotZero) {
  EXPECT_EQ(selectedRows({0, 1, 255, 0, 1}), (std::vector<std::uint32_t>{1, 2, 4}));
  EXPECT_TRUE(selectedRows({0, 0}).empty());
  EXPECT_TRUE(selectedRows({}).empty());
}

}  // namespace
}  // namespace corrsel::core
