#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/workspace.h"
#include "features/detectors/detector_options.h"
#include "features/parts/place_mask.h"
#include "features/parts/scale_level.h"

namespace corrsel::core {

/// What a detector is asked to do for one image.
struct DetectionRequest {
  cv::Mat image;          ///< grey: one channel, 8 bits, not empty; may be a part of another image
  int threads = 1;        ///< threads that may be used; the result does not depend on it
  PlaceMask mask = {};    ///< keypoints at other places are not returned and do not count for max_features
  bool describe = false;  ///< compute descriptors too; allowed only where describesKeypoints() is true

  /// Where not null, a detector that has a scale space of the image puts its levels there, for the
  /// descriptor. They are valid until the calling thread detects again.
  std::vector<ScaleLevel>* levels = nullptr;

  /// Memory for the calling thread. Other threads that a detector employs use their own workspaces.
  Workspace& workspace = Workspace::ofThread();
};

/// Finds keypoints, and may describe them in the same pass. All members are const and re-entrant.
class Detector {
 public:
  virtual ~Detector() = default;

  /// Sets features.keypoints, features.frames and, where they are requested, features.descriptors, one entry
  /// each per keypoint. The other members of `features` are left alone.
  ///
  /// Keypoints: position and size (a diameter) in px of the request's image, angle in degrees in [0, 360),
  /// clockwise in the image, and response, where larger is stronger. Frames: the first column (a11, a21)
  /// points along the angle. Descriptors: see Descriptor::describe(). An image that is too small or blank
  /// gives no features. The order is arbitrary. A detector may return more than max_features, since the
  /// extractor calls keepStrongest() (features/parts/feature_list.h) afterwards. A detector that describes
  /// its keypoints itself should not describe those that are dropped then: it calls keepStrongest() before it
  /// describes, with the same options. That is right with `spread` too, and after the mask has been applied.
  /// A detector that drops keypoints earlier must keep all that keepStrongest() would keep.
  virtual void detect(const DetectionRequest& request, Features& features) const = 0;

  /// Whether the detector has a descriptor of its own, i.e. accepts DetectionRequest::describe.
  virtual bool describesKeypoints() const { return false; }

  /// The part of "detector+descriptor" before the plus sign.
  virtual std::string name() const = 0;

  virtual const DetectorOptions& options() const = 0;
};

}  // namespace corrsel::core
