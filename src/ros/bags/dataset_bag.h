#pragma once

#include <ros/time.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/pair_source.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/image_pair.h"

namespace corrsel {

/// Topics of a dataset bag.
namespace bag_topics {
inline constexpr char kLeft[] = "/left/image";                         ///< sensor_msgs/Image
inline constexpr char kRight[] = "/right/image";                       ///< sensor_msgs/Image
inline constexpr char kLeftCompressed[] = "/left/image/compressed";    ///< sensor_msgs/CompressedImage
inline constexpr char kRightCompressed[] = "/right/image/compressed";  ///< sensor_msgs/CompressedImage
inline constexpr char kGroundTruth[] = "/ground_truth";                ///< corrsel/GroundTruth
inline constexpr char kCorrespondences[] = "/correspondences";  ///< corrsel/Correspondences, given matches
}  // namespace bag_topics

struct DatasetBagOptions {
  bool compressed = false;         ///< images as PNG instead of raw
  double period = 0.5;             ///< between the stamps of two pairs, s; at least 1e-3
  ros::Time start = ros::Time(1);  ///< stamp of the first pair; fixed, so that equal input gives equal files
};

/// Writes image pairs with their truth as a bag that both the benchmark and the nodelets read. All messages
/// of a pair carry the same stamp, which is also their time in the bag. The file is written as `path` +
/// ".part" and gets its name in close(); without close() the unfinished file is removed.
class DatasetBagWriter {
 public:
  /// Throws std::invalid_argument for a period out of range and core::DatasetError where the file cannot be
  /// made.
  explicit DatasetBagWriter(const std::string& path, const DatasetBagOptions& options = {});
  ~DatasetBagWriter();
  DatasetBagWriter(const DatasetBagWriter&) = delete;
  DatasetBagWriter& operator=(const DatasetBagWriter&) = delete;

  /// Appends one pair. Throws core::DatasetError for images that are not 8-bit grey or BGR (nothing of the
  /// pair is written then) and where writing fails.
  void write(const core::ImagePair& pair);

  /// Completes the file under its final name; a file that has it already is replaced.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Topics of a bag and how its messages become pairs; the defaults are those of a dataset bag. Topics may be
/// given with or without the leading slash, those of images with or without "/compressed".
struct BagTopics {
  std::string left, right;             ///< images; empty = those of a dataset bag
  std::string left_info, right_info;   ///< sensor_msgs/CameraInfo; empty = camera_info beside the images
  std::string ground_truth;            ///< corrsel/GroundTruth; empty = /ground_truth
  std::string correspondences;         ///< corrsel/Correspondences, instead of images; empty = found by type
  std::string images = "auto";         ///< raw, rectified, auto: rectified if the topic's name has image_rect
  double max_stamp_difference = 0.01;  ///< between left and right image (and truth) of a pair, s, in [0, 10]
};

/// Reads the image pairs of a bag in this process: no topic, no lost frame. Raw and compressed images are
/// read, in any mixture of encodings.
///
/// Dataset bags (no topic is named): messages with equal header stamps form a pair, which ends where the next
/// stamp begins. A pair without ground truth has TruthKind::kNone and, unless it has given matches, is named
/// after bag and stamp.
///
/// A robot's own bag (a topic is named, or the bag has camera_info for both images and neither ground truth
/// nor matches): see OwnBagSource in own_bag.h.
///
/// Recorded matches (their topic is named, or the bag has matches and no image): see RecordedMatchesSource in
/// recorded_bag.h.
class BagSource : public core::PairSource {
 public:
  /// Throws core::DatasetError saying what is wrong and how to mend it: missing file, not a bag, bag without
  /// an index, bag without the topics (naming those it has), and what OwnBagSource and
  /// RecordedMatchesSource throw.
  explicit BagSource(const std::string& path, const BagTopics& topics = {});
  ~BagSource() override;
  BagSource(const BagSource&) = delete;
  BagSource& operator=(const BagSource&) = delete;

  /// Dataset bags: left images or ground truths, whichever are more; other bags: the pairs. No image is
  /// decoded for this.
  std::size_t size() const override;

  /// Throws core::DatasetError naming pair and topic where a pair is incomplete or cannot be decoded; the
  /// next call goes on with the pair after it.
  bool next(core::ImagePair& pair) override;

  /// For people: messages of an own bag or of recorded matches that were left out, and why; one sentence
  /// each. Empty for dataset bags, whose incomplete pairs next() reports.
  const std::vector<std::string>& notes() const;

 private:
  std::unique_ptr<core::PairSource> source_;
  std::vector<std::string> notes_;
};

/// Called after every pair, written or not: pairs done, pairs of the dataset, the pair.
using BagProgress = std::function<void(std::size_t done, std::size_t total, const core::PairId& pair)>;

/// Converts a dataset. Pairs that cannot be read are left out and described in `problems` (may be null).
/// @return pairs written; where there are none, no file is made. Throws core::DatasetError where writing
/// fails.
std::size_t writeDatasetBag(const core::DatasetReader& reader, const std::string& path,
                            const DatasetBagOptions& options, const BagProgress& progress = nullptr,
                            std::vector<std::string>* problems = nullptr);

}  // namespace corrsel
