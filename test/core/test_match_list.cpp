#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/match_list.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class MatchListFile : public DatasetFolder {
 protected:
  MatchList read(const std::string& text) const {
    write("matches.csv", text);
    return readMatchList(path("matches.csv"));
  }

  std::string errorFor(const std::string& text) const {
    return errorOf<DatasetError>([&] { read(text); });
  }
};

TEST_F(MatchListFile, CoordinatesAreEnough) {
  const MatchList list = read("x_left,y_left,x_right,y_right\n1,2,3,4\n5.5,-0.25,7e1,8\n");
  EXPECT_EQ(list.matches.left_x, (std::vector<float>{1, 5.5F}));
  EXPECT_EQ(list.matches.left_y, (std::vector<float>{2, -0.25F}));
  EXPECT_EQ(list.matches.right_x, (std::vector<float>{3, 70}));
  EXPECT_EQ(list.matches.right_y, (std::vector<float>{4, 8}));
  EXPECT_EQ(list.matches.inconsistency(), "");
  EXPECT_TRUE(list.matches.distance.empty());
  EXPECT_TRUE(list.matches.probability.empty());
  EXPECT_TRUE(list.matches.left_frame.empty());
  EXPECT_TRUE(list.matches.left_index.empty());
  EXPECT_FALSE(list.labelled);
}

TEST_F(MatchListFile, EveryColumnInAnyOrder) {
  const MatchList list = read(
      "label,distance,second_distance,index_left,index_right,y_right,x_right,y_left,x_left,size_left,angle_"
      "left,"
      "size_right,angle_right,match_probability\n"
      "1,10,20,7,8,4,3,2,1,6,0,8,90,0.75\n"
      "0,11,nan,9,9,4,3,2,1,6,0,8,90,nan\n");
  const Correspondences& matches = list.matches;
  EXPECT_EQ(matches.inconsistency(), "");
  EXPECT_EQ(matches.left_x[0], 1);
  EXPECT_EQ(matches.right_y[0], 4);
  EXPECT_EQ(matches.distance, (std::vector<float>{10, 11}));
  EXPECT_EQ(matches.second_distance[0], 20);
  EXPECT_TRUE(std::isnan(matches.second_distance[1]));
  EXPECT_EQ(matches.probability[0], 0.75F);
  EXPECT_TRUE(std::isnan(matches.probability[1]));
  EXPECT_EQ(matches.left_index, (std::vector<std::uint32_t>{7, 9}));
  EXPECT_EQ(matches.right_index, (std::vector<std::uint32_t>{8, 9}));
  EXPECT_EQ(matches.left_frame[0], (AffineFrame{3, 0, 1, 0, 3, 2}));
  const AffineFrame expected = {0, -4, 3, 4, 0, 4};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(matches.right_frame[0][i], expected[i], 1e-5) << i;
  EXPECT_TRUE(list.labelled);
  EXPECT_EQ(list.labels, (std::vector<std::uint32_t>{1, 0}));
}

TEST_F(MatchListFile, RatioStandsForTheDistances) {
  const MatchList alone = read("x_left,y_left,x_right,y_right,ratio\n1,2,3,4,0.5\n");
  EXPECT_EQ(alone.matches.distance, std::vector<float>{0.5F});
  EXPECT_EQ(alone.matches.second_distance, std::vector<float>{1});
  const MatchList both = read("x_left,y_left,x_right,y_right,ratio,distance\n1,2,3,4,0.5,30\n1,2,3,4,0,0\n");
  EXPECT_EQ(both.matches.distance, (std::vector<float>{30, 0}));
  EXPECT_EQ(both.matches.second_distance, (std::vector<float>{60, 1}));
}

TEST_F(MatchListFile, OutputOfNumpyAndOfSpreadsheetsIsRead) {
  // numpy.savetxt(path, array, delimiter=",", header="x_left, ..."), and a byte-order mark with CRLF.
  for (const std::string text : {"# x_left, y_left, x_right, y_right, "
                                 "label\n1.000000000000000000e+00,2.0,3.0,4.0,1.000000000000000000e+00\n",
                                 "\xef\xbb\xbfx_left,y_left,x_right,y_right,label\r\n1,2,3,4,1\r\n\r\n",
                                 "x_left,y_left,x_right,y_right,label\n1, 2, 3, 4, 1"}) {
    const MatchList list = read(text);
    ASSERT_EQ(list.matches.size(), 1u) << text;
    EXPECT_EQ(list.matches.right_y[0], 4) << text;
    EXPECT_EQ(list.labels, std::vector<std::uint32_t>{1}) << text;
  }
}

TEST_F(MatchListFile, NoMatchesAreAList) {
  EXPECT_TRUE(read("x_left,y_left,x_right,y_right,label\n").matches.empty());
}

TEST_F(MatchListFile, FaultsAreNamedByLineColumnAndValue) {
  const std::string names = "x_left,y_left,x_right,y_right";
  const struct {
    std::string text, expected;
  } cases[] = {
      {"", "is empty; its first line must name the columns, e.g. x_left,y_left,x_right,y_right,label"},
      {"1,2,3,4\n", "line 1: '1' is not a column of a match list; the first line names the columns"},
      {"x_left y_left x_right y_right\n1 2 3 4\n", "line 1: 'x_left y_left x_right y_right' is not a column"},
      {names + ",lable\n", "line 1: 'lable' is not a column"},
      {"x_left,y_left,x_right\n", "line 1: the column 'y_right' is missing"},
      {names + ",x_left\n", "line 1: the column 'x_left' stands there twice"},
      {names + "\n1,2,3,4\n1,2,3\n", "line 3: has 3 values, the first line names 4 columns"},
      {names + "\n1,2,3,4\n\n1,2,abc,4\n", "line 4: column 'x_right': 'abc' is not a number"},
      {names + "\n1,,3,4\n", "line 2: column 'y_left': '' is not a number"},
      {names + "\n1,nan,3,4\n", "line 2: column 'y_left': 'nan' is not a number"},
      {names + "\n1,2,3,inf\n", "line 2: column 'y_right': 'inf' is not a coordinate or an angle"},
      {names + ",label\n1,2,3,4,0.5\n", "line 2: column 'label': '0.5' is not a whole number from 0"},
      {names + ",label\n1,2,3,4,-1\n", "line 2: column 'label': '-1' is not a whole number from 0"},
      {names + ",distance\n1,2,3,4,-1\n", "line 2: column 'distance': '-1' is not a finite number from 0"},
      {names + ",match_probability\n1,2,3,4,1.5\n",
       "line 2: column 'match_probability': '1.5' is not a probability from 0 to 1"},
      {names + ",match_probability\n1,2,3,4,-1\n", "'-1' is not a probability from 0 to 1"},
      {names + ",ratio,second_distance\n", "the columns 'ratio' and 'second_distance' state the same"},
      {names + ",second_distance\n", "the column 'second_distance' needs the column 'distance'"},
      {names + ",ratio,distance\n1,2,3,4,0,5\n", "match 1 has the ratio 0 and the distance 5"},
      {names + ",size_left,angle_left,size_right\n",
       "size_left, angle_left, size_right, angle_right are used together, but angle_right is missing"},
      {names + ",index_left\n", "index_left, index_right are used together, but index_right is missing"},
  };
  for (const auto& c : cases) {
    const std::string error = errorFor(c.text);
    EXPECT_TRUE(contains(error, path("matches.csv") + ": ")) << error;
    EXPECT_TRUE(contains(error, c.expected)) << error << "\nexpected: " << c.expected;
  }
}

}  // namespace
}  // namespace corrsel::core
