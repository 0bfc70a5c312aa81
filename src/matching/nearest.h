#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// Nearest and second nearest train of every query, and where asked the nearest query of every train.
struct Neighbours {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> train;    ///< per query: row of the nearest train, or kNone
  std::vector<float> distance;         ///< per query; NaN where there is none
  std::vector<float> second_distance;  ///< per query; NaN where there is none
  std::vector<std::uint32_t> query;    ///< per train: row of the nearest query, or kNone; empty if not asked
};

struct NeighbourSearch {
  int threads = 1;             ///< at least 1; changes nothing but the time
  bool nearest_query = false;  ///< fill Neighbours::query
  /// Where above 0: the second is the nearest of the trains at least so far from the nearest one, px.
  double second_radius = 0;
  const std::vector<cv::KeyPoint>* train_keypoints = nullptr;  ///< needed where second_radius > 0
};

/// Exact two nearest neighbours by comparing all with all. CV_32F: L2 distance, the float square root of
/// sum (q - t)^2, added up in float in the order of the columns. CV_8U: Hamming distance. Equal distances go
/// to the lowest row. A row that holds NaN has no neighbour and is nobody's; neither are rows at an infinite
/// distance.
///
/// Where all values are whole numbers from 0 to 255 and no sum can exceed 2^24, as with SIFT of OpenCV and
/// VLFeat, products of integers give the same distances in less time.
///
/// @param queries, trains  one row per descriptor
/// @pre both are CV_32F or both are CV_8U, with as many columns
/// O(queries * trains * columns) time, memory of the order of the descriptors.
Neighbours findNeighbours(const cv::Mat& queries, const cv::Mat& trains, const NeighbourSearch& search = {});

}  // namespace corrsel::core
