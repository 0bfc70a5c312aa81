#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "corrsel/matching/match_drawing.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using Mask = std::vector<std::uint8_t>;

/// n horizontal matches, 6 rows apart, from column 30 to column 50 of the other image.
Correspondences rungs(std::size_t n) {
  Correspondences m;
  for (std::size_t i = 0; i < n; ++i) m.add({30, float(6 * i + 10)}, {50, float(6 * i + 10)});
  return m;
}

cv::Mat black(int columns, int rows, int type = CV_8U) {
  return cv::Mat(rows, columns, type, cv::Scalar::all(0));
}

const cv::Vec3b kGround(60, 60, 60);

/// Class of the line at a pixel by its colour, which the smooth drawing of lines changes a little.
std::string classAt(const cv::Mat& drawing, int row, int column) {
  const MatchColours colours;
  const std::pair<const char*, cv::Scalar> classes[] = {{"correct", colours.correct},
                                                        {"wrong", colours.wrong},
                                                        {"missed", colours.missed},
                                                        {"selected", colours.selected},
                                                        {"nothing", {60, 60, 60}}};
  const cv::Vec3b pixel = drawing.at<cv::Vec3b>(row, column);
  for (const auto& [name, colour] : classes) {
    if (cv::norm(cv::Vec3d(pixel[0] - colour[0], pixel[1] - colour[1], pixel[2] - colour[2])) < 30)
      return name;
  }
  return "other";
}

/// The class of rung i, read in its middle: at the last column of a left image of width 100.
std::string classOf(const cv::Mat& drawing, std::size_t i) { return classAt(drawing, int(6 * i + 10), 99); }

TEST(MatchDrawing, PutsPaleImagesSideBySide) {
  cv::Mat left(40, 100, CV_8U, cv::Scalar(200)), right(60, 70, CV_8UC3, cv::Scalar(100, 50, 0));
  const cv::Mat drawing = drawMatches(left, right, {}, {}, {}, 5);
  ASSERT_EQ(drawing.size(), cv::Size(170, 60));
  ASSERT_EQ(drawing.type(), CV_8UC3);
  EXPECT_EQ(drawing.at<cv::Vec3b>(39, 99), cv::Vec3b(180, 180, 180));
  EXPECT_EQ(drawing.at<cv::Vec3b>(40, 99), cv::Vec3b(0, 0, 0));  // below the smaller image
  EXPECT_EQ(drawing.at<cv::Vec3b>(59, 100), cv::Vec3b(120, 90, 60));
  EXPECT_EQ(drawing.at<cv::Vec3b>(0, 169), cv::Vec3b(120, 90, 60));
  EXPECT_EQ(left.at<uchar>(0, 0), 200);
  EXPECT_EQ(drawMatches(black(5, 5, CV_8UC4), black(5, 5), {}, {}, {}, 5).at<cv::Vec3b>(2, 2), kGround);
}

TEST(MatchDrawing, ColoursTellTheClasses) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  // Selected: right (at the tolerance itself), wrong, infinitely wrong, unknown; rejected: right, wrong,
  // unknown.
  const Mask mask = {1, 1, 1, 1, 0, 0, 0};
  const std::vector<double> errors = {5, 5.01, inf, nan, 0, 9, nan};
  const cv::Mat drawing = drawMatches(black(100, 80), black(100, 80), rungs(7), mask, errors, 5);
  const std::vector<std::string> expected = {"correct", "wrong",   "wrong",  "selected",
                                             "missed",  "nothing", "nothing"};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(classOf(drawing, i), expected[i]) << i;
  // The line ends at the points; the right one is moved by the width of the left image.
  EXPECT_EQ(classAt(drawing, 10, 20), "nothing");
  EXPECT_EQ(classAt(drawing, 10, 40), "correct");
  EXPECT_EQ(classAt(drawing, 10, 145), "correct");
  EXPECT_EQ(classAt(drawing, 10, 160), "nothing");
}

TEST(MatchDrawing, UnknownTruthHasItsColour) {
  const cv::Mat drawing = drawMatches(black(100, 80), black(100, 80), rungs(3), {1, 0, 1}, {}, 5);
  EXPECT_EQ(classOf(drawing, 0), "selected");
  EXPECT_EQ(classOf(drawing, 1), "nothing");
  EXPECT_EQ(classOf(drawing, 2), "selected");
}

TEST(MatchDrawing, GroupsHaveTheirColours) {
  const auto near = [](const cv::Mat& drawing, int row, int column, const cv::Scalar& colour) {
    const cv::Vec3b p = drawing.at<cv::Vec3b>(row, column);
    return cv::norm(cv::Vec3d(p[0] - colour[0], p[1] - colour[1], p[2] - colour[2])) < 30;
  };
  const std::vector<std::int32_t> group = {1, -1, 6, 2};
  // The truth is unknown: lines have the colour of the group, which is used again after five.
  const cv::Mat unknown =
      drawMatches(black(100, 80), black(100, 80), rungs(4), {1, 1, 1, 1}, {}, 5, 200, group);
  EXPECT_TRUE(near(unknown, 10, 99, groupColour(1)));
  EXPECT_EQ(classOf(unknown, 1), "selected");
  EXPECT_TRUE(near(unknown, 22, 99, groupColour(1)));
  EXPECT_TRUE(near(unknown, 28, 99, groupColour(2)));
  // The truth is known: lines show it, and discs at the points show the group.
  const cv::Mat known =
      drawMatches(black(100, 80), black(100, 80), rungs(4), {1, 1, 1, 1}, {0, 0, 9, 9}, 5, 200, group);
  EXPECT_EQ(classOf(known, 0), "correct");
  EXPECT_EQ(classOf(known, 3), "wrong");
  EXPECT_TRUE(near(known, 10, 30, groupColour(1)));
  EXPECT_TRUE(near(known, 10, 150, groupColour(1)));
  EXPECT_TRUE(near(known, 28, 30, groupColour(2)));
  // An outlier, whose line is drawn later, does not cover a point of a group.
  Correspondences crossing;
  crossing.add({30, 40}, {50, 40});
  crossing.add({30, 20}, {30, 60});
  crossing.add({10, 40}, {90, 40});
  const cv::Mat drawing =
      drawMatches(black(100, 80), black(100, 80), crossing, {1, 1, 1}, {0, 9, 9}, 5, 200, {0, 0, -1});
  EXPECT_EQ(classAt(drawing, 40, 20), "wrong");
  EXPECT_TRUE(near(drawing, 40, 30, groupColour(0)));
}

TEST(MatchDrawing, ThinsEveryClassEvenly) {
  for (const std::size_t max_lines : {0, 1, 3, 7, 10, 49, 60, 99, 100, 200}) {
    // 100 right ones and 60 missed ones.
    Mask mask(160, 1);
    std::fill(mask.begin() + 100, mask.end(), 0);
    const cv::Mat drawing = drawMatches(black(100, 1000), black(100, 1000), rungs(160), mask,
                                        std::vector<double>(160, 0.0), 5, max_lines);
    std::vector<std::size_t> correct, missed;
    for (std::size_t i = 0; i < 160; ++i) {
      if (classOf(drawing, i) == "correct") correct.push_back(i);
      if (classOf(drawing, i) == "missed") missed.push_back(i);
    }
    EXPECT_EQ(correct.size(), std::min<std::size_t>(max_lines, 100)) << max_lines;
    EXPECT_EQ(missed.size(), std::min<std::size_t>(max_lines, 60)) << max_lines;
    for (std::size_t k = 1; k < correct.size(); ++k) {
      EXPECT_LE(double(correct[k] - correct[k - 1]), std::ceil(100.0 / double(max_lines)));
    }
  }
}

TEST(MatchDrawing, LeavesOutWhatCannotBeDrawn) {
  Correspondences m = rungs(4);
  m.left_x[0] = std::numeric_limits<float>::quiet_NaN();
  m.right_y[1] = std::numeric_limits<float>::infinity();
  m.right_x[2] = 1e9f;
  const cv::Mat drawing =
      drawMatches(black(100, 80), black(100, 80), m, Mask(4, 1), std::vector<double>(4, 0.0), 5);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(classOf(drawing, i), "nothing");
  EXPECT_EQ(classOf(drawing, 3), "correct");
  // Points outside the image are fine.
  m = rungs(1);
  m.left_x[0] = -20000;
  EXPECT_EQ(classOf(drawMatches(black(100, 80), black(100, 80), m, {1}, {0}, 5), 0), "correct");
}

TEST(MatchDrawing, WithoutImagesTheMatchesGiveTheSize) {
  Correspondences m = rungs(3);
  m.left_size = {80, 100};
  m.right_size = {60, 50};
  const cv::Mat drawing = drawMatches({}, {}, m, {1, 1, 1}, {}, 5);
  EXPECT_EQ(drawing.size(), cv::Size(140, 100));
  m.left_size = m.right_size = {};
  const cv::Mat reached = drawMatches({}, {}, m, {1, 1, 1}, {}, 5);
  const auto width = [](const std::vector<float>& x) {
    return cvCeil(*std::max_element(x.begin(), x.end())) + 1;
  };
  EXPECT_EQ(reached.cols, width(m.left_x) + width(m.right_x));
  EXPECT_EQ(reached.rows, std::max(width(m.left_y), width(m.right_y)));
  EXPECT_FALSE(drawMatches({}, {}, {}, {}, {}, 5).empty());
}

/// A selection of the first `kept` of the matches.
Selection firstOnes(const Correspondences& matches, std::size_t kept) {
  Selection selection;
  selection.mask.assign(matches.size(), 0);
  std::fill(selection.mask.begin(), selection.mask.begin() + static_cast<std::ptrdiff_t>(kept),
            std::uint8_t{1});
  selection.n_selected = kept;
  return selection;
}

double distance(const cv::Vec3b& pixel, const cv::Scalar& colour) {
  return cv::norm(cv::Vec3d(pixel[0] - colour[0], pixel[1] - colour[1], pixel[2] - colour[2]));
}

/// The number of pixels of a part of a picture that have nearly this colour.
int countOf(const cv::Mat& part, const cv::Scalar& colour) {
  int count = 0;
  for (int y = 0; y < part.rows; ++y) {
    for (int x = 0; x < part.cols; ++x) count += distance(part.at<cv::Vec3b>(y, x), colour) < 30 ? 1 : 0;
  }
  return count;
}

SelectionDrawingOptions unscaled() {
  SelectionDrawingOptions options;
  options.width = 0;
  return options;
}

TEST(SelectionDrawing, KeptMatchesAreBrightAndRejectedOnesDark) {
  const Correspondences m = rungs(10);
  const cv::Mat grey(80, 100, CV_8U, cv::Scalar(150));
  const cv::Mat picture = drawSelection(grey, grey, m, firstOnes(m, 5), unscaled());
  ASSERT_EQ(picture.type(), CV_8UC3);
  EXPECT_EQ(picture.cols, 202);  // with a gap
  EXPECT_GT(picture.rows, 80);   // with a caption
  const cv::Vec3b ground = picture.at<cv::Vec3b>(75, 5);
  EXPECT_EQ(ground, cv::Vec3b(135, 135, 135));
  for (int i = 0; i < 10; ++i) {
    const int row = 6 * i + 10;
    const cv::Vec3b line = picture.at<cv::Vec3b>(row, 80), left = picture.at<cv::Vec3b>(row, 30),
                    right = picture.at<cv::Vec3b>(row, 152);
    if (i < 5) {  // lines are transparent, discs are not
      EXPECT_GT(int(line[2]), int(ground[2]) + 30) << i;
      EXPECT_LT(int(line[0]), int(ground[0])) << i;
      EXPECT_LT(distance(left, selectionColour(0)), 30) << i;
      EXPECT_LT(distance(right, selectionColour(0)), 30) << i;
    } else {
      EXPECT_LT(int(line[2]), int(ground[2]) - 15) << i;
      EXPECT_LT(int(left[2]), 100) << i;
      EXPECT_LT(int(right[2]), 100) << i;
      EXPECT_EQ(left[0], left[2]) << i;
    }
  }
}

TEST(SelectionDrawing, GroupsHaveTheirColoursInThePictureAndInTheCaption) {
  const Correspondences m = rungs(10);
  Selection selection = firstOnes(m, 8);
  selection.group = {0, 0, 1, 1, 2, 2, -1, -1, -1, -1};
  const cv::Mat picture = drawSelection(black(100, 80), black(100, 80), m, selection, unscaled());
  for (int i = 0; i < 8; ++i) {
    const cv::Scalar colour = selectionColour(selection.group[std::size_t(i)]);
    EXPECT_LT(distance(picture.at<cv::Vec3b>(6 * i + 10, 30), colour), 30) << i;
  }
  const cv::Mat caption = picture.rowRange(82, picture.rows);
  for (const int group : {0, 1, 2, -1}) EXPECT_GT(countOf(caption, selectionColour(group)), 5) << group;
  EXPECT_EQ(countOf(caption, selectionColour(3)), 0);
  for (int group = 1; group < 7; ++group) {
    EXPECT_GT(cv::norm(selectionColour(group) - selectionColour(group - 1)), 50);
    EXPECT_EQ(selectionColour(group + 7), selectionColour(group));
  }
}

TEST(SelectionDrawing, MovingGroupsHaveAColourOfTheirOwn) {
  const Correspondences m = rungs(8);
  Selection selection = firstOnes(m, 8);
  selection.group = {0, 1, 2, 3, 4, 5, 6, 7};
  selection.motion.assign(8, GroupMotion::kStatic);
  selection.motion[1] = selection.motion[4] = GroupMotion::kMoving;
  selection.motion[2] = GroupMotion::kUnknown;
  const cv::Scalar moving = MatchColours().moving;
  const cv::Mat picture = drawSelection(black(100, 80), black(100, 80), m, selection, unscaled());
  const cv::Mat matches = drawMatches(black(100, 80), black(100, 80), m, selection.mask, {}, 5, 200,
                                      selection.group, selection.motion);
  for (int i = 0; i < 8; ++i) {
    const bool moves = selection.motion[std::size_t(i)] == GroupMotion::kMoving;
    EXPECT_EQ(distance(picture.at<cv::Vec3b>(6 * i + 10, 30), moving) < 30, moves) << i;
    EXPECT_EQ(distance(matches.at<cv::Vec3b>(6 * i + 10, 30), moving) < 30, moves) << i;
    EXPECT_EQ(distance(matches.at<cv::Vec3b>(6 * i + 10, 99), moving) < 30, moves) << i;
  }
  EXPECT_GT(countOf(picture.rowRange(82, picture.rows), moving), 5);  // the legend
  EXPECT_EQ(inWords(GroupMotion::kMoving), "moving");
}

TEST(SelectionDrawing, LargeImagesAreReducedSmallOnesEnlargedFlatOnesStacked) {
  const Correspondences m = rungs(2);
  SelectionDrawingOptions options;
  options.width = 400;
  const auto width = [&](int left, int right, int rows) {
    return drawSelection(black(left, rows), black(right, rows), m, firstOnes(m, 1), options).cols;
  };
  EXPECT_NEAR(width(1000, 600, 800), 400, 1);
  EXPECT_NEAR(width(150, 150, 100), 400, 1);
  EXPECT_NEAR(width(50, 50, 60), 202, 1);  // enlarged twice
  const cv::Mat flat = drawSelection(black(800, 100), black(800, 100), m, firstOnes(m, 1), options);
  EXPECT_EQ(flat.cols, 400);
  EXPECT_GT(flat.rows, 100);
  // The match lies in the middle of both of them: (30, 10) above and (50, 10) below, both halved.
  EXPECT_LT(distance(flat.at<cv::Vec3b>(5, 15), selectionColour(0)), 60);
  EXPECT_LT(distance(flat.at<cv::Vec3b>(50 + 2 + 5, 25), selectionColour(0)), 60);
}

TEST(SelectionDrawing, LinesAreThinnedButAllPointsAreDrawn) {
  const Correspondences m = rungs(100);
  SelectionDrawingOptions options = unscaled();
  const cv::Mat all = drawSelection(black(100, 620), black(100, 620), m, firstOnes(m, 100), options);
  options.max_lines = 10;
  const cv::Mat some = drawSelection(black(100, 620), black(100, 620), m, firstOnes(m, 100), options);
  const auto lines = [](const cv::Mat& picture) {
    int count = 0;
    for (int i = 0; i < 100; ++i) count += picture.at<cv::Vec3b>(6 * i + 10, 80)[2] > 100 ? 1 : 0;
    return count;
  };
  EXPECT_EQ(lines(all), 100);
  EXPECT_EQ(lines(some), 10);
  for (int i = 0; i < 100; ++i)
    EXPECT_LT(distance(some.at<cv::Vec3b>(6 * i + 10, 30), selectionColour(0)), 30) << i;
}

TEST(SelectionDrawing, ImagesOfEveryKindAndNone) {
  Correspondences m = rungs(3);
  m.left_size = m.right_size = {100, 80};
  const Selection selection = firstOnes(m, 2);
  const cv::Mat grey(80, 100, CV_8U, cv::Scalar(100));
  cv::Mat colour, deep, plain = drawSelection(grey, grey, m, selection);
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGRA);
  grey.convertTo(deep, CV_16U, 257);
  EXPECT_EQ(cv::norm(drawSelection(colour, deep, m, selection), plain, cv::NORM_INF), 0);
  EXPECT_EQ(drawSelection({}, {}, m, selection).size(), plain.size());
  EXPECT_FALSE(drawSelection({}, {}, {}, {}).empty());
  m.left_x[0] = std::numeric_limits<float>::quiet_NaN();
  m.right_y[1] = 1e9F;
  EXPECT_EQ(drawSelection(grey, grey, m, selection).size(), plain.size());
}

TEST(SelectionDrawing, WrongArgumentsAreNamed) {
  const Correspondences m = rungs(3);
  const auto refusal = [&](const Selection& selection, const SelectionDrawingOptions& options) {
    return testing::errorOf<std::invalid_argument>([&] { drawSelection({}, {}, m, selection, options); });
  };
  EXPECT_TRUE(testing::mentions(refusal(firstOnes(rungs(4), 2), {}), {"4 matches", "there are 3"}));
  Selection short_groups = firstOnes(m, 2);
  short_groups.group = {0};
  EXPECT_FALSE(refusal(short_groups, {}).empty());
  SelectionDrawingOptions options;
  options.width = -1;
  EXPECT_TRUE(testing::mentions(refusal(firstOnes(m, 2), options), {"width is -1", "valid"}));
}

}  // namespace
}  // namespace corrsel::core
