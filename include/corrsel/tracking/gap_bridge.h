#pragma once

#include <memory>
#include <vector>

#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/tracking/track_keeper.h"

namespace corrsel::core {

/// Finds tracks again that were lost for some frames.
///
/// Idea: Whether a match between two frames is right shows by its agreement with the other matches. The few
/// features that a track was lost at are judged together with the many tracks that both frames have.
///
/// Algorithm: matchFeatures() between the newest and the earlier frame, mutual nearest neighbours only. Kept
/// are matches of a free with a lost feature, and those between the features of a track that both frames
/// have. The selector decides about all of them, and the selected ones of the first kind are the links. Where
/// it states probabilities, those below 0.9 are left out (docs/studies/tracking.md).
///
/// Failure: There are no links if a frame has no descriptors, or if the status of the selection is neither
/// `ok` nor `time_limit`.
///
/// Cost: matchFeatures() and the selection; nothing where no feature is free or none is lost.
class GapBridge {
 public:
  /// @param selector  decides; must not be null
  /// @param threads   threads that the matching may use; the result does not depend on it
  explicit GapBridge(std::shared_ptr<const Selector> selector, int threads = 1);

  /// Is a TrackBridge. Throws what matchFeatures() throws.
  std::vector<FeatureLink> operator()(const GapTask& task) const;

 private:
  std::shared_ptr<const Selector> selector_;
  int threads_;
};

}  // namespace corrsel::core
