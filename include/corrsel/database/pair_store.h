#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/database/two_view_geometry.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// A file of images and matches cannot be used. The text names file, table, row and remedy.
class StoreError : public std::runtime_error {
 public:
  enum class Kind : std::uint8_t {
    kContent,  ///< something in the file is wrong
    kBusy,     ///< another program writes to it; nothing was changed
    kStorage   ///< it cannot be opened, read or written: permissions, a full disk
  };

  StoreError(Kind kind, const std::string& text) : std::runtime_error(text), kind_(kind) {}
  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

/// Two different images by their numbers, the smaller one first.
struct ImagePairKey {
  std::uint32_t first = 0, second = 0;
};

inline bool operator==(const ImagePairKey& a, const ImagePairKey& b) {
  return a.first == b.first && a.second == b.second;
}
inline bool operator<(const ImagePairKey& a, const ImagePairKey& b) {
  return a.first != b.first ? a.first < b.first : a.second < b.second;
}

/// An image as its store describes it.
struct StoredImage {
  std::uint32_t id = 0;  ///< unique in its store
  std::string name;
  cv::Size size;  ///< px; 0x0 if unknown
  /// Calibration; absent where the store has none, or has a model that corrsel lacks.
  std::optional<Camera> camera;
  bool calibrated = false;  ///< whether the focal length is known and not only guessed; needs `camera`
};

/// The keypoints of one image, px with the centre of the first pixel at (0, 0).
struct StoredKeypoints {
  std::vector<cv::Point2f> positions;
  std::vector<AffineFrame> frames;  ///< empty, or one for every position
};

/// The putative matches of one pair.
struct StoredMatches {
  std::vector<KeypointPair> rows;
  std::vector<float> probability;  ///< empty, or the matcher's confidence in every row, from 0 to 1
};

/// Outcome of the verification of one pair.
struct VerifiedPair {
  ImagePairKey pair;
  TwoViewGeometry geometry;
  std::size_t putative = 0;  ///< number of matches that were given
  Status status = Status::kOk;
  SceneKind scene = SceneKind::kUnknown;
  double confidence = 0;  ///< see Selection::confidence; NaN if the selector has none
  /// How well a second, geometrically different relation explains the matches, from 0 (none does) to 1 (as
  /// well as the first one); NaN where it was not examined. See ambiguity.h.
  double ambiguity = 0;
  std::string message;  ///< why a pair was rejected or could not be read; empty otherwise
  bool faulty = false;  ///< whether the store's rows of the pair cannot be used; such a pair is not written
};

/// A file, or several files, with images, keypoints, putative matches and verified pairs. Implementations:
/// COLMAP's databases (colmap_store.h) and the HDF5 files of hloc (hloc_store.h).
///
/// Not thread-safe: verify() calls one member at a time.
class PairStore {
 public:
  virtual ~PairStore() = default;

  /// All images in the order of their numbers.
  virtual const std::vector<StoredImage>& images() const = 0;

  /// All pairs with putative matches, in ascending order.
  virtual std::vector<ImagePairKey> pairs() const = 0;

  /// Throws StoreError naming the image and what is wrong with its rows.
  virtual StoredKeypoints keypoints(std::uint32_t image) const = 0;

  /// Putative matches of a pair of images(). Throws StoreError naming the pair where it has none, and what is
  /// wrong with its rows.
  virtual StoredMatches matches(const ImagePairKey& pair) const = 0;

  /// The pairs whose verification with these settings is stored already, in ascending order. Their rows are
  /// read by verified().
  /// @param configuration  settings as text; equal texts give equal results
  virtual std::vector<ImagePairKey> verifiedPairs(const std::string& configuration) const = 0;

  /// A stored verification, without its message.
  virtual VerifiedPair verified(const ImagePairKey& pair) const = 0;

  /// Stores the verifications of several pairs, all of them or, where it throws, none. Rows of these pairs
  /// that are there are replaced. Throws StoreError.
  virtual void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) = 0;
};

}  // namespace corrsel::core
