#include "calibrated/chance_agreements.h"

#include <algorithm>

#include "geometry/essential.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kRepairedPerMatch = 16, kMaxRepaired = 20000;
constexpr double kSquaredFactor = 1.5 * 1.5;
constexpr double kMinExpected = 0.02, kMinExcess = 3;

/// Squared distance of the directions that the translation must explain.
double squaredDisplacement(const Pose& pose, const RayMatches& matches, std::size_t left, std::size_t right) {
  const cv::Vec3d moved = pose.rotation * matches.left.direction(left) - matches.right.direction(right);
  return moved.dot(moved);
}

/// Whether a re-paired match lies in front of both cameras.
bool isInFront(const Pose& pose, const RayMatches& matches, std::size_t left, std::size_t right,
               double threshold) {
  const ScaledDepths depths =
      scaledDepths(pose, matches.left.direction(left), matches.right.direction(right));
  const double limit = -threshold * (matches.left.pixelAngle(left) + matches.right.pixelAngle(right));
  return depths.left > limit && depths.right > limit;
}

double countWithin(const std::vector<double>& sorted, double value) {
  const auto low = std::lower_bound(sorted.begin(), sorted.end(), value / kSquaredFactor);
  const auto high = std::upper_bound(low, sorted.end(), value * kSquaredFactor);
  return static_cast<double>(high - low);
}

}  // namespace

bool ChanceAgreements::Expected::counts() const {
  return outliers < kMinExpected || agreeing - 1 >= kMinExcess * outliers;
}

ChanceAgreements::Expected ChanceAgreements::expectedAt(double squared_displacement) const {
  return {per_repaired_ * countWithin(repaired_, squared_displacement),
          countWithin(agreeing_, squared_displacement)};
}

void ChanceAgreements::clear() {
  repaired_.clear();
  agreeing_.clear();
  per_repaired_ = share_ = expected_ = 0;
}

void ChanceAgreements::measure(const Pose& pose, const RayMatches& matches, const RayColumns& columns,
                               const std::vector<std::uint32_t>& agreeing, std::size_t outliers,
                               double threshold) {
  const std::size_t n = matches.size();
  const auto squared_threshold = static_cast<float>(threshold * threshold);
  const cv::Matx33d essential = essentialOf(pose);
  errors_.resize(n);
  repaired_.clear();
  std::size_t drawn = 0;
  const std::size_t wanted = std::min(kRepairedPerMatch * n, kMaxRepaired);
  for (std::size_t shift = 1; shift < n && drawn < wanted; ++shift, drawn += n) {
    repairedErrors(essential, columns, shift, errors_.data());
    for (std::size_t i = 0; i < n; ++i) {
      if (!(errors_[i] <= squared_threshold)) continue;
      const std::size_t right = i + shift < n ? i + shift : i + shift - n;
      if (isInFront(pose, matches, i, right, threshold))
        repaired_.push_back(squaredDisplacement(pose, matches, i, right));
    }
  }
  share_ = drawn > 0 ? static_cast<double>(repaired_.size()) / static_cast<double>(drawn) : 0;
  per_repaired_ = drawn > 0 ? static_cast<double>(outliers) / static_cast<double>(drawn) : 0;
  agreeing_.clear();
  for (const std::uint32_t i : agreeing) agreeing_.push_back(squaredDisplacement(pose, matches, i, i));
  std::sort(repaired_.begin(), repaired_.end());
  std::sort(agreeing_.begin(), agreeing_.end());
  // An outlier that agrees is one more among the matches with its displacement.
  std::size_t counting = 0;
  for (const double displacement : repaired_) {
    const Expected expected = expectedAt(displacement);
    if (Expected{expected.outliers, expected.agreeing + 1}.counts()) ++counting;
  }
  expected_ = per_repaired_ * static_cast<double>(counting);
}

bool ChanceAgreements::counts(const Pose& pose, const RayMatches& matches, std::uint32_t match) const {
  return expectedAt(squaredDisplacement(pose, matches, match, match)).counts();
}

}  // namespace corrsel::core
