#include "tracking/flow_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "points/cell_grid.h"

namespace corrsel::core {

std::vector<char> keepDistant(const std::vector<cv::Point2f>& points, const cv::Size& size,
                              double min_distance) {
  std::vector<char> keep(points.size(), 1);
  if (!(min_distance > 0)) return keep;
  // Smaller cells would not be faster, and would need more memory than the image.
  const CellGrid grid = CellGrid::covering(0, 0, size.width, size.height, std::max(min_distance, 4.0));
  std::vector<int> last(grid.cells(), -1),
      before(points.size(), -1);  // lists of the kept points of each cell
  const auto isClose = [&](const cv::Point2f& p, int row, int column) {
    for (int i = last[grid.number(column, row)]; i >= 0; i = before[static_cast<std::size_t>(i)]) {
      const cv::Point2f apart = points[static_cast<std::size_t>(i)] - p;
      if (apart.dot(apart) < min_distance * min_distance) return true;
    }
    return false;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int column = grid.column(points[i].x), row = grid.row(points[i].y);
    for (int y = std::max(0, row - 1); y <= std::min(grid.rows - 1, row + 1) && keep[i] != 0; ++y) {
      for (int x = std::max(0, column - 1); x <= std::min(grid.columns - 1, column + 1); ++x) {
        if (isClose(points[i], y, x)) keep[i] = 0;
      }
    }
    if (keep[i] == 0) continue;
    before[i] = std::exchange(last[grid.number(column, row)], static_cast<int>(i));
  }
  return keep;
}

std::vector<std::size_t> chooseNew(const std::vector<cv::Point2f>& candidates,
                                   const std::vector<cv::Point2f>& points, const cv::Size& size,
                                   std::size_t max_points) {
  if (points.size() >= max_points) return {};
  const double pixels = static_cast<double>(size.width) * size.height;
  const double side = std::sqrt(pixels / (static_cast<double>(max_points) / 4 + 1));
  const CellGrid grid = CellGrid::covering(0, 0, size.width, size.height, std::max(side, 1.0));
  std::vector<int> counts(grid.cells(), 0);
  for (const cv::Point2f& point : points) ++counts[grid.cell(point.x, point.y)];
  std::vector<std::pair<int, std::size_t>> ranked(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    ranked[i] = {counts[grid.cell(candidates[i].x, candidates[i].y)]++, i};
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::size_t> chosen(std::min(candidates.size(), max_points - points.size()));
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = ranked[i].second;
  return chosen;
}

}  // namespace corrsel::core
