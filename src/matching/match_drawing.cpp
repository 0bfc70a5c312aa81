#include "corrsel/matching/match_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "matching/drawing_ground.h"

namespace corrsel::core {
namespace {

constexpr float kMaxCoordinate = 30000.0F;  // px

bool drawable(float value) { return std::abs(value) < kMaxCoordinate; }

}  // namespace

cv::Mat toColour(const cv::Mat& image) {
  cv::Mat colour;
  if (image.channels() == 1) {
    cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  } else if (image.channels() == 4) {
    cv::cvtColor(image, colour, cv::COLOR_BGRA2BGR);
  } else {
    colour = image;
  }
  return colour;
}

bool drawable(const Correspondences& matches, std::size_t row) {
  return drawable(matches.left_x[row]) && drawable(matches.left_y[row]) && drawable(matches.right_x[row]) &&
         drawable(matches.right_y[row]);
}

cv::Mat imageOrGround(const cv::Mat& image, cv::Size size, const std::vector<float>& x,
                      const std::vector<float>& y) {
  if (!image.empty()) return image;
  if (size.empty()) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!drawable(x[i]) || !drawable(y[i])) continue;
      size.width = std::max(size.width, cvCeil(x[i]) + 1);
      size.height = std::max(size.height, cvCeil(y[i]) + 1);
    }
  }
  return cv::Mat::zeros(std::max(size.height, 1), std::max(size.width, 1), CV_8UC1);
}

cv::Scalar groupColour(std::int32_t group) {
  static const cv::Scalar colours[] = {{66, 228, 240},   // yellow
                                       {233, 180, 86},   // sky blue
                                       {0, 159, 230},    // orange
                                       {167, 121, 204},  // reddish purple
                                       {255, 255, 255}};
  return colours[static_cast<std::size_t>(group) % std::size(colours)];
}

cv::Scalar colourOf(std::int32_t group, GroupMotion motion) {
  if (motion == GroupMotion::kMoving) return MatchColours().moving;
  constexpr std::int32_t kOthers[] = {0, 1, 2, 4};  // groupColour(3) is that of moving matches
  return groupColour(kOthers[static_cast<std::size_t>(group) % std::size(kOthers)]);
}

cv::Mat drawMatches(const cv::Mat& left_image, const cv::Mat& right_image, const Correspondences& matches,
                    const std::vector<std::uint8_t>& mask, const std::vector<double>& errors,
                    double tolerance, std::size_t max_lines, const std::vector<std::int32_t>& group,
                    const std::vector<GroupMotion>& motion) {
  const cv::Mat left = imageOrGround(left_image, matches.left_size, matches.left_x, matches.left_y);
  const cv::Mat right = imageOrGround(right_image, matches.right_size, matches.right_x, matches.right_y);
  const MatchColours colours;
  cv::Mat canvas(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, cv::Scalar::all(0));
  // The images are made paler, so that the lines stand out.
  toColour(left).convertTo(canvas(cv::Rect(0, 0, left.cols, left.rows)), CV_8U, 0.6, 60);
  toColour(right).convertTo(canvas(cv::Rect(left.cols, 0, right.cols, right.rows)), CV_8U, 0.6, 60);

  std::vector<std::size_t> missed, correct, wrong, unknown;
  for (std::size_t i = 0; i < mask.size() && i < matches.size(); ++i) {
    if (!drawable(matches, i)) continue;
    const bool known = i < errors.size() && !std::isnan(errors[i]);
    const bool right_match = known && errors[i] <= tolerance;
    if (mask[i]) {
      (!known ? unknown : right_match ? correct : wrong).push_back(i);
    } else if (right_match) {
      missed.push_back(i);
    }
  }
  const int thickness = std::max(1, canvas.cols / 1600);
  const auto is_grouped = [&group](std::size_t i) { return i < group.size() && group[i] >= 0; };
  const auto colour_of_group = [&](std::int32_t number) {
    const auto place = static_cast<std::size_t>(number);
    return place < motion.size() ? colourOf(number, motion[place]) : groupColour(number);
  };
  std::vector<std::pair<std::array<cv::Point, 2>, cv::Scalar>> discs;
  const auto draw = [&](const std::vector<std::size_t>& rows, const cv::Scalar& colour) {
    const std::size_t count = std::min(rows.size(), max_lines);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = rows[k * rows.size() / count];
      const cv::Point from(cvRound(matches.left_x[i]), cvRound(matches.left_y[i]));
      const cv::Point to(cvRound(matches.right_x[i]) + left.cols, cvRound(matches.right_y[i]));
      const bool line_of_group = is_grouped(i) && &rows == &unknown;
      cv::line(canvas, from, to, line_of_group ? colour_of_group(group[i]) : colour, thickness, cv::LINE_AA);
      if (is_grouped(i)) {
        discs.push_back({{from, to}, colour_of_group(group[i])});
        continue;
      }
      for (const cv::Point& point : {from, to})
        cv::circle(canvas, point, 2 * thickness, colour, thickness, cv::LINE_AA);
    }
  };
  draw(missed, colours.missed);
  draw(unknown, colours.selected);
  draw(correct, colours.correct);
  draw(wrong, colours.wrong);
  for (const auto& [points, colour] : discs) {  // last, because lines would cover them
    for (const cv::Point& point : points)
      cv::circle(canvas, point, 2 * thickness + 1, colour, cv::FILLED, cv::LINE_AA);
  }
  return canvas;
}

}  // namespace corrsel::core
