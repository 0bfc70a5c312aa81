#include "corrsel/database/tracks.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <locale>
#include <map>
#include <stdexcept>
#include <system_error>

#include "base/text.h"
#include "database/track_forest.h"

namespace corrsel::core {
namespace {

/// Gives the verification of a pair to a function.
using ReadPair = std::function<void(std::size_t pair, const std::function<void(const VerifiedPair&)>& use)>;

std::string pairText(const ImagePairKey& pair) {
  return "(" + std::to_string(pair.first) + ", " + std::to_string(pair.second) + ")";
}

bool isUsed(const VerifiedPair& pair) {
  return !pair.faulty && pair.geometry.config != TwoViewConfig::kWatermark;
}

/// A pair in the order in which matches are joined.
struct RankedPair {
  double confidence;
  std::uint32_t number;
};

/// The pairs by falling confidence, then by their images. Makes room for their keypoints.
std::vector<RankedPair> rank(std::size_t pairs, const ReadPair& read, KeypointNumbers& numbers,
                             std::size_t& matches) {
  std::vector<RankedPair> ranked;
  std::vector<ImagePairKey> keys(pairs);
  ranked.reserve(pairs);
  for (std::size_t i = 0; i < pairs; ++i) {
    read(i, [&](const VerifiedPair& pair) {
      keys[i] = pair.pair;
      const double confidence = std::isnan(pair.confidence) ? -1 : pair.confidence;
      ranked.push_back({confidence, static_cast<std::uint32_t>(i)});
      if (!isUsed(pair)) return;
      for (const KeypointPair& row : pair.geometry.inliers) {
        numbers.include(pair.pair.first, row[0]);
        numbers.include(pair.pair.second, row[1]);
      }
      matches += pair.geometry.inliers.size();
    });
  }
  std::sort(ranked.begin(), ranked.end(), [&](const RankedPair& a, const RankedPair& b) {
    return a.confidence != b.confidence ? a.confidence > b.confidence : keys[a.number] < keys[b.number];
  });
  std::sort(keys.begin(), keys.end());
  const auto twice = std::adjacent_find(keys.begin(), keys.end());
  if (twice != keys.end())
    throw std::invalid_argument("tracks: the pair of images " + pairText(*twice) +
                                " is listed twice; list every pair once");
  return ranked;
}

/// Joins the inliers of a pair in ascending order. @return number of matches that were cut
std::size_t joinInliers(const VerifiedPair& pair, const KeypointNumbers& numbers, TrackForest& forest) {
  if (!isUsed(pair)) return 0;
  const std::uint32_t first = numbers.room(pair.pair.first).first;
  const std::uint32_t second = numbers.room(pair.pair.second).first;
  std::vector<KeypointPair> rows = pair.geometry.inliers;
  std::sort(rows.begin(), rows.end());
  std::size_t cut = 0;
  for (const KeypointPair& row : rows) cut += forest.join(first + row[0], second + row[1]) ? 0 : 1;
  return cut;
}

void listTracks(const KeypointNumbers& numbers, TrackForest& forest, std::size_t min_length, Tracks& tracks) {
  for (std::uint32_t i = 0; i < numbers.size(); ++i) {
    if (forest.first(i) != i) continue;
    const std::size_t begin = tracks.observations.size();
    for (std::uint32_t k = i; k != TrackForest::kNone; k = forest.next(k)) {
      const std::uint32_t image = forest.image(k);
      tracks.observations.push_back({image, k - numbers.room(image).first});
    }
    if (tracks.observations.size() - begin < min_length)
      tracks.observations.resize(begin);
    else
      tracks.begin.push_back(tracks.observations.size());
  }
}

/// Throws StoreError where a match names a keypoint that its image does not have.
void checkKeypoints(const KeypointNumbers& numbers, const PairStore& store) {
  for (const auto& [image, room] : numbers.rooms()) {
    const std::size_t keypoints = store.keypoints(image).positions.size();
    if (room.count > keypoints)
      throw StoreError(StoreError::Kind::kContent,
                       "tracks: a verified match names keypoint " + std::to_string(room.count - 1) +
                           " of image " + std::to_string(image) + ", which has " + std::to_string(keypoints) +
                           " keypoints; verify its pairs again");
  }
}

/// @param store  where the keypoints are; nullptr if they need no check
Tracks buildFrom(std::size_t pairs, const ReadPair& read, std::size_t min_length, const PairStore* store) {
  if (min_length < 2)
    throw std::invalid_argument("tracks: min_length is " + std::to_string(min_length) +
                                "; a track has at least 2 observations");
  Tracks tracks;
  KeypointNumbers numbers;
  const std::vector<RankedPair> ranked = rank(pairs, read, numbers, tracks.matches);
  if (store != nullptr) checkKeypoints(numbers, *store);
  numbers.finish();
  TrackForest forest(numbers);
  for (const RankedPair& entry : ranked)
    read(entry.number, [&](const VerifiedPair& pair) { tracks.cut += joinInliers(pair, numbers, forest); });
  listTracks(numbers, forest, min_length, tracks);
  return tracks;
}

/// The positions of all observations, read image by image.
std::vector<cv::Point2f> positionsOf(const Tracks& tracks, const PairStore& store) {
  std::map<std::uint32_t, std::vector<std::size_t>> by_image;
  for (std::size_t i = 0; i < tracks.observations.size(); ++i)
    by_image[tracks.observations[i].image].push_back(i);
  std::vector<cv::Point2f> positions(tracks.observations.size());
  for (const auto& [image, rows] : by_image) {
    const StoredKeypoints keypoints = store.keypoints(image);
    for (const std::size_t row : rows) {
      const std::uint32_t keypoint = tracks.observations[row].keypoint;
      if (keypoint >= keypoints.positions.size())
        throw StoreError(StoreError::Kind::kContent,
                         "tracks: keypoint " + std::to_string(keypoint) + " of image " +
                             std::to_string(image) + " does not exist, the store has " +
                             std::to_string(keypoints.positions.size()) +
                             "; the tracks belong to another store, build them from this one");
      positions[row] = keypoints.positions[keypoint];
    }
  }
  return positions;
}

std::map<std::uint32_t, std::string> namesOf(const PairStore& store) {
  std::map<std::uint32_t, std::string> names;
  for (const StoredImage& image : store.images()) names[image.id] = csvField(image.name);
  return names;
}

/// The track of every keypoint.
class TrackOfKeypoint {
 public:
  explicit TrackOfKeypoint(const Tracks& tracks) {
    for (const TrackObservation& o : tracks.observations) numbers_.include(o.image, o.keypoint);
    numbers_.finish();
    track_.assign(numbers_.size(), TrackForest::kNone);
    for (std::size_t track = 0; track < tracks.size(); ++track) {
      for (std::size_t i = tracks.begin[track]; i < tracks.begin[track + 1]; ++i) {
        const TrackObservation& o = tracks.observations[i];
        track_[numbers_.room(o.image).first + o.keypoint] = static_cast<std::uint32_t>(track);
      }
    }
  }

  /// The inliers of a pair whose keypoints share a track.
  std::vector<KeypointPair> kept(const VerifiedPair& pair) const {
    const KeypointNumbers::Room first = numbers_.room(pair.pair.first);
    const KeypointNumbers::Room second = numbers_.room(pair.pair.second);
    std::vector<KeypointPair> rows;
    for (const KeypointPair& row : pair.geometry.inliers) {
      if (row[0] >= first.count || row[1] >= second.count) continue;
      const std::uint32_t track = track_[first.first + row[0]];
      if (track != TrackForest::kNone && track == track_[second.first + row[1]]) rows.push_back(row);
    }
    return rows;
  }

 private:
  KeypointNumbers numbers_;
  std::vector<std::uint32_t> track_;
};

}  // namespace

Tracks buildTracks(const PairStore& store, const std::vector<ImagePairKey>& pairs, std::size_t min_length) {
  return buildFrom(
      pairs.size(),
      [&](std::size_t i, const std::function<void(const VerifiedPair&)>& use) {
        use(store.verified(pairs[i]));
      },
      min_length, &store);
}

Tracks buildTracks(const std::vector<VerifiedPair>& pairs, std::size_t min_length) {
  return buildFrom(
      pairs.size(),
      [&](std::size_t i, const std::function<void(const VerifiedPair&)>& use) { use(pairs[i]); }, min_length,
      nullptr);
}

TrackStatistics trackStatistics(const Tracks& tracks) {
  TrackStatistics result;
  result.tracks = tracks.size();
  result.observations = tracks.observations.size();
  result.matches = tracks.matches;
  result.cut = tracks.cut;
  result.mean_length = tracks.size() == 0
                           ? std::numeric_limits<double>::quiet_NaN()
                           : static_cast<double>(result.observations) / static_cast<double>(result.tracks);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const std::size_t length = tracks.begin[i + 1] - tracks.begin[i];
    if (length >= result.lengths.size()) result.lengths.resize(length + 1, 0);
    ++result.lengths[length];
  }
  std::map<std::uint32_t, std::size_t> per_image;
  for (const TrackObservation& o : tracks.observations) ++per_image[o.image];
  result.per_image.assign(per_image.begin(), per_image.end());
  return result;
}

void writeTracks(const std::filesystem::path& path, const Tracks& tracks, const PairStore& store) {
  const std::vector<cv::Point2f> positions = positionsOf(tracks, store);
  const std::map<std::uint32_t, std::string> names = namesOf(store);
  const std::filesystem::path part = path.string() + ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file.imbue(std::locale::classic());
  file.precision(7);  // what a float holds
  file << "track,image,name,keypoint,x,y\n";
  for (std::size_t track = 0; track < tracks.size(); ++track) {
    for (std::size_t i = tracks.begin[track]; i < tracks.begin[track + 1]; ++i) {
      const TrackObservation& o = tracks.observations[i];
      const auto name = names.find(o.image);
      file << track << ',' << o.image << ',' << (name == names.end() ? "" : name->second) << ',' << o.keypoint
           << ',' << positions[i].x << ',' << positions[i].y << '\n';
    }
  }
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (!file || error)
    throw StoreError(StoreError::Kind::kStorage,
                     "tracks: " + path.string() +
                         " cannot be written; check that its folder exists, may be written to and has room");
}

std::string trackConfiguration(const std::string& configuration) {
  return configuration + "; matches of tracks only";
}

void writeTrackMatches(PairStore& store, const Tracks& tracks, const std::vector<ImagePairKey>& pairs,
                       const std::string& configuration) {
  constexpr std::size_t kPairsOfCommit = 500;
  const TrackOfKeypoint track_of(tracks);
  const std::string text = trackConfiguration(configuration);
  std::vector<VerifiedPair> batch;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    VerifiedPair pair = store.verified(pairs[i]);
    std::vector<KeypointPair> kept = track_of.kept(pair);
    if (kept.empty())
      pair.geometry = {};
    else
      pair.geometry.inliers = std::move(kept);
    batch.push_back(std::move(pair));
    if (batch.size() == kPairsOfCommit || i + 1 == pairs.size()) {
      store.write(batch, text);
      batch.clear();
    }
  }
}

}  // namespace corrsel::core
