#include "features/parts/spread.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "points/cell_grid.h"

namespace corrsel::core {

namespace {
// More than one, so that the strength still matters within a cell of an evenly covered image.
constexpr double kPointsPerCell = 4;
}  // namespace

std::vector<std::size_t> spreadOverImage(const std::vector<cv::Point2f>& points, const cv::Size& size,
                                         std::size_t max_points) {
  const double area = static_cast<double>(size.width) * size.height;
  const double side = std::max(1.0, std::sqrt(area * kPointsPerCell / static_cast<double>(max_points)));
  const CellGrid grid = CellGrid::covering(0, 0, size.width, size.height, side);
  std::vector<int> count(grid.cells(), 0);
  std::vector<std::pair<int, std::size_t>> order;  // round, rank
  order.reserve(points.size());
  for (std::size_t rank = 0; rank < points.size(); ++rank)
    order.emplace_back(count[grid.cell(points[rank].x, points[rank].y)]++, rank);
  std::sort(order.begin(), order.end());
  order.resize(std::min(max_points, order.size()));
  std::vector<std::size_t> ranks;
  ranks.reserve(order.size());
  for (const auto& entry : order) ranks.push_back(entry.second);
  std::sort(ranks.begin(), ranks.end());
  return ranks;
}

}  // namespace corrsel::core
