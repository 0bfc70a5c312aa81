#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <opencv2/core/matx.hpp>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/options.h"
#include "corrsel/pose_result.h"

namespace corrsel::core {

/// Options of RigMonitor.
struct RigMonitorOptions : OptionSet {
  double window = 5;         ///< s
  int max_pairs = 100;       ///< in the window
  int max_matches = 200;     ///< of a pair
  int min_matches = 100;     ///< in the window
  int grid = 3;              ///< regions along each side of the image
  double warn_angle = 0.1;   ///< degrees
  double error_angle = 0.3;  ///< degrees
  double hold = 2;           ///< s
  double learn = 0;          ///< s

  void visit(OptionVisitor& visitor) const override;

  /// Throws std::invalid_argument also if error_angle is below warn_angle.
  void check() const override;
};

/// What RigMonitor has found out. The texts returned by toString() are part of the file formats.
enum class RigState : std::uint8_t {
  kUnknown = 0,  ///< too few matches, or the reference is still being learned
  kOk = 1,
  kWarning = 2,  ///< the rig has turned by more than warn_angle
  kError = 3     ///< by more than error_angle
};

/// "unknown", "ok", "warning" or "error".
std::string toString(RigState state);

/// The epipolar errors of the matches of one region of the left image: signed tangent Sampson errors under
/// the reference, px. Beside a horizontal rig, they are positive where the right points lie too low.
struct RigRegion {
  std::size_t count = 0;  ///< matches in the window
  double median = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of those that the corrected pose brings to within 3 times the noise.
  double rms = std::numeric_limits<double>::quiet_NaN();
  double corrected_median = std::numeric_limits<double>::quiet_NaN();  ///< under the corrected pose
};

/// The state of a rig. Poses have a t of length 1; the length of the baseline does not show in matches.
struct RigReport {
  RigState state = RigState::kUnknown;
  std::string message;                 ///< a sentence for people
  std::size_t pairs = 0, matches = 0;  ///< in the window
  double seconds = 0;                  ///< from the oldest pair of the window to the newest, s
  std::vector<RigRegion> regions;      ///< grid * grid, row by row
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< of the errors under the estimated pose, px

  Pose calibrated;
  Pose reference;        ///< that from which deviations are measured: the calibrated pose, or the learned one
  bool learned = false;  ///< whether the reference was learned

  bool determined = false;  ///< whether the matches determine a pose; the rest is NaN if not
  /// The deviation from the reference in the parameters of PoseResult::covariance, with the
  /// translationBasis() of the reference: w1 w2 w3 a b, rad.
  cv::Vec<double, 5> deviation = cv::Vec<double, 5>::all(std::numeric_limits<double>::quiet_NaN());
  cv::Matx<double, 5, 5> covariance = cv::Matx<double, 5, 5>::all(std::numeric_limits<double>::quiet_NaN());
  /// Of each parameter, whether a deviation by warn_angle would be significant.
  std::array<bool, 5> observable{};
  /// The part of the deviation that is significant, see RigMonitor.
  cv::Vec<double, 5> shown = cv::Vec<double, 5>::all(std::numeric_limits<double>::quiet_NaN());
  double angle = std::numeric_limits<double>::quiet_NaN();  ///< size of `shown`, degrees
  bool agreed = false;  ///< whether `shown` explains what the regions of the image show
  Pose corrected;       ///< the calibrated pose, moved by `shown`
};

/// Watches a calibrated stereo rig: finds out from the selected matches of its pairs whether the cameras have
/// turned against each other since the calibration, and by how much.
///
/// Idea: Matches leave the epipolar lines of a rig that was bent. The rotation and the direction of the
/// baseline that put them back are the deviation, and what chance explains of it is left out.
///
/// Which matches: those that agree with the geometry that they show themselves, as the selector `auto` or
/// `pose` without a prior gives. A selector that judges them by the calibration discards those that show the
/// bend.
///
/// Algorithm: The window holds the matches of the last seconds, of each pair at most `max_matches`, spread
/// over the regions. A match whose place, 8 units of length (at least 8 px) wide in both images, the window
/// has already is left out, and so is a pair with more of them than others, because a rig at rest sees the
/// same errors again and again. A pose is fitted with the Geman-McClure loss (geometry/pose_fit.h); its scale
/// is 3 times the noise, which follows from the lower quartile of the errors, found anew until it falls no
/// more. Matches that may agree by chance are left out (calibrated/pose_refinement.h). The covariance of the
/// fit (poseCovariance()) takes the errors of the matches for independent. From 9 pairs on, it is enlarged
/// along the directions in which the sums of the pairs vary more than that: with C = L L^T and the
/// eigenvalues of L^-1 S L^-T, where S is the sandwich with the pairs as clusters (Liang and Zeger,
/// Biometrika 1986), by those above 1. So errors that all matches of a pair have in common, such as those of
/// vibration, count as one. Noise that a point keeps as long as it is seen remains unknown: with 0.2 px of it
/// beside 0.3 px of fresh noise, the standard deviations are too small by a factor of about 1.6.
///
/// The principal axes of the covariance along which the deviation exceeds 5 standard deviations make up its
/// significant part, `shown`; its angle is the larger one of those of the rotation and of the direction. For
/// this decision the covariance is enlarged a second time, with the regions of the image as clusters, if
/// there are at least 9. So what one region shows, such as a moving object before cameras that are not
/// synchronous, or a poorly calibrated lens, is not taken for a turn of the rig. The state rises when the
/// angle has been above the limit for `hold`, and falls when it has been below 0.8 times the limit as long.
/// Pairs that bring nothing new do not count as time, so a state stays while the rig stands still.
///
/// Not observable: the length of the baseline, ever. Of a horizontal rig, a rotation about the vertical axis
/// moves points along the epipolar lines, as another depth does; only the corners of wide images show it.
/// The direction of the baseline shows in near points only.
///
/// With `learn`, the pose that the matches show at first is the reference, and deviations are changes since
/// then; its covariance counts, too, and the median errors that the regions show then are no deviation.
///
/// Failure: pairs whose stamps go back begin a new window. Matches that are not finite are left out.
///
/// Cost: add() O(matches); report() O(matches in the window). Memory: 160 bytes per match of the
/// window. Nothing is random. Not thread-safe.
class RigMonitor {
 public:
  /// The calibrated pose: a point X of the left camera's frame is rotation * X + translation in the right
  /// one's. Throws std::invalid_argument for options out of range, a matrix that is no rotation (to 1e-4),
  /// and a translation that is 0 or not finite.
  RigMonitor(const RigMonitorOptions& options, const cv::Matx33d& rotation, const cv::Vec3d& translation);
  ~RigMonitor();

  /// Takes over the selected matches of one pair.
  /// @param time     of the pair, s
  /// @param matches  with both cameras, and the size of the left image there or in its camera
  /// @return how many matches the window got; 0 also if it has got a pair less than window / max_pairs before
  /// Throws std::invalid_argument for a time that is not finite, and for matches without cameras or size.
  std::size_t add(double time, const Correspondences& matches);

  /// Judges the window. The state changes here only, so call it regularly, for example once per second; a
  /// state needs to hold in at least two reports.
  RigReport report();

  const RigMonitorOptions& options() const;

 private:
  class Judge;
  std::unique_ptr<Judge> judge_;
};

}  // namespace corrsel::core
