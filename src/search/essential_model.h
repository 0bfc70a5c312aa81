#pragma once

#include <cstdint>

#include "search/pose_model.h"

namespace corrsel::core {

/// The essential matrix of calibrated cameras, of whose motion nothing is known. Samples of five matches are
/// solved together (geometry/five_point.h).
class EssentialModel : public PoseModel {
 public:
  EssentialModel();

  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
  void solveBatch(const NormalizedMatches& matches, Hypotheses* batch, int count) const override;
};

}  // namespace corrsel::core
