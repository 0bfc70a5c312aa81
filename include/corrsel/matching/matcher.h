#pragma once

#include "corrsel/correspondences.h"
#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct MatchOptions : OptionSet {
  bool mutual = false;                ///< keep matches whose features are nearest to each other
  double second_distance_radius = 0;  ///< px; 0 = no condition on the second nearest

  void visit(OptionVisitor& visitor) const override;
};

/// Turns the features of two images into putative matches. A package that has a matcher of its own, such as a
/// network, derives from this class and exports it with pluginlib; the nodelet corrsel/Matcher then loads it
/// by its name (docs/live.md).
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// Sets options by their names, once, before the first call of match(). Those that are not named keep their
  /// default values. Throws std::invalid_argument that names an option that is unknown or out of range. A
  /// matcher that does not override it has no options.
  virtual void configure(const OptionMap& options);

  /// Matches the features of two images. Calls come one after the other, not always from the same thread.
  /// @return matches whose left_index and right_index are numbers of these features. A matcher that knows how
  /// likely each match is right fills the column `probability`, and one that compares descriptors `distance`.
  /// Throws std::exception for features that it cannot match.
  virtual Correspondences match(const Features& left, const Features& right) = 0;
};

/// Putative matches between two images.
///
/// Idea: The right feature with the most similar descriptor is a candidate for every left feature. There is
/// no ratio test, since the selectors decide which matches are correct; the distances they need are kept.
///
/// Algorithm: Exact search by comparing all descriptors, see findNeighbours(): L2 distance (not squared) for
/// CV_32F, Hamming distance for CV_8U. Equal distances are resolved by the lowest index. Several left
/// features may have the same right feature. With `mutual`, only features that are each other's nearest are
/// matched.
///
/// Input: One descriptor per keypoint; the descriptors of both images have the same type and length.
///
/// Options: MatchOptions.
///
/// Failure: Without features on one side there are no matches. Descriptors that contain NaN are not matched.
/// The second distance is NaN where there is only one right feature, or none at second_distance_radius or
/// more from the nearest one. Throws std::invalid_argument for descriptors whose type or length differs
/// between the images, for a number of descriptors other than that of the keypoints, and for options out of
/// range.
///
/// Cost: O(N_left * N_right * D) time and O((N_left + N_right) * D) memory.
///
/// @param threads  threads that may be used; the result does not depend on it
Correspondences matchFeatures(const Features& left, const Features& right, const MatchOptions& options = {},
                              int threads = 1);

/// matchFeatures() as a Matcher, with the options of MatchOptions.
class DescriptorMatcher : public Matcher {
 public:
  /// @param threads  threads that may be used; the result does not depend on it
  explicit DescriptorMatcher(int threads = 1) : threads_(threads) {}

  void configure(const OptionMap& options) override;
  Correspondences match(const Features& left, const Features& right) override;

 private:
  int threads_;
  MatchOptions options_;
};

}  // namespace corrsel::core
