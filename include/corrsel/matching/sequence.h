#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/features/image_quality.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct SequenceOptions : OptionSet {
  enum class Reference : std::uint8_t { kPrevious, kKeyframe };

  Reference reference = Reference::kPrevious;  ///< the frame `step` frames ago, or a keyframe
  int step = 1;                                ///< previous: number of processed frames
  double min_overlap = 0.5;                    ///< keyframe: replaced when overlap() falls below this
  double ratio = 0.8;                          ///< see overlap()

  void visit(OptionVisitor& visitor) const override;
};

/// Chooses the earlier frame with which each new frame of one camera is compared.
///
/// Idea: Matching with a fixed number of frames ago gives a constant time between the two frames. Matching
/// with a keyframe gives a sufficient baseline also where the camera hardly moves.
///
/// Algorithm: `previous` uses the frame `step` processed frames ago. `keyframe` uses one frame until less
/// than `min_overlap` of it is seen again, see overlap(); then the newest frame takes its place.
///
/// Options: SequenceOptions.
///
/// Failure: There is no reference in the first `step` frames (previous), or until a frame with features has
/// been added (keyframe). A frame without features never becomes the keyframe.
///
/// Cost: Features are shared, not copied; add() takes O(matches + features).
///
/// Not thread-safe.
class Sequence {
 public:
  struct Frame {
    std::uint64_t id;  ///< given by the caller, e.g. the stamp in ns
    std::shared_ptr<const Features> features;
    std::optional<Camera> camera = {};  ///< calibration of the image
    ImageQuality quality = {};          ///< what the image suffers from
  };

  /// Throws std::invalid_argument for options out of range.
  explicit Sequence(const SequenceOptions& options = {});

  /// Changes the options between two frames, i.e. not between reference() and the following add(). Remembered
  /// frames are kept as far as they can be used: a sequence that changes to keyframes begins with the newest
  /// frame, and one with a larger `step` has no reference until enough frames have been added. Throws
  /// std::invalid_argument for options out of range, and then changes nothing.
  void setOptions(const SequenceOptions& options);

  /// The frame with which the next frame should be compared; null where there is none yet. The pointer is
  /// valid until the next call of a member that is not const.
  const Frame* reference() const;

  /// Adds a frame after it has been matched with reference(). It becomes the keyframe where there is none, or
  /// where overlap() is below min_overlap and the frame has features. Throws std::invalid_argument for a
  /// frame without a pointer to features, and what overlap() throws; then nothing changes.
  /// @param matches  left = the frame, right = reference(); empty where there was no reference
  void add(Frame frame, const Correspondences& matches);

  /// Drops all frames. This is needed for another camera, resolution or extractor, and after a jump in time.
  void reset();

  /// overlap() of the newest frame with its reference; NaN where there was no reference or where it had no
  /// features.
  double lastOverlap() const { return last_overlap_; }

 private:
  bool keyframes() const { return options_.reference == SequenceOptions::Reference::kKeyframe; }
  void trim();

  SequenceOptions options_;
  std::deque<Frame> frames_;       ///< newest last, as many as are needed
  std::optional<Frame> keyframe_;  ///< always with features
  double last_overlap_ = std::numeric_limits<double>::quiet_NaN();
};

/// The share of a reference image that is seen again.
///
/// Algorithm: A feature of the reference is found again where it is the right end of a match that passes the
/// ratio test. The share is that of the cells of an 8 x 8 grid over the reference in which at least 15 % of
/// the features are found again. Cells without features do not count. One found feature per cell would not
/// suffice: between unrelated views, outliers with a ratio of at most 0.8 hit up to 70 % of the cells
/// (see docs/features.md).
///
/// Failure: NaN where the reference has no features. Throws std::invalid_argument for matches without feature
/// numbers, or with numbers that the reference does not have.
///
/// Cost: O(matches + features).
///
/// @param ratio  a match passes where its distance is at most this times its second distance; without
/// distances all matches pass, and without a second neighbour (NaN) none
double overlap(const Correspondences& matches, const Features& reference, double ratio);

}  // namespace corrsel::core
