#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// The HDF5 files of hloc (Sarlin et al., "From coarse to fine", CVPR 2019), one with features and one with
/// matches.
///
/// Features: NAME/keypoints, N x 2 or more columns of any floating type, of which the first two are used;
/// optionally NAME/image_size, width and height. NAME is the path of an image. Images are numbered from 1 in
/// byte order of their names.
///
/// Matches: A/B/matches0, for every keypoint of the first image the number of a keypoint of the second one,
/// or -1; optionally A/B/matching_scores0. A and B are names of images with '/' replaced by '-'. Older files
/// have the group A_B instead of A/B. Where a file has a pair more than once, A/B counts, then B/A, A_B and
/// B_A, where A is the image with the smaller number; all of them are written.
///
/// Output: A copy of the file of matches in which only inliers are left; the others are -1 with the score 0.
/// Groups get the attributes corrsel_status, corrsel_scene, corrsel_config (texts) and corrsel_confidence;
/// the file gets the attribute corrsel_configuration. Pairs without a result, such as those that could not be
/// read, keep no match and have the corrsel_status "not_verified". Until complete() is called, results are in
/// a database of SQLite named like the output with ".part" appended, because a file of HDF5 does not survive
/// the death of its writer. A run that was killed continues from it.
class HlocStore : public PairStore {
 public:
  /// @param output  the file that complete() writes; empty to only read
  /// Throws StoreError where files are missing, damaged or do not belong together, and where the output
  /// exists or is one of the files that are read.
  HlocStore(const std::filesystem::path& features, const std::filesystem::path& matches,
            const std::filesystem::path& output = {});
  ~HlocStore() override;

  const std::vector<StoredImage>& images() const override;
  std::vector<ImagePairKey> pairs() const override;
  StoredKeypoints keypoints(std::uint32_t image) const override;
  /// Scores are taken as probabilities where all of them are from 0 to 1 and not all are 0. Numbers below -1,
  /// and files of 16-bit numbers with more than 32767 keypoints in the second image, are refused: the numbers
  /// wrapped around when the file was written.
  StoredMatches matches(const ImagePairKey& pair) const override;
  std::vector<ImagePairKey> verifiedPairs(const std::string& configuration) const override;
  VerifiedPair verified(const ImagePairKey& pair) const override;
  void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) override;

  /// Writes the output with the results of a configuration and removes the ".part" file. Throws StoreError;
  /// then there is no output, and the results remain.
  void complete(const std::string& configuration);

  /// Sentences about the files that their user should read, e.g. groups that match an image with itself.
  const std::vector<std::string>& warnings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel::core
