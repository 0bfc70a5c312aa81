#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// A keypoint of an image.
struct TrackObservation {
  std::uint32_t image = 0;     ///< number of the image
  std::uint32_t keypoint = 0;  ///< number of its row in the image
};

inline bool operator==(const TrackObservation& a, const TrackObservation& b) {
  return a.image == b.image && a.keypoint == b.keypoint;
}

/// Sets of keypoints, each of them the images of one point of the scene.
struct Tracks {
  /// The keypoints, track after track. Within a track they are in the order of the images, of which each
  /// occurs once. Tracks are in the order of their first keypoint (image, then row).
  std::vector<TrackObservation> observations;
  /// Where each track begins in `observations`, and at the end their number.
  std::vector<std::size_t> begin = {0};
  std::size_t matches = 0;  ///< verified matches that were given
  /// Of these, matches that are in no track, because they would have put two keypoints of one image into it.
  std::size_t cut = 0;

  std::size_t size() const { return begin.size() - 1; }
};

/// Numbers about tracks, for reports.
struct TrackStatistics {
  std::size_t tracks = 0;
  std::size_t observations = 0;
  std::size_t matches = 0, cut = 0;  ///< see Tracks
  double mean_length = 0;            ///< observations per track; NaN without tracks
  /// lengths[k] is the number of tracks with k observations, from 0 to the longest one.
  std::vector<std::size_t> lengths;
  /// The images that have observations, in ascending order, and how many they have.
  std::vector<std::pair<std::uint32_t, std::size_t>> per_image;
};

/// Joins the verified matches of many pairs to tracks.
///
/// Idea: A match says that two keypoints show one point. Wrong matches chain different points together, which
/// shows where a track holds two keypoints of one image, as no point has two images there.
///
/// Algorithm: The tracks are the connected components of the graph of keypoints and matches, without the
/// matches that would make a conflict. The pairs are taken by falling confidence, and equal ones in the order
/// of their numbers. A match that joins two parts with keypoints of one image is cut (Kruskal's rule). What
/// is cut is therefore the least confident place: all matches that hold the two parts together by themselves
/// are at least as confident as the match between them. A pair whose confidence is not known comes last.
///
/// Input: Pairs with config `watermark` are left out. The order of the pairs and of their inliers does not
/// matter. Leave out pairs that the cycles accuse (cycles.h) before the call.
///
/// Cost: O(M log K) for M matches of K keypoints, and O(length) for every join. Memory of 12 bytes for every
/// keypoint up to the last matched one of each image, 16 for every pair, and 8 for every observation, but
/// nothing for a match: each pair is read twice, and the keypoints of each image once. For 20000 images of
/// 5000 keypoints and a million pairs these are 1.2 GB, and 0.8 GB more for the tracks if all keypoints are
/// in one.
/// @param pairs       with a stored verification, each of them once
/// @param min_length  tracks with fewer observations are left out; at least 2
/// Throws std::invalid_argument for a pair that is listed twice and a smaller min_length, and StoreError,
/// also where a match names a keypoint that its image does not have.
Tracks buildTracks(const PairStore& store, const std::vector<ImagePairKey>& pairs,
                   std::size_t min_length = 2);

/// The same for pairs in memory.
Tracks buildTracks(const std::vector<VerifiedPair>& pairs, std::size_t min_length = 2);

/// O(observations).
TrackStatistics trackStatistics(const Tracks& tracks);

/// Writes the tracks as a CSV file with the columns track (from 0), image (number), name (of the image),
/// keypoint (row, from 0), x, y (px, centre of the first pixel at (0, 0)). The rows are in the order of
/// `tracks`. An incomplete file is called like the file with ".part" appended.
/// Cost: O(observations), and 8 bytes of memory for each.
/// @param store  with the images and keypoints
/// Throws StoreError where the file cannot be written, and where the store lacks an image or keypoint.
void writeTracks(const std::filesystem::path& path, const Tracks& tracks, const PairStore& store);

/// The text by which stores know that writeTrackMatches() has written a pair.
/// @param configuration  that of the verification
std::string trackConfiguration(const std::string& configuration);

/// Rewrites verified pairs so that only the inliers remain whose keypoints share a track. Pairs that keep
/// none become `undefined`. Apply it to a copy of the database.
///
/// This is what COLMAP's point_triangulator needs. It takes the poses from a model (--input_path), ignores
/// the matrices, and follows the inliers of two_view_geometries from image to image by itself. Of the
/// rewritten rows none leads from one track to another, so that every point stays within a track. Pairs with
/// fewer than 15 inliers are not read.
///
/// Cost: O(matches), and memory of 4 bytes for every keypoint as in buildTracks().
/// @param pairs          those that buildTracks() was given, and those that were left out
/// @param configuration  that of the verification
/// Throws StoreError; what was written before remains.
void writeTrackMatches(PairStore& store, const Tracks& tracks, const std::vector<ImagePairKey>& pairs,
                       const std::string& configuration);

}  // namespace corrsel::core
