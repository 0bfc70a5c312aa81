#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/camera_formats.h"
#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// A database of COLMAP (SQLite), from version 3.4 on. See docs/verification.md for the tables and columns.
class ColmapStore : public PairStore {
 public:
  enum class Access { kRead, kWrite };

  /// Opens a database that exists. Throws StoreError where it is none, lacks a table or column (named), or
  /// cannot be written though it should be.
  /// @param busy_seconds  how long to wait for another program that writes
  explicit ColmapStore(const std::filesystem::path& path, Access access = Access::kRead,
                       double busy_seconds = 10);
  ~ColmapStore() override;

  /// Copies a database with what is in its write-ahead log. Throws StoreError, also where `to` exists. An
  /// incomplete copy is called like the copy with ".part" appended.
  static void copy(const std::filesystem::path& from, const std::filesystem::path& to);

  /// Like copy(), but continues with a copy that an earlier run has left. Throws StoreError, also where that
  /// one has other images.
  static void continueCopy(const std::filesystem::path& from, const std::filesystem::path& to);

  /// Creates an empty database with COLMAP's tables. Throws StoreError where the file exists.
  static void create(const std::filesystem::path& path);

  const std::vector<StoredImage>& images() const override;
  std::vector<ImagePairKey> pairs() const override;
  StoredKeypoints keypoints(std::uint32_t image) const override;
  StoredMatches matches(const ImagePairKey& pair) const override;
  std::vector<ImagePairKey> verifiedPairs(const std::string& configuration) const override;
  VerifiedPair verified(const ImagePairKey& pair) const override;
  void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) override;

  /// As pairs(), without warnings about what is missing, for programs that are about to match the others.
  std::vector<ImagePairKey> matchedPairs() const;

  /// The pairs whose verification another program has stored, or has stored anew since, in ascending order.
  std::vector<ImagePairKey> pairsOfOthers() const;

  /// Descriptors of an image, one row of 128 bytes a keypoint (CV_8U). Throws StoreError.
  cv::Mat descriptors(std::uint32_t image) const;

  /// Adds an image with its camera, keypoints and descriptors, in one transaction. @return its number.
  /// Throws StoreError, also where there is an image of this name, and std::invalid_argument for a camera
  /// that COLMAP lacks (see cameraToColmap()). Images with the same trusted camera share a row of it.
  /// @param image        without a camera, one with a guessed focal length is stored, as COLMAP does; its
  ///                     number is not used
  /// @param keypoints    with frames: six columns are stored, else two
  /// @param descriptors  CV_8U, one row a keypoint; without columns: none are stored
  /// @param given        stored as the camera instead of `image.camera`, whose model may differ
  /// @param one_camera   the image has the camera of the first image, if there is one
  std::uint32_t addImage(const StoredImage& image, const StoredKeypoints& keypoints,
                         const cv::Mat& descriptors, const std::optional<ColmapCamera>& given = {},
                         bool one_camera = false);

  /// Stores putative matches of several pairs in one transaction. Rows that are there are replaced, and what
  /// was verified of these pairs is removed. COLMAP has no place for StoredMatches::probability. Throws
  /// StoreError, also for matches beyond the keypoints.
  void writeMatches(const std::vector<std::pair<ImagePairKey, StoredMatches>>& matches);

  /// Sentences about the database that its user should read, e.g. cameras whose model corrsel lacks.
  const std::vector<std::string>& warnings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel::core
