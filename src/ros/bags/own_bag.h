#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/pair_source.h"
#include "ros/bags/bag_file.h"
#include "ros/bags/dataset_bag.h"

namespace corrsel {

/// Reads the image pairs of a bag that a robot recorded. A left and a right image that are nearest to each
/// other in time are a pair; messages without a header stamp count with the time of their recording. A pair
/// is judged by the GroundTruth message of the left image's stamp, images as they are recorded; else by the
/// epipolar geometry of the rig (StereoRig), images rectified. Pairs are named {bag's name, "bag", stamp}.
class OwnBagSource : public core::PairSource {
 public:
  /// Reads the whole bag once, the stamps only. Throws core::DatasetError for topics that are not there or of
  /// another type (listing those of the bag), for left and right of one topic, where no stamps are near
  /// enough (saying how near they come), where nothing says what is true, for a calibration that cannot be
  /// used and for images of another size; std::invalid_argument for options out of range.
  OwnBagSource(std::unique_ptr<rosbag::Bag> bag, const std::string& path, const BagTopics& topics);
  ~OwnBagSource() override;
  OwnBagSource(const OwnBagSource&) = delete;
  OwnBagSource& operator=(const OwnBagSource&) = delete;

  /// Whether a bag read without named topics is one of these: no topic of a dataset bag but the images, and
  /// the camera_info of both cameras.
  static bool recognises(const std::map<std::string, std::string>& types);

  /// Pairs in time order, exactly as many as next() gives or fails with.
  std::size_t size() const override;
  bool next(core::ImagePair& pair) override;

  /// What was left out and why, and what the reader decided; one sentence each.
  const std::vector<std::string>& notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel
