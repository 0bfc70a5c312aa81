#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <tuple>

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

/// One image pair with its ground truth.
struct ImagePair {
  PairId id;
  cv::Mat left, right;  ///< 8-bit, one or three (BGR) channels
  GroundTruth truth;
  std::optional<Correspondences> given;  ///< putative matches that come with the dataset (AdelaideRMF)
};

}  // namespace corrsel::core
