#pragma once

#include <memory>
#include <string>

#include "corrsel/database/pair_store.h"
#include "corrsel/options.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/workspace.h"

namespace corrsel::core {

struct PairVerifierOptions : OptionSet {
  std::string selector = "auto";  ///< name, preset and options of a selector, as in createSelector()
  /// Threshold of the epipolar relation, px in an image of 1200 px width; scales with the width.
  double epipolar_threshold = 3;
  int min_matches = 15;       ///< smallest number of inliers of an accepted pair
  double min_confidence = 4;  ///< smallest confidence of an accepted pair
  bool ambiguity = true;      ///< examine whether a second relation explains the matches
  int seed = 0;

  void visit(OptionVisitor& visitor) const override;
};

/// Everything of a pair that its verification uses.
struct PairInput {
  ImagePairKey pair;
  const StoredImage* first = nullptr;
  const StoredImage* second = nullptr;
  std::shared_ptr<const StoredKeypoints> first_keypoints, second_keypoints;
  StoredMatches matches;
};

/// Decides whether two images show the same thing, and which relation holds between them.
///
/// Idea: A selector with a confidence decides which matches are inliers. What is written is what a program
/// that reconstructs scenes needs: every keypoint once, the kind of relation, and matrices that belong to
/// these inliers.
///
/// Algorithm: docs/verification.md.
///
/// Failure: verify() never throws because of data. Matches that name keypoints which are not there make the
/// pair faulty, with a message that names them.
///
/// Cost: that of the selector, and O(matches).
///
/// Thread-safe: verify() is const and re-entrant; every thread has a workspace of its own. The same input
/// gives the same bits.
class PairVerifier {
 public:
  /// Throws std::invalid_argument for options out of range and what createSelector() throws.
  explicit PairVerifier(const PairVerifierOptions& options = {});

  VerifiedPair verify(const PairInput& input, Workspace& workspace) const;

  /// The settings as text, for PairStore::write().
  std::string configuration() const;

 private:
  PairVerifierOptions options_;
  std::shared_ptr<const Selector> selector_;
};

}  // namespace corrsel::core
