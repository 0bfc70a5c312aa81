#pragma once

#include <cstddef>
#include <memory>

#include "ros/bags/bag_file.h"
#include "ros/bags/bag_source.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {

/// Reads putative matches that were recorded live (live.launch record:=true) as given matches, without
/// images. Matches are evaluated with the GroundTruth message of their stamp, and then stay as they are.
/// Without such a message they are evaluated with the epipolar geometry of the recorded camera_info
/// (StereoRig): matches of raw images are undistorted and rectified, and those beyond the area that StereoRig
/// keeps are left out. Matches between images that were not taken at the same time (a sequence), and the
/// matches of a bag with neither ground truth nor calibration, have TruthKind::kNone. A pair has the name
/// that its message gives, or else {bag's name, "bag", stamp}.
class RecordedMatchesSource : public BagSource {
 public:
  /// Reads the bag once. The matches are on BagTopics::correspondences. Where that is empty, they are on the
  /// only topic of their type, or on the only one of these that ends in "correspondences". The two
  /// camera_info topics are the named ones, or else those with "left" and "right" in their names, or else
  /// those with the frame ids of the matches. BagTopics::images states whether the matches are of raw or of
  /// rectified images; "auto" takes whichever brings more of them near their epipolar lines, and adds a note.
  /// Throws core::DatasetError for topics that do not exist, have another type, cannot be read or are
  /// ambiguous (it lists those of the bag); std::invalid_argument for options out of range.
  RecordedMatchesSource(BagFile file, const BagTopics& topics);
  ~RecordedMatchesSource() override;

  /// Whether a bag that is read without named topics is of this kind: it has matches and no image.
  static bool recognises(const BagFile& file);

  /// Readable messages with matches, in the order of their stamps.
  std::size_t size() const override;
  bool next(core::ImagePair& pair) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel
