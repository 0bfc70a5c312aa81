#include "five_point.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "corrsel/random.h"
#include "geometry/five_point.h"

namespace corrsel::performance {
namespace {

using Samples = std::vector<core::FivePointSample>;

void setMatch(core::Random& random, const cv::Vec3d& translation, int match, core::FivePointSample& sample) {
  const double sine = 0.1, cosine = std::sqrt(1 - sine * sine);
  const cv::Matx33d rotation(cosine, 0, sine, 0, 1, 0, -sine, 0, cosine);
  const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), depth = random.uniform(4, 12);
  const cv::Vec3d point = depth * cv::Vec3d(x, y, 1), seen = rotation * point + translation;
  std::copy_n(cv::normalize(point).val, 3, sample.left[match]);
  std::copy_n(cv::normalize(seen).val, 3, sample.right[match]);
}

Samples makeSamples(std::size_t n) {
  core::Random random(1);
  Samples samples(n);
  for (core::FivePointSample& sample : samples) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    for (int match = 0; match < 5; ++match) setMatch(random, {x, y, z}, match, sample);
  }
  return samples;
}

Mask solutionsOf(const Samples& samples) {
  Mask bytes;
  for (std::size_t begin = 0; begin < samples.size(); begin += core::kFivePointBatch) {
    cv::Matx33d found[core::kFivePointBatch][core::kFivePointSolutions];
    int counts[core::kFivePointBatch];
    const int count = int(std::min<std::size_t>(core::kFivePointBatch, samples.size() - begin));
    core::essentialsFromFive(samples.data() + begin, count, found, counts);
    for (int k = 0; k < count; ++k) {
      const auto* const first = reinterpret_cast<const std::uint8_t*>(found[k]);
      bytes.insert(bytes.end(), first, first + std::size_t(counts[k]) * sizeof found[k][0]);
    }
  }
  return bytes;
}

}  // namespace

Method fivePoint(core::KernelLevel level, std::size_t n, bool same_outcome) {
  return {"five-point, " + core::toString(level),
          {MatchSceneKind::kSpace, n, kNotMeasured},
          1,
          [=](const std::vector<Scene>&) -> Call {
            return [level, samples = makeSamples(n)](std::size_t) {
              const core::KernelLevel before = core::kernelLevel();
              core::setKernelLevel(level);
              Mask outcome = solutionsOf(samples);
              core::setKernelLevel(before);
              return outcome;
            };
          },
          same_outcome};
}

}  // namespace corrsel::performance
