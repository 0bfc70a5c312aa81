#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct SequenceOptions : OptionSet {
  enum class Reference : std::uint8_t { kPrevious, kKeyframe };

  Reference reference = Reference::kPrevious;  ///< the frame `step` frames ago, or a keyframe
  int step = 1;                                ///< previous: how many processed frames ago
  double min_overlap = 0.5;                    ///< keyframe: renewed when overlap() falls below this
  double ratio = 0.8;                          ///< see overlap()

  void visit(OptionVisitor& visitor) const override;
};

/// Chooses the earlier frame with which each new frame is compared. Features are shared, never copied. Not
/// thread-safe.
class Sequence {
 public:
  struct Frame {
    std::uint64_t id;  ///< given by the caller, e.g. the stamp in ns
    std::shared_ptr<const Features> features;
  };

  /// Throws std::invalid_argument for options out of range.
  explicit Sequence(const SequenceOptions& options = {});

  /// Changes the options. Call it between two frames, not between reference() and the corresponding add().
  /// Frames are kept as far as the new options can use them: a sequence that changes to keyframes begins with
  /// the newest frame, and one with a larger step has no reference until enough frames have been added.
  /// Throws like the constructor, and then changes nothing.
  void setOptions(const SequenceOptions& options);

  /// The frame with which the next one is compared; null if there is none (yet). Valid until the next call of
  /// a member that is not const.
  const Frame* reference() const;

  /// Adds a frame after it has been matched. With keyframes, it becomes the keyframe if there is none or if
  /// overlap() fell below min_overlap. A frame without features never does; the next frame is then compared
  /// with the old keyframe. Throws std::invalid_argument for a frame without a pointer to features, and
  /// whatever overlap() throws; then nothing has changed. O(matches + features).
  /// @param matches  left = the frame, right = reference(); empty if there was no reference
  void add(Frame frame, const Correspondences& matches);

  /// Forgets all frames. Call it for another camera, resolution or extractor, and after a jump in time.
  void reset();

  /// overlap() of the newest frame with its reference; NaN if there was no reference or one without features.
  double lastOverlap() const { return last_overlap_; }

 private:
  bool keyframes() const { return options_.reference == SequenceOptions::Reference::kKeyframe; }
  void trim();

  SequenceOptions options_;
  std::deque<Frame> frames_;       ///< newest last; no more than needed
  std::optional<Frame> keyframe_;  ///< always with features
  double last_overlap_ = std::numeric_limits<double>::quiet_NaN();
};

/// Computes how much of the reference is visible again.
///
/// Algorithm: the result is the share of the cells of an 8 x 8 grid over the right image in which at least 15
/// % of the reference's features are the right end of a match that passes the ratio test. Cells without
/// features of the reference do not count. A single match per cell would not suffice: between views that have
/// nothing in common, wrong matches at a ratio of 0.8 hit up to 70 % of the cells (see docs/features.md).
///
/// Failure: NaN if the reference has no features. Throws std::invalid_argument for matches without feature
/// numbers, or with numbers that the reference does not have.
///
/// Cost: O(matches + features).
/// @param ratio  a match passes if its distance is at most this times its second distance; without distances
/// all
///               pass, without a second neighbour (NaN) none
double overlap(const Correspondences& matches, const Features& reference, double ratio);

}  // namespace corrsel::core
