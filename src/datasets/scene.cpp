#include "corrsel/datasets/scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr int kWidth = 1024, kHeight = 768;
constexpr double kNoise = 1.0, kFrameNoise = 0.1;
const cv::Point2d kCentre(kWidth / 2.0, kHeight / 2.0);

bool visible(const cv::Point2d& p) { return p.x >= 0 && p.y >= 0 && p.x <= kWidth - 1 && p.y <= kHeight - 1; }

cv::Point2d anywhere(Random& random) {
  return {random.uniform(0, kWidth - 1), random.uniform(0, kHeight - 1)};
}

/// Compilers evaluate function arguments in different orders: whatever is drawn has a statement of its own.
std::pair<cv::Point2d, cv::Point2d> wrongMatch(Random& random) {
  const cv::Point2d right = anywhere(random);
  const cv::Point2d left = anywhere(random);
  return {left, right};
}

cv::Point2d noise(Random& random) { return {kNoise * random.normal(), kNoise * random.normal()}; }

cv::Point2d projected(const cv::Matx33d& h, const cv::Point2d& p) {
  const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1);
  return {q[0] / q[2], q[1] / q[2]};
}

cv::Matx22d derivative(const cv::Matx33d& h, const cv::Point2d& p) {
  const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1);
  const double u = q[0] / q[2], v = q[1] / q[2];
  return {(h(0, 0) - u * h(2, 0)) / q[2], (h(0, 1) - u * h(2, 1)) / q[2],  //
          (h(1, 0) - v * h(2, 0)) / q[2], (h(1, 1) - v * h(2, 1)) / q[2]};
}

cv::Matx33d planeHomography() {
  const double angle = 8 * CV_PI / 180, c = 0.92 * std::cos(angle), s = 0.92 * std::sin(angle);
  const cv::Matx33d to_centre(1, 0, -kCentre.x, 0, 1, -kCentre.y, 0, 0, 1);
  const cv::Matx33d back(1, 0, kCentre.x, 0, 1, kCentre.y, 0, 0, 1);
  return back * cv::Matx33d(c, -s, 0, s, c, 0, 2e-5, 1e-5, 1) * to_centre;
}

cv::Matx22d similarity(Random& random, double smallest, double largest) {
  const double size = random.uniform(smallest, largest), angle = random.uniform(0, 2 * CV_PI);
  return {size * std::cos(angle), -size * std::sin(angle), size * std::sin(angle), size * std::cos(angle)};
}

AffineFrame frame(const cv::Matx22d& a, const cv::Point2d& p) {
  return {float(a(0, 0)), float(a(0, 1)), float(p.x), float(a(1, 0)), float(a(1, 1)), float(p.y)};
}

/// A correct match, inside both images.
std::pair<cv::Point2d, cv::Point2d> correctMatch(SceneKind kind, Random& random) {
  static const cv::Matx33d homography = planeHomography();
  constexpr double kFocal = 900, kAngle = 0.03;
  const cv::Vec3d shift(-0.6, 0.05, 0.05);
  for (;;) {
    cv::Point2d left = anywhere(random), right;
    if (kind == SceneKind::kPlane) {
      right = projected(homography, left) + noise(random);
    } else {
      const double depth = random.uniform(4, 12);
      const cv::Point2d ray = (left - kCentre) * (depth / kFocal);
      const cv::Vec3d seen = cv::Matx33d(std::cos(kAngle), 0, std::sin(kAngle), 0, 1, 0,  //
                                         -std::sin(kAngle), 0, std::cos(kAngle)) *
                                 cv::Vec3d(ray.x, ray.y, depth) +
                             shift;
      right = kCentre + kFocal / seen[2] * cv::Point2d(seen[0], seen[1]) + noise(random);
      left += noise(random);
    }
    if (visible(left) && visible(right)) return {left, right};
  }
}

}  // namespace

MatchScene makeScene(const SceneSpec& spec) {
  Random random(spec.seed);
  MatchScene scene;
  scene.inlier.assign(spec.n, 0);
  std::fill_n(scene.inlier.begin(), std::llround(spec.inlier_ratio * double(spec.n)), std::uint8_t{1});
  for (std::size_t i = spec.n; i > 1; --i) {
    std::swap(scene.inlier[i - 1], scene.inlier[random.index(std::uint32_t(i))]);
  }
  Correspondences& m = scene.matches;
  m.left_size = m.right_size = {kWidth, kHeight};
  const cv::Matx33d homography = planeHomography();
  for (const bool inlier : scene.inlier) {
    auto [left, right] = inlier ? correctMatch(spec.kind, random) : wrongMatch(random);
    m.add(left, right);
    const double ratio = inlier ? 0.60 + 0.12 * random.normal() : 0.78 + 0.10 * random.normal();
    m.second_distance.push_back(float(random.uniform(200, 400)));
    m.distance.push_back(float(std::clamp(ratio, 0.05, 1.0)) * m.second_distance.back());
    if (spec.kind != SceneKind::kPlane) continue;
    const cv::Matx22d left_frame = similarity(random, 5, 15);
    cv::Matx22d change = similarity(random, 0.5, 2);
    if (inlier) {
      cv::Matx22d error = cv::Matx22d::eye();
      for (const int element : {3, 2, 1, 0}) error.val[element] += kFrameNoise * random.normal();
      change = derivative(homography, left) * error;
    }
    m.left_frame.push_back(frame(left_frame, left));
    m.right_frame.push_back(frame(change * left_frame, right));
  }
  if (spec.sorted) {
    std::vector<std::uint32_t> order(spec.n);
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&m](std::uint32_t a, std::uint32_t b) {
      return m.distance[a] / m.second_distance[a] < m.distance[b] / m.second_distance[b];
    });
    std::vector<std::uint8_t> inlier;
    for (const std::uint32_t row : order) inlier.push_back(scene.inlier[row]);
    scene.inlier = inlier;
    m = m.subset(order);
  }
  for (std::size_t i = 0; i < spec.n; ++i) {
    scene.left.emplace_back(m.left_x[i], m.left_y[i]);
    scene.right.emplace_back(m.right_x[i], m.right_y[i]);
  }
  return scene;
}

}  // namespace corrsel::core
