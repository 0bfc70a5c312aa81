#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"

namespace corrsel::core {

/// A match between a feature of the newest frame and one of an earlier frame, by their numbers.
struct FeatureLink {
  std::uint32_t newest = 0, earlier = 0;
  float cost = 0;  ///< of two links to one feature, that with the lower cost is kept; NaN is the highest
};

inline bool operator==(const FeatureLink& a, const FeatureLink& b) {
  return a.newest == b.newest && a.earlier == b.earlier;
}

/// Where a track was seen.
struct TrackSight {
  std::uint64_t frame = 0;    ///< id of the frame
  std::uint32_t feature = 0;  ///< number of the feature in it
  cv::Point2f point;          ///< px
};

/// The track of a feature of the newest frame.
struct FeatureTrack {
  std::uint64_t id = 0;   ///< never used again, also after TrackKeeper::reset()
  std::uint32_t age = 0;  ///< number of frames in which it was seen, with the newest one
  TrackSight first;       ///< where it was seen first
  cv::Point2f point;      ///< in the newest frame, px; NaN = not known
  cv::Point2f previous;   ///< in the frame before, px; NaN = not seen there
};

/// What a bridge is asked: which of the free features of the newest frame continue which of the lost tracks.
struct GapTask {
  const Features& newest;
  const Features& earlier;
  std::vector<std::uint32_t> free;  ///< features of the newest frame that continue no track, ascending
  std::vector<std::uint32_t> lost;  ///< features of the earlier frame whose tracks ended there, ascending
  std::vector<FeatureLink> seen;    ///< features of the tracks that both frames have
};

/// Links between free and lost features, see GapBridge. Links between others are ignored.
using TrackBridge = std::function<std::vector<FeatureLink>(const GapTask&)>;

/// Gives the features of a sequence an identity that lasts over its frames.
///
/// Idea: A selected match continues the track of the feature in the earlier frame. A point of the scene has
/// one image in a frame, so two features of a frame never share a track.
///
/// Algorithm: Every feature of a new frame that no link continues begins a track. Links are taken by rising
/// cost, and equal ones by their numbers. A link one of whose features has been linked already is cut. With
/// `max_gap`, the bridge is then asked about the frames that came up to `max_gap` frames before the previous
/// one, the newest of them first, and about the previous one if it is not the reference. It is given the
/// features that continue no track and the tracks that were last seen there.
///
/// Input: Frames in the order of their ids. The frame that the links refer to may be any of the last
/// `max_frames`, or, however old it is, the one that the links of the previous frame referred to, e.g. a
/// keyframe. The result does not depend on the order of the links.
///
/// Cost: O(features + links log links) for a frame, and what the bridge takes. Memory of at most 120 bytes
/// for every feature of the last `max_frames` frames; the features of the last `max_gap` + 2 frames are
/// shared.
///
/// Not thread-safe.
class TrackKeeper {
 public:
  /// A frame of the sequence.
  struct Frame {
    std::uint64_t id = 0;                      ///< rises from frame to frame, e.g. the stamp in ns
    std::vector<cv::Point2f> points;           ///< position of every feature, px; NaN = not known
    std::shared_ptr<const Features> features;  ///< optional: of as many features, for the bridge
  };

  /// What became of the newest frame.
  struct Counts {
    std::size_t continued = 0;  ///< features that continue a track by a link
    std::size_t bridged = 0;    ///< features that continue a track that was lost for some frames
    std::size_t begun = 0;      ///< features that begin a track: all others
    std::size_t cut = 0;        ///< links that would have given two features of a frame the same track
    std::size_t lost = 0;       ///< tracks of the frame before that were not found again
  };

  /// @param max_gap     frames that a track may be missing in; 0 = the bridge is never asked
  /// @param max_frames  frames to which links may refer; at least max_gap + 2
  /// Throws std::invalid_argument for a number of frames that is too small.
  explicit TrackKeeper(std::size_t max_gap = 0, TrackBridge bridge = {}, std::size_t max_frames = 101);

  /// Takes another bridge from the next frame on.
  void setBridge(TrackBridge bridge) { bridge_ = std::move(bridge); }

  /// Whether links may refer to this frame.
  bool knows(std::uint64_t id) const;

  /// The id of the newest frame; nothing before the first one.
  std::optional<std::uint64_t> newest() const;

  /// Adds the next frame. Throws std::invalid_argument that names the value for an id that is not above that
  /// of the newest frame, another number of features than of points, a reference that is not known, and a
  /// link to a feature that its frame does not have; then nothing changes. What the bridge throws is thrown
  /// when the frame has been added without it.
  /// @param reference  id of the frame that the links refer to
  void add(Frame frame, std::uint64_t reference, const std::vector<FeatureLink>& links);

  /// Adds the next frame without links. It continues tracks only by the bridge.
  void add(Frame frame);

  /// Fills in positions that were not known when a frame was added, for the tracks that were seen there last.
  /// Nothing happens for a frame that is not known. O(features).
  /// @param points  of the features of the frame, px; NaN = not known
  void locate(std::uint64_t frame, const std::vector<cv::Point2f>& points);

  /// The tracks of the newest frame, one for each of its features.
  std::vector<FeatureTrack> tracks() const;

  const Counts& counts() const { return counts_; }

  /// Forgets all frames, so that the next ones begin new tracks. This is needed for another camera,
  /// resolution or extractor, and after a jump in time.
  void reset();

  /// Number of tracks that are remembered, for tests of the memory.
  std::size_t remembered() const { return states_.size(); }

 private:
  struct Record {
    std::uint64_t id;
    std::vector<std::uint64_t> tracks;         ///< of every feature
    std::shared_ptr<const Features> features;  ///< of the frames that the bridge may be asked about
  };
  struct State {
    std::uint32_t age = 0;
    std::uint32_t frames = 0;  ///< remembered frames that have the track
    TrackSight first, last;
    cv::Point2f previous;  ///< in the frame before that of `last`
  };

  const Record* find(std::uint64_t id) const;
  void check(const Frame& frame, const Record* reference, const std::vector<FeatureLink>& links) const;
  std::size_t join(const std::vector<FeatureLink>& links, const Record& earlier, Record& record,
                   const std::vector<cv::Point2f>& points);
  void finish(Record record, const std::vector<cv::Point2f>& points, std::optional<std::uint64_t> reference);
  void bridgeGaps(std::optional<std::uint64_t> reference, Record& record,
                  const std::vector<cv::Point2f>& points);
  GapTask taskOf(const Record& earlier, const Record& record) const;
  void see(std::uint64_t track, Record& record, std::uint32_t feature, const cv::Point2f& point);
  void forget();

  const std::size_t max_gap_, max_frames_;
  TrackBridge bridge_;
  std::deque<Record> frames_;                        ///< newest last
  std::optional<std::uint64_t> reference_;           ///< of the newest frame that has one
  std::unordered_map<std::uint64_t, State> states_;  ///< of the tracks in frames_
  std::uint64_t next_id_ = 1;
  Counts counts_;
};

/// The links of the selected matches: left = newest, right = earlier. The cost of a match is its descriptor
/// distance; without distances it is 1 - probability, and without both it is 0. O(matches).
/// @param mask  1 = selected, as long as the matches
/// Throws std::invalid_argument for matches without numbers of features, and for a mask of another length.
std::vector<FeatureLink> selectedLinks(const Correspondences& matches, const std::vector<std::uint8_t>& mask);

/// Which side of matches.
enum class MatchSide : std::uint8_t { kLeft, kRight };

/// The positions of the features of one image, as far as its matches show them: NaN for the others.
/// O(matches + features).
/// Throws std::invalid_argument for matches without numbers of features, for numbers that an image with so
/// many features does not have, and for more than a million features.
std::vector<cv::Point2f> matchedPoints(const Correspondences& matches, MatchSide side,
                                       std::size_t n_features);

}  // namespace corrsel::core
