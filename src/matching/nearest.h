#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// Nearest neighbours between two sets of descriptors, called queries and trains as in OpenCV.
struct Neighbours {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> train;    ///< per query: row of the nearest train, or kNone
  std::vector<float> distance;         ///< per query; NaN where there is none
  std::vector<float> second_distance;  ///< per query; NaN where there is none
  std::vector<std::uint32_t>
      query;  ///< per train: row of the nearest query, or kNone; empty unless requested
};

struct NeighbourSearch {
  /// What the bytes of CV_8U descriptors are.
  enum class Bytes : std::uint8_t {
    kBits,    ///< compared by the Hamming distance
    kNumbers  ///< compared by the L2 distance, as the same numbers in CV_32F are
  };

  int threads = 1;             ///< at least 1; the result does not depend on it
  bool nearest_query = false;  ///< fill Neighbours::query
  Bytes bytes = Bytes::kBits;
  /// Where above 0, the second neighbour is the nearest of the trains whose keypoints are at least this far
  /// from that of the nearest train, px.
  double second_radius = 0;
  const std::vector<cv::KeyPoint>* train_keypoints = nullptr;  ///< needed where second_radius > 0
  /// Where below 1, queries whose distance is at least this part of the second one have no neighbour, and
  /// second_distance is not filled. This takes about half the time.
  /// @pre neither nearest_query nor second_radius is used with it
  double ratio = 1;
};

/// The two nearest trains of every query.
///
/// Idea: Comparing all pairs is exact, and with kernels for the processor's vector instructions it is fast
/// enough for thousands of features.
///
/// Algorithm: CV_32F: L2 distance, the float square root of sum (q - t)^2, added up in float in the order of
/// the columns. CV_8U: NeighbourSearch::bytes. Equal distances are resolved by the lowest row. Where all
/// float values are whole numbers from 0 to 255 and no sum can exceed 2^24, as with SIFT, products of
/// integers give the same distances in less time; see kernels/descriptor_kernels.h.
///
/// Input: One row per descriptor. @pre Both are CV_32F or both are CV_8U, with the same number of columns.
///
/// Options: NeighbourSearch.
///
/// Failure: A row that contains NaN has no neighbour and is nobody's neighbour. The same holds for rows at an
/// infinite distance.
///
/// Cost: O(queries * trains * columns) time and memory of the order of the descriptors.
Neighbours findNeighbours(const cv::Mat& queries, const cv::Mat& trains, const NeighbourSearch& search = {});

/// Queries that have the same candidates.
struct CandidateGroup {
  std::vector<std::uint32_t> queries;  ///< rows
  std::vector<std::uint32_t> trains;   ///< rows, ascending
};

/// findNeighbours() where every query is compared with its candidates only. Queries that are in no group have
/// no neighbour.
/// @param groups      no query is in two of them
/// @param background  trains that can be second neighbours of all queries, except where their keypoints are
///                    at the place of the nearest train
/// @param search      of the number of threads, nearest_query and second_radius. @pre train_keypoints is set
/// Cost: O(sum of queries * (trains + background) * columns) over all groups.
Neighbours findNeighboursAmong(const cv::Mat& queries, const cv::Mat& trains,
                               const std::vector<CandidateGroup>& groups,
                               const std::vector<std::uint32_t>& background, const NeighbourSearch& search);

}  // namespace corrsel::core
