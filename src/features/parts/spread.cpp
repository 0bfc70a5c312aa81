#include "features/parts/spread.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace corrsel::core {

namespace {
// More than one, so that the strength still matters within a cell of an evenly covered image.
constexpr double kPointsPerCell = 4;
}  // namespace

std::vector<std::size_t> spreadOverImage(const std::vector<cv::Point2f>& points, const cv::Size& size,
                                         std::size_t most) {
  const double area = static_cast<double>(size.width) * size.height;
  const double side = std::max(1.0, std::sqrt(area * kPointsPerCell / static_cast<double>(most)));
  const int columns = static_cast<int>(size.width / side) + 1,
            rows = static_cast<int>(size.height / side) + 1;
  std::vector<int> count(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  std::vector<std::pair<int, std::size_t>> order;  // round, rank
  order.reserve(points.size());
  for (std::size_t rank = 0; rank < points.size(); ++rank) {
    const int x = std::clamp(static_cast<int>(points[rank].x / side), 0, columns - 1);
    const int y = std::clamp(static_cast<int>(points[rank].y / side), 0, rows - 1);
    order.emplace_back(count[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                             static_cast<std::size_t>(x)]++,
                       rank);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(most, order.size()));
  std::vector<std::size_t> ranks;
  ranks.reserve(order.size());
  for (const auto& entry : order) ranks.push_back(entry.second);
  std::sort(ranks.begin(), ranks.end());
  return ranks;
}

}  // namespace corrsel::core
