#pragma once

#include <opencv2/core/matx.hpp>

#include "auto/evidence.h"
#include "auto/memory.h"
#include "corrsel/selectors/auto.h"

namespace corrsel::core {

/// Gathers the evidence about the matches of a call, each piece at most once.
class Gathering {
 public:
  /// @param memory  with the matches; must outlive the object, like all parameters
  Gathering(const AutoOptions& options, AutoMemory& memory, Effort& effort)
      : options_(options), memory_(memory), effort_(effort) {}

  /// Gathers what every decision needs: local support, and the best homography unless the answer is
  /// restricted to a fundamental matrix.
  void start();

  void gather(Need need);

  /// Searches the pose, if both cameras are given and it is not known yet.
  void findPose();

  const Evidence& evidence() const { return evidence_; }

 private:
  void sortBySupport();
  void findHomography();
  void addHomographyLeftover();
  void addParallax();
  bool isCalibrated() const { return memory_.matches.left_camera && memory_.matches.right_camera; }
  FundamentalEvidence essential();
  FundamentalEvidence fundamental();
  void addFundamental();
  void addFundamentalLeftover();

  const AutoOptions& options_;
  AutoMemory& memory_;
  Effort& effort_;
  Evidence evidence_;
  cv::Matx33d normalized_homography_, parallax_fundamental_;
};

}  // namespace corrsel::core
