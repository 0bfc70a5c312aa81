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

/// Reads putative matches that were recorded live (live.launch record:=true) as given matches, without
/// images. Matches are judged by the GroundTruth message of their stamp, as they are; else by the epipolar
/// geometry of the recorded camera_info (StereoRig): matches of raw images are undistorted and rectified, and
/// those beyond the area that StereoRig keeps are left out. Matches between images that were not taken at the
/// same time (a sequence), and those of a bag without either, have TruthKind::kNone. Pairs are named as the
/// message names them, else {bag's name, "bag", stamp}.
class RecordedMatchesSource : public core::PairSource {
 public:
  /// Reads the bag once. The matches are on BagTopics::correspondences; where that is empty, on the only
  /// topic of their type or the only one of them that ends in "correspondences". The two camera_info topics
  /// are the ones named, else the ones with "left" and "right" in their names, else those with the frame ids
  /// of the matches. BagTopics::images tells whether the matches are of raw or of rectified images; "auto"
  /// takes what brings more of them near their epipolar lines, and says so.
  /// Throws core::DatasetError for topics that are not there, of another type, not readable, or not to be
  /// told apart (listing those of the bag); std::invalid_argument for options out of range.
  RecordedMatchesSource(std::unique_ptr<rosbag::Bag> bag, const std::string& path, const BagTopics& topics);
  ~RecordedMatchesSource() override;
  RecordedMatchesSource(const RecordedMatchesSource&) = delete;
  RecordedMatchesSource& operator=(const RecordedMatchesSource&) = delete;

  /// Whether a bag is one of these when no topic tells: it has matches and no image.
  static bool recognises(const std::map<std::string, std::string>& types);

  /// Readable messages of matches, in the order of their stamps.
  std::size_t size() const override;
  bool next(core::ImagePair& pair) override;

  /// What was left out and why, and what the reader decided; one sentence each.
  const std::vector<std::string>& notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel
