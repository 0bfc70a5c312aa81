#pragma once

#include <memory>
#include <string>

#include "corrsel/database/pair_store.h"
#include "corrsel/options.h"
#include "corrsel/workspace.h"

namespace corrsel::core {

struct PairVerifierOptions : OptionSet {
  std::string selector = "auto:fast";  ///< name, preset and options of a selector, as in createSelector()
  /// Inlier threshold of the epipolar relation, px in images of 1200 px width; it scales with the width.
  double epipolar_threshold = 3;
  int min_matches = 15;       ///< smallest number of inliers of an accepted pair
  double min_confidence = 7;  ///< smallest confidence of an accepted pair: chance gives one in 10^7 pairs
  bool ambiguity = true;      ///< examine whether a second relation explains the matches (ambiguity.h)
  int seed = 0;               ///< of the selectors

  void visit(OptionVisitor& visitor) const override;
};

/// Everything that the verification of a pair uses.
struct PairInput {
  ImagePairKey pair;
  const StoredImage* first = nullptr;                                        ///< never null
  const StoredImage* second = nullptr;                                       ///< never null
  std::shared_ptr<const StoredKeypoints> first_keypoints, second_keypoints;  ///< never null
  StoredMatches matches;
};

/// Decides whether two images show the same scene, and which relation holds between them.
///
/// Idea: A selector that computes a confidence decides which matches are inliers. What is stored is what
/// programs that reconstruct scenes need: every keypoint once, the kind of the relation, and matrices that
/// belong to these inliers.
///
/// Algorithm:
///  1. The selector gets positions and frames. Where it finds no model of its own, as `adalam`, its matches
///     are given to `auto`, which does. Cameras are not used yet, because a wrong calibration must not
///     reject a pair, and because the search of a pose among outliers costs more than that of F.
///  2. A pair is accepted if the status is `ok`, the confidence is at least `min_confidence`, and
///     `min_matches` are left after every keypoint is kept in one match only: that with the best probability,
///     or else the best score.
///  3. A homography competes with a fundamental matrix: where the latter keeps 5 % and 8 more matches, its
///     inliers are stored, and otherwise the configuration is `planar_or_panoramic`.
///  4. Where both images are calibrated, the selector `pose` gets the inliers. If its essential matrix keeps
///     half of those of the fundamental matrix, the pair is `calibrated`, and of a homography it is `planar`
///     or `panoramic`. Otherwise the focal lengths do not hold, and nothing changes. That finds focal lengths
///     that are far too short; those that are too long explain most matches, too.
///  5. Several motions are one relation where it explains 80 % of the inliers; the others are dropped.
///     Otherwise they are stored as `multiple`, without a matrix.
///  6. With `ambiguity`, a second relation is searched among the matches of accepted pairs (ambiguity.h).
/// A pose is stored unless a plane leaves two. F of an essential matrix is stored for cameras without
/// distortion, because it is exact for these only.
///
/// Options: PairVerifierOptions.
///
/// Failure: verify() never throws because of data. Matches that name keypoints that are not there, and
/// positions more than 1 px outside the image, make the pair faulty, with a message that names them.
///
/// Cost: that of the selector and O(matches). A homography costs a second selection, and a pose that of the
/// selector `pose` among inliers.
///
/// Source: this package; docs/studies/verification.md has the measurements behind the limits.
///
/// verify() is const and re-entrant; every thread needs a workspace of its own. The same input gives the same
/// bits.
class PairVerifier {
 public:
  /// Throws std::invalid_argument for options out of range, and what createSelector() throws.
  explicit PairVerifier(const PairVerifierOptions& options = {});

  VerifiedPair verify(const PairInput& input, Workspace& workspace) const;

  /// The options as text, for PairStore::write().
  std::string configuration() const;

 private:
  PairVerifierOptions options_;
};

}  // namespace corrsel::core
