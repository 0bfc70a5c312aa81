#include "search/prior_models.h"

#include "geometry/prior_solvers.h"

namespace corrsel::core {
namespace {

ModelTraits rotationTraits(ModelTraits traits) {
  traits.sample_size = 2;
  traits.sprt = {0, 0.02, 40, 1};
  return traits;
}

ModelTraits verticalTraits(ModelTraits traits) {
  traits.sample_size = 3;
  traits.sprt = {0, 0.02, 600, 2.5};
  return traits;
}

/// The rays of a sample.
template <int count>
void readSample(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Vec3d (&left)[count],
                cv::Vec3d (&right)[count]) {
  const std::size_t n = matches.size();
  for (int i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + sample[i];
      left[i][c] = matches.rays.left[at];
      right[i][c] = matches.rays.right[at];
    }
  }
}

}  // namespace

KnownRotationModel::KnownRotationModel() : PoseModel(rotationTraits(commonTraits())) {}

int KnownRotationModel::solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                              cv::Matx33d* models) const {
  cv::Vec3d left[2], right[2];
  readSample(matches, sample, left, right);
  Pose pose{prior_->rotation, {}};
  if (!translationFromTwo(pose.rotation, left, right, pose.translation)) return 0;
  models[0] = hypothesisOf(pose);
  return 1;
}

KnownVerticalModel::KnownVerticalModel() : PoseModel(verticalTraits(commonTraits())) {}

int KnownVerticalModel::solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                              cv::Matx33d* models) const {
  cv::Vec3d left[3], right[3];
  readSample(matches, sample, left, right);
  Pose poses[kVerticalSolutions];
  const int count = posesFromThree(prior_->left_down, prior_->right_down, left, right, poses);
  for (int k = 0; k < count; ++k) models[k] = hypothesisOf(poses[k]);
  return count;
}

}  // namespace corrsel::core
