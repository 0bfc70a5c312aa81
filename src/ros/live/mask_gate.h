#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace corrsel {

/// The masks of one pair.
struct PairMasks {
  cv::Mat left, right;   ///< as they came; empty = none
  bool missing = false;  ///< whether a mask that was waited for is not there, or no mask is
};

/// The masks of one camera, and which of its images each belongs to: the image with the stamp of the mask,
/// or else the newest image that is older than the mask by at most `max_age`. Masks come in the order of
/// their stamps, so a mask shows that the images before it get no other one. Stamps are nanoseconds.
class MaskTrack {
 public:
  using Stamp = std::int64_t;

  /// @param capacity  number of masks, and of images, that are remembered
  MaskTrack(Stamp max_age, std::size_t capacity) : max_age_(max_age), capacity_(capacity) {}

  /// An image whose mask is asked for. Does nothing for a stamp that it has already.
  void addImage(Stamp stamp);

  void addMask(Stamp stamp, cv::Mat mask);

  /// Whether no later mask can change maskOf().
  bool decided(Stamp image) const;

  /// The mask of an image, which counts as used from now on; empty = none so far.
  cv::Mat maskOf(Stamp image);

  /// Stamp of the newest mask since construction or clear().
  const std::optional<Stamp>& newestMask() const { return newest_mask_; }

  /// Forgets what is older than a stamp.
  void forget(Stamp before);

  /// Forgets everything but the counts.
  void clear();

  std::size_t received() const { return received_; }

  /// Number of the masks that were forgotten without having been used.
  std::size_t unused() const { return unused_; }

 private:
  struct Mask {
    cv::Mat pixels;
    bool used = false;
  };
  struct Image {
    std::shared_ptr<Mask> mask;
    bool decided = false;
  };
  using Masks = std::map<Stamp, std::shared_ptr<Mask>>;
  using Images = std::map<Stamp, Image>;

  void decide(Images::iterator image);
  Masks::iterator erase(Masks::iterator mask);

  const Stamp max_age_;
  const std::size_t capacity_;
  Masks masks_;
  Images images_;
  std::optional<Stamp> newest_mask_;
  std::size_t received_ = 0, unused_ = 0;
};

/// How a MaskGate waits.
struct MaskGateOptions {
  bool sequence = false;  ///< one camera, whose masks are those of both sides
  double timeout = 0.2;   ///< s that a pair waits for its masks
  double max_age = 0;     ///< s that a mask may be newer than the image that it belongs to
};

/// Holds pairs back until their masks have come, a later mask shows that they will not come, or the pair has
/// waited for the timeout. Pairs leave in the order in which they came. When a stamp goes back (a bag in a
/// loop), all waiting pairs leave and all masks are forgotten.
///
/// It has no threads and no clock: every call is given the time, in seconds from any origin, which must not
/// decrease. Not thread-safe.
template <class Item>
class MaskGate {
 public:
  using Stamp = MaskTrack::Stamp;
  enum Side { kLeft, kRight };

  /// A pair that goes on, and its masks.
  struct Pair {
    Item item;
    PairMasks masks;
  };
  using Pairs = std::vector<Pair>;

  /// Since construction.
  struct Counts {
    std::size_t masks = 0;           ///< that have come
    std::size_t masks_unused = 0;    ///< that have come and found no pair
    std::size_t pairs_masked = 0;    ///< that went on with all their masks
    std::size_t pairs_unmasked = 0;  ///< that went on without one of them
  };

  explicit MaskGate(const MaskGateOptions& options)
      : options_(options),
        tracks_{MaskTrack(nanoseconds(options.max_age), kCapacity),
                MaskTrack(nanoseconds(options.max_age), kCapacity)} {}

  /// Whether masks may come at all: a pair does not wait for those of a side where they do not. True at
  /// first. In a sequence, those of the left side are those of both.
  void expect(Side side, bool expected) { expected_[index(side)] = expected; }

  /// A pair has come. @param left  stamp of its left image. @param right  stamp of its right image
  /// @return the pairs that go on
  Pairs addPair(Item item, Stamp left, Stamp right, double now) {
    Pairs ready;
    if (newest_pair_ && left < *newest_pair_) startAnew(ready);
    newest_pair_ = left;
    track(kLeft).addImage(left);
    track(kRight).addImage(right);
    waiting_.push_back({std::move(item), {left, right}, now + options_.timeout});
    release(now, ready);
    return ready;
  }

  /// A mask has come. In a sequence, its side has no meaning.
  Pairs addMask(Side side, Stamp stamp, cv::Mat mask, double now) {
    Pairs ready;
    const std::optional<Stamp>& newest = track(side).newestMask();
    if (newest && stamp < *newest) startAnew(ready);
    track(side).addMask(stamp, std::move(mask));
    release(now, ready);
    return ready;
  }

  /// Time has passed.
  Pairs poll(double now) {
    Pairs ready;
    release(now, ready);
    return ready;
  }

  /// Forgets the waiting pairs and all masks.
  void clear() {
    waiting_.clear();
    forgetStamps();
  }

  Counts counts() const {
    return {tracks_[0].received() + tracks_[1].received(), tracks_[0].unused() + tracks_[1].unused(),
            pairs_masked_, pairs_unmasked_};
  }

 private:
  /// Enough for the longest distance of the two frames of a sequence, 100, and for masks that come early.
  static constexpr std::size_t kCapacity = 128;

  struct Waiting {
    Item item;
    std::array<Stamp, 2> stamps;  ///< left, right
    double deadline;              ///< s
  };

  static Stamp nanoseconds(double seconds) { return static_cast<Stamp>(seconds * 1e9 + 0.5); }
  std::size_t index(Side side) const { return options_.sequence || side == kLeft ? 0 : 1; }
  MaskTrack& track(Side side) { return tracks_[index(side)]; }

  bool isReady(const Waiting& pair) {
    const auto waits = [&](Side side) {
      return expected_[index(side)] && !track(side).decided(pair.stamps[side]);
    };
    return !waits(kLeft) && !waits(kRight);
  }

  void release(double now, Pairs& ready) {
    while (!waiting_.empty() && (now >= waiting_.front().deadline || isReady(waiting_.front()))) {
      letGo(ready);
    }
    forgetOld();
  }

  void letGo(Pairs& ready) {
    Waiting pair = std::move(waiting_.front());
    waiting_.pop_front();
    PairMasks masks;
    masks.left = track(kLeft).maskOf(pair.stamps[kLeft]);
    masks.right = track(kRight).maskOf(pair.stamps[kRight]);
    const auto lacks = [&](const cv::Mat& mask, Side side) { return mask.empty() && expected_[index(side)]; };
    masks.missing =
        lacks(masks.left, kLeft) || lacks(masks.right, kRight) || (masks.left.empty() && masks.right.empty());
    ++(masks.missing ? pairs_unmasked_ : pairs_masked_);
    oldest_needed_ = pair.stamps;
    ready.push_back({std::move(pair.item), std::move(masks)});
  }

  /// Later pairs ask for no image that is older than those of the oldest pair here, or of the last one that
  /// has gone on: stamps do not go back, and neither do the earlier frames of a sequence.
  void forgetOld() {
    const std::array<Stamp, 2>* needed = nullptr;
    if (!waiting_.empty()) {
      needed = &waiting_.front().stamps;
    } else if (oldest_needed_) {
      needed = &*oldest_needed_;
    }
    if (needed == nullptr) return;
    if (!options_.sequence) tracks_[0].forget((*needed)[kLeft]);
    track(kRight).forget((*needed)[kRight]);
  }

  void startAnew(Pairs& ready) {
    while (!waiting_.empty()) letGo(ready);
    forgetStamps();
  }

  void forgetStamps() {
    for (MaskTrack& track : tracks_) track.clear();
    newest_pair_.reset();
    oldest_needed_.reset();
  }

  const MaskGateOptions options_;
  std::array<MaskTrack, 2> tracks_;  ///< left, right; in a sequence the first one counts for both
  std::array<bool, 2> expected_{true, true};
  std::deque<Waiting> waiting_;
  std::optional<Stamp> newest_pair_;                   ///< left stamp
  std::optional<std::array<Stamp, 2>> oldest_needed_;  ///< of the last pair that has gone on
  std::size_t pairs_masked_ = 0, pairs_unmasked_ = 0;
};

}  // namespace corrsel
