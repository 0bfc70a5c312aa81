#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/database/pair_store.h"
#include "corrsel/random.h"

namespace corrsel::core::testing {

/// A store in memory that counts what is asked of it.
class MemoryStore : public PairStore {
 public:
  std::vector<StoredImage> stored_images;
  std::map<std::uint32_t, StoredKeypoints> stored_keypoints;
  std::map<ImagePairKey, StoredMatches> stored_matches;
  std::map<ImagePairKey, VerifiedPair> results;
  std::map<ImagePairKey, std::string> configurations;
  std::vector<std::size_t> transactions;  ///< pairs of each
  std::vector<ImagePairKey> order;        ///< in which results were written
  std::set<std::uint32_t> broken_images;
  std::set<ImagePairKey> broken_pairs;
  std::size_t full_after = SIZE_MAX;  ///< transactions until the disk is full
  mutable std::size_t keypoint_reads = 0, match_reads = 0, most_unwritten = 0;

  const std::vector<StoredImage>& images() const override { return stored_images; }

  std::vector<ImagePairKey> pairs() const override {
    std::vector<ImagePairKey> keys;
    for (const auto& [pair, rows] : stored_matches) keys.push_back(pair);
    return keys;
  }

  StoredKeypoints keypoints(std::uint32_t image) const override {
    ++keypoint_reads;
    if (broken_images.count(image) > 0) {
      throw StoreError(StoreError::Kind::kContent, "keypoints of image " + std::to_string(image));
    }
    return stored_keypoints.at(image);
  }

  StoredMatches matches(const ImagePairKey& pair) const override {
    ++match_reads;
    most_unwritten = std::max(most_unwritten, match_reads - order.size());
    if (broken_pairs.count(pair) > 0) throw StoreError(StoreError::Kind::kContent, "matches of the pair");
    const auto found = stored_matches.find(pair);
    if (found == stored_matches.end()) throw StoreError(StoreError::Kind::kContent, "no matches of the pair");
    return found->second;
  }

  std::vector<ImagePairKey> verifiedPairs(const std::string& configuration) const override {
    std::vector<ImagePairKey> keys;
    for (const auto& [pair, text] : configurations) {
      if (text == configuration) keys.push_back(pair);
    }
    return keys;
  }

  VerifiedPair verified(const ImagePairKey& pair) const override { return results.at(pair); }

  void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) override {
    if (transactions.size() >= full_after) throw StoreError(StoreError::Kind::kStorage, "the disk is full");
    transactions.push_back(pairs.size());
    for (const VerifiedPair& pair : pairs) {
      results[pair.pair] = pair;
      configurations[pair.pair] = configuration;
      order.push_back(pair.pair);
    }
  }
};

/// Images of two places, whose points all images of a place show, with the matches of every pair: true ones
/// and random ones where both show one place, else random ones.
inline MemoryStore twoPlaces(int images_of_place = 5, int points = 90) {
  MemoryStore store;
  Random random(7);
  std::vector<std::vector<cv::Point3d>> places(2);
  for (std::vector<cv::Point3d>& place : places) {
    for (int k = 0; k < points; ++k) {
      const double x = random.uniform(-2, 2), y = random.uniform(-2, 2), z = random.uniform(8, 14);
      place.emplace_back(x, y, z);
    }
  }
  for (int i = 0; i < 2 * images_of_place; ++i) {
    const auto id = static_cast<std::uint32_t>(i + 1);
    store.stored_images.push_back(
        {id, "image" + std::to_string(id) + ".jpg", cv::Size(1200, 800), std::nullopt, false});
    for (const cv::Point3d& point : places[static_cast<std::size_t>(i % 2)]) {
      const double x = point.x + 0.15 * (i - 5), noise_x = 0.3 * random.normal(),
                   noise_y = 0.3 * random.normal();
      store.stored_keypoints[id].positions.emplace_back(
          static_cast<float>(600 + 1000 * x / point.z + noise_x),
          static_cast<float>(400 + 1000 * point.y / point.z + noise_y));
    }
  }
  const auto count = static_cast<std::uint32_t>(2 * images_of_place);
  for (std::uint32_t a = 1; a <= count; ++a) {
    for (std::uint32_t b = a + 1; b <= count; ++b) {
      StoredMatches& matches = store.stored_matches[{a, b}];
      const bool same_place = (a + b) % 2 == 0;
      for (int k = 0; k < (same_place ? points : points / 3); ++k) {
        const auto row = static_cast<std::uint32_t>(k);
        const bool right = same_place && k % 3 > 0;
        const std::uint32_t other = random.index(static_cast<std::uint32_t>(points));
        matches.rows.push_back({row, right ? row : other});
      }
    }
  }
  return store;
}

}  // namespace corrsel::core::testing
