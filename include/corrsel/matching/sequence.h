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

/// Which earlier frame each new one is compared with. Features are shared, never copied. Not thread-safe.
class Sequence {
 public:
  struct Frame {
    std::uint64_t id;  ///< given by the caller, e.g. the stamp in ns
    std::shared_ptr<const Features> features;
  };

  /// Throws std::invalid_argument for options out of range.
  explicit Sequence(const SequenceOptions& options = {});

  /// To be called between two frames, not between reference() and the add() that belongs to it. What is
  /// remembered stays as far as it can be used: a sequence that changes to keyframes begins with the newest
  /// frame, one that looks further back than before has no reference until enough frames have come. Throws as
  /// the constructor does, and then nothing has changed.
  void setOptions(const SequenceOptions& options);

  /// What the next frame is to be compared with; null while there is none (yet). Valid until the next call of
  /// another member that is not const.
  const Frame* reference() const;

  /// The frame has been matched. Keyframes: it becomes the keyframe where there is none or where overlap()
  /// fell below min_overlap, but never when it has no features: then the next one is compared with the old
  /// keyframe. Throws std::invalid_argument for a frame without a pointer to features, and what overlap()
  /// throws; then nothing has changed. O(matches + features).
  /// @param matches  left = the frame, right = reference(); empty where there was no reference
  void add(Frame frame, const Correspondences& matches);

  /// Forgets all frames: needed for another camera, resolution or extractor, and after a jump in time.
  void reset();

  /// overlap() of the newest frame with its reference; NaN where there was none, or one without features.
  double lastOverlap() const { return last_overlap_; }

 private:
  bool keyframes() const { return options_.reference == SequenceOptions::Reference::kKeyframe; }
  void trim();

  SequenceOptions options_;
  std::deque<Frame> frames_;       ///< newest last, as many as are needed
  std::optional<Frame> keyframe_;  ///< always with features
  double last_overlap_ = std::numeric_limits<double>::quiet_NaN();
};

/// How much of the reference is seen again: the share of the cells of an 8 x 8 grid over the right image in
/// which at least 15 % of the reference's features are the right end of a match passing the ratio test. Cells
/// without features of the reference do not count; NaN where it has none. That one match is not enough makes
/// the share follow the truth: between views that have nothing in common, wrong matches at a ratio of 0.8 hit
/// up to 70 % of the cells (see docs/features.md). Throws std::invalid_argument for matches without feature
/// numbers, or with numbers that the reference does not have. O(matches + features).
/// @param ratio  a match passes when its distance is at most this times its second distance; without
/// distances all pass, without a second neighbour (NaN) none
double overlap(const Correspondences& matches, const Features& reference, double ratio);

}  // namespace corrsel::core
