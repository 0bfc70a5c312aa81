#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/ground_truth.h"

namespace corrsel::core {

/// Name of the features if the putative matches come with the dataset.
inline constexpr char kGivenFeatures[] = "given";

/// Names a pair of a dataset, e.g. {"vgg", "graf", "1-3"}.
struct PairId {
  std::string dataset, sequence, pair;

  /// "dataset/sequence/pair", for messages to people.
  std::string text() const { return dataset + "/" + sequence + "/" + pair; }
  bool operator<(const PairId& other) const {
    return std::tie(dataset, sequence, pair) < std::tie(other.dataset, other.sequence, other.pair);
  }
  bool operator==(const PairId& other) const {
    return dataset == other.dataset && sequence == other.sequence && pair == other.pair;
  }
};

/// Another reading of a pair's ground truth, which is the right one if the source of the pair was told
/// something wrong. evaluation/truth_check.h compares the readings.
struct OtherReading {
  std::string name;   ///< e.g. "raw"; TruthWarning::text() describes those that it knows
  GroundTruth truth;  ///< as it would be then
  /// Moves the points of matches to the images that `truth` refers to; empty: they stay. A point that these
  /// images do not have becomes NaN.
  std::function<Correspondences(const Correspondences&)> moved;
  double tolerance = 5;  ///< at which the readings are compared, px; the paper's tolerance for tables
};

/// Images of 16 bits that use fewer of them, such as those of cameras with 10, 12 or 14 bits, and were
/// scaled to 8 bits by the number of bits that the pair needs (docs/datasets.md).
struct StretchedBits {
  int bits = 0;       ///< 8, 10, 12 or 14
  int largest = 0;    ///< largest value of the pair
  std::string image;  ///< file or topic of the image with this value

  /// A sentence without its full stop, for messages to people.
  std::string text() const {
    return "images of 16 bits that use " + std::to_string(bits) + " of them (values up to " +
           std::to_string(largest) + " in " + image + ") are stretched";
  }
};

/// One image pair with its ground truth.
struct ImagePair {
  PairId id;
  cv::Mat left, right;  ///< 8-bit, one or three (BGR) channels
  GroundTruth truth;
  /// Calibration of the images as they are here, where it is known. It is that of their matches, too.
  std::optional<Camera> left_camera = {}, right_camera = {};
  std::optional<Correspondences> given;      ///< putative matches that come with the dataset (AdelaideRMF)
  std::vector<OtherReading> other_readings;  ///< beside those that every ground truth of its kind has
  std::optional<StretchedBits> stretched = {};
  /// Names of the images where their source knows them, e.g. paths below a folder; empty otherwise. Pairs of
  /// one image share its name.
  std::string left_name = {}, right_name = {};

  /// Gives matches of these images their cameras. A camera that the pair does not know stays.
  void addCamerasTo(Correspondences& matches) const {
    if (left_camera) matches.left_camera = left_camera;
    if (right_camera) matches.right_camera = right_camera;
  }
};

}  // namespace corrsel::core
