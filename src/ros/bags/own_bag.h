#pragma once

#include <cstddef>
#include <memory>

#include "ros/bags/bag_file.h"
#include "ros/bags/bag_source.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {

/// Reads the image pairs of a bag that a robot recorded. A left and a right image that are nearest to each
/// other in time form a pair; a message without a stamp in its header counts with the time of its recording.
/// A pair is evaluated with the GroundTruth message with the left image's stamp, and then the images stay as
/// they were recorded. Without such a message it is evaluated with the epipolar geometry of the rig
/// (StereoRig), and the images are rectified. Pairs are named {bag's name, "bag", stamp}.
class OwnBagSource : public BagSource {
 public:
  /// Reads the whole bag once, for the stamps only. Throws core::DatasetError for topics that do not exist or
  /// have another type (it lists those of the bag), for a left and a right image on the same topic, if no
  /// stamps are near enough (it names the smallest difference), if the bag has neither a calibration nor
  /// ground truth, for a calibration that cannot be used, and for images of another size. Throws
  /// std::invalid_argument for options out of range.
  OwnBagSource(BagFile file, const BagTopics& topics);
  ~OwnBagSource() override;

  /// Whether a bag that is read without named topics is of this kind: it has no topic of a dataset bag but
  /// the images, and it has the camera_info of both cameras.
  static bool recognises(const BagFile& file);

  /// Pairs in the order of their stamps: exactly as many as next() returns or fails with.
  std::size_t size() const override;
  bool next(core::ImagePair& pair) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel
