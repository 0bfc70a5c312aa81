#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// The nearest and second nearest train of every query and, on request, the nearest query of every train.
struct Neighbours {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> train;    ///< per query: row of the nearest train, or kNone
  std::vector<float> distance;         ///< per query; NaN if there is none
  std::vector<float> second_distance;  ///< per query; NaN where there is none
  std::vector<std::uint32_t> query;    ///< per train: row of the nearest query, or kNone; empty if not asked
};

struct NeighbourSearch {
  int threads = 1;             ///< at least 1; affects only the time
  bool nearest_query = false;  ///< fill Neighbours::query
  /// If above 0: the second neighbour is at least this far from the nearest one, px.
  double second_radius = 0;
  const std::vector<cv::KeyPoint>* train_keypoints = nullptr;  ///< needed if second_radius > 0
};

/// Finds the exact two nearest neighbours by comparing all descriptors with all.
///
/// Distance: for CV_32F it is the L2 distance, the float square root of sum (q - t)^2, added up in float in
/// the order of the columns. For CV_8U it is the Hamming distance. Among equal distances the lowest row wins.
/// A row that holds NaN neither has a neighbour nor is one; neighbours at an infinite distance do not count.
///
/// Algorithm: if all values are whole numbers from 0 to 255 and no sum can exceed 2^24, as with SIFT of
/// OpenCV and VLFeat, products of integers give the same distances in less time.
///
/// Cost: O(queries * trains * columns) time, and memory proportional to the descriptors.
///
/// @param queries, trains  one row per descriptor
/// @pre both are CV_32F or both are CV_8U, with the same number of columns
Neighbours findNeighbours(const cv::Mat& queries, const cv::Mat& trains, const NeighbourSearch& search = {});

}  // namespace corrsel::core
