#include "corrsel/datasets/scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr int kWidth = 1024, kHeight = 768;
constexpr double kFocal = 900;
constexpr double kElementNoise = 0.1, kScaleNoise = 0.1, kAngleNoise = 6 * CV_PI / 180;
constexpr double kWindowStep = 80;  // px, kFacade
constexpr double kObjectScale = 1.1, kObjectAngle = 8 * CV_PI / 180;
const cv::Point2d kObjectMove(-40, 60);
const cv::Point2d kCentre(kWidth / 2.0, kHeight / 2.0);

bool visible(const cv::Point2d& p) { return p.x >= 0 && p.y >= 0 && p.x <= kWidth - 1 && p.y <= kHeight - 1; }

cv::Point2d anywhere(Random& random) {
  return {random.uniform(0, kWidth - 1), random.uniform(0, kHeight - 1)};
}

cv::Point2d noise(double deviation, Random& random) {
  return {deviation * random.normal(), deviation * random.normal()};
}

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

cv::Matx22d scaledRotation(double scale, double angle) {
  return {scale * std::cos(angle), -scale * std::sin(angle), scale * std::sin(angle),
          scale * std::cos(angle)};
}

/// Scales and turns about `centre`, then moves.
cv::Matx33d similarityAbout(const cv::Point2d& centre, double scale, double angle, const cv::Point2d& move) {
  const cv::Matx22d a = scaledRotation(scale, angle);
  const cv::Vec2d t =
      cv::Vec2d(centre.x + move.x, centre.y + move.y) - cv::Vec2d(a * cv::Vec2d(centre.x, centre.y));
  return {a(0, 0), a(0, 1), t[0], a(1, 0), a(1, 1), t[1], 0, 0, 1};
}

cv::Matx33d planeHomography() {
  const double angle = 8 * CV_PI / 180, c = 0.92 * std::cos(angle), s = 0.92 * std::sin(angle);
  const cv::Matx33d to_centre(1, 0, -kCentre.x, 0, 1, -kCentre.y, 0, 0, 1);
  const cv::Matx33d back(1, 0, kCentre.x, 0, 1, kCentre.y, 0, 0, 1);
  return back * cv::Matx33d(c, -s, 0, s, c, 0, 2e-5, 1e-5, 1) * to_centre;
}

cv::Matx33d rotationAbout(int axis, double angle) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  cv::Matx33d rotation = cv::Matx33d::eye();
  rotation(a, a) = rotation(b, b) = std::cos(angle);
  rotation(b, a) = std::sin(angle);
  rotation(a, b) = -rotation(b, a);
  return rotation;
}

/// The plane normal . X = 1, which does not contain the left camera.
using Plane = cv::Vec3d;

/// The motion of the right camera against the left one: X' = rotation X + shift.
struct Motion {
  cv::Matx33d rotation = cv::Matx33d::eye();
  cv::Vec3d shift;

  /// The homography that maps the left image of a plane to the right one, px.
  cv::Matx33d homography(const Plane& plane) const {
    static const cv::Matx33d camera(kFocal, 0, kCentre.x, 0, kFocal, kCentre.y, 0, 0, 1);
    static const cv::Matx33d rays(1 / kFocal, 0, -kCentre.x / kFocal, 0, 1 / kFocal, -kCentre.y / kFocal, 0,
                                  0, 1);
    return camera * (rotation + shift * plane.t()) * rays;
  }
};

cv::Vec3d ray(const cv::Point2d& p) { return {(p.x - kCentre.x) / kFocal, (p.y - kCentre.y) / kFocal, 1}; }

/// The plane that the camera sees at a pixel.
const Plane& nearest(const std::vector<Plane>& planes, const cv::Point2d& p) {
  return *std::max_element(planes.begin(), planes.end(), [view = ray(p)](const Plane& a, const Plane& b) {
    return a.dot(view) < b.dot(view);  // the inverse depths
  });
}

/// Left and right wall, floor, ceiling and end of a corridor.
const std::vector<Plane>& corridor() {
  static const std::vector<Plane> planes = {
      {-1 / 2.2, 0, 0}, {1 / 2.2, 0, 0}, {0, 1 / 1.7, 0}, {0, -1 / 1.7, 0}, {0, 0, 1 / 20.0}};
  return planes;
}

/// The object of kMovingObject, left image.
cv::Rect2d objectPlace(double share) {
  const double side = std::sqrt(share);
  return {0.55 * kWidth - side * kWidth / 2, 0.5 * kHeight - side * kHeight / 2, side * kWidth,
          side * kHeight};
}

cv::Matx33d objectHomography(double share) {
  const cv::Rect2d place = objectPlace(share);
  const cv::Point2d centre(place.x + place.width / 2, place.y + place.height / 2);
  return similarityAbout(centre, kObjectScale, kObjectAngle, kObjectMove);
}

/// Whether the object hides a point of the background in the right image.
bool hidden(double share, const cv::Point2d& right) {
  const cv::Rect2d place = objectPlace(share);
  const cv::Point2d centre(place.x + place.width / 2, place.y + place.height / 2);
  const cv::Matx33d back =
      similarityAbout(centre + kObjectMove, 1 / kObjectScale, -kObjectAngle, -kObjectMove);
  return place.contains(projected(back, right));
}

/// What a point of the scene does between the images.
struct PointMotion {
  cv::Matx33d homography;  ///< of its neighbourhood
  std::uint8_t structure = 1;
};

PointMotion motionAt(const SceneSpec& spec, const cv::Point2d& left, Random& random) {
  static const cv::Matx33d plane = planeHomography();
  static const cv::Matx33d turned = Motion{
      rotationAbout(1, 10 * CV_PI / 180) * rotationAbout(0, 3 * CV_PI / 180) *
          rotationAbout(2, 5 * CV_PI / 180),
      {}}.homography({});
  static const Motion sideways{rotationAbout(1, 0.03), {-0.6, 0.05, 0.05}},
      forward{cv::Matx33d::eye(), {0, 0, -1}};
  // A vertical edge at depth 6, from which the two sides recede.
  static const std::vector<Plane> corner = {{-0.12, 0, 1 / 6.0}, {0.1, 0, 1 / 6.0}};
  switch (spec.kind) {
    case MatchSceneKind::kPlane:
    case MatchSceneKind::kFacade:
      return {plane};
    case MatchSceneKind::kSpace:
      return {sideways.homography({0, 0, 1 / random.uniform(4, 12)})};
    case MatchSceneKind::kRest:
      return {cv::Matx33d::eye()};
    case MatchSceneKind::kRotation:
      return {turned};
    case MatchSceneKind::kForward:
      return {forward.homography(nearest(corridor(), left))};
    case MatchSceneKind::kMovingObject:
    case MatchSceneKind::kPassingObject:
      if (objectPlace(spec.object_share).contains(left)) return {objectHomography(spec.object_share), 2};
      if (spec.kind == MatchSceneKind::kPassingObject) return {cv::Matx33d::eye()};
      return {sideways.homography(nearest(corridor(), left))};
    case MatchSceneKind::kTwoPlanes: {
      const cv::Vec3d view = ray(left);
      return {sideways.homography(corner[0].dot(view) < corner[1].dot(view) ? corner[0] : corner[1])};
    }
    case MatchSceneKind::kWall:
      return {sideways.homography({0, 0, 1 / (8 + random.uniform(-1.5, 1.5))})};
  }
  return {};
}

/// A match before its descriptor distances and frames are drawn.
struct Drawn {
  cv::Point2d left, right;
  cv::Matx22d map;  ///< of the neighbourhoods, left to right
  std::uint8_t structure = 0;
  bool random_map = true;
};

/// A correct match, inside both images.
Drawn drawInlier(const SceneSpec& spec, Random& random) {
  for (;;) {
    Drawn match;
    match.left = anywhere(random);
    const PointMotion motion = motionAt(spec, match.left, random);
    match.right = projected(motion.homography, match.left);
    const bool has_object =
        spec.kind == MatchSceneKind::kMovingObject || spec.kind == MatchSceneKind::kPassingObject;
    if (has_object && motion.structure == 1 && hidden(spec.object_share, match.right)) continue;
    match.right += noise(spec.noise, random);
    match.map = derivative(motion.homography, match.left);
    match.structure = motion.structure;
    match.random_map = false;
    if (spec.kind == MatchSceneKind::kSpace) match.left += noise(spec.noise, random);
    if (visible(match.left) && visible(match.right)) return match;
  }
}

/// A window taken for one of its neighbours, inside both images.
Drawn mistakenWindow(const SceneSpec& spec, Random& random) {
  for (;;) {
    Drawn match = drawInlier(spec, random);
    const auto steps = static_cast<double>(1 + random.index(3));
    const cv::Point2d other =
        match.left + cv::Point2d(random.index(2) == 0 ? steps * kWindowStep : -steps * kWindowStep, 0);
    const cv::Matx33d homography = motionAt(spec, other, random).homography;
    match.right = projected(homography, other) + noise(spec.noise, random);
    match.structure = 0;
    if (visible(match.right)) return match;
  }
}

/// Compilers evaluate function arguments in different orders: whatever is drawn has a statement of its own.
Drawn drawOutlier(const SceneSpec& spec, Random& random) {
  if (spec.kind == MatchSceneKind::kFacade && random.index(2) == 0) return mistakenWindow(spec, random);
  Drawn match;
  match.right = anywhere(random);
  match.left = anywhere(random);
  return match;
}

cv::Matx22d similarity(Random& random, double smallest, double largest) {
  const double size = random.uniform(smallest, largest), angle = random.uniform(0, 2 * CV_PI);
  return scaledRotation(size, angle);
}

AffineFrame frame(const cv::Matx22d& a, const cv::Point2d& p) {
  return {float(a(0, 0)), float(a(0, 1)), float(p.x), float(a(1, 0)), float(a(1, 1)), float(p.y)};
}

void addFrames(const SceneSpec& spec, const Drawn& match, Random& random, Correspondences& matches) {
  const cv::Matx22d left = similarity(random, 5, 15);
  cv::Matx22d change = similarity(random, 0.5, 2);
  if (!match.random_map) {
    cv::Matx22d error = cv::Matx22d::eye();
    if (spec.kind == MatchSceneKind::kPlane) {
      for (const int element : {3, 2, 1, 0}) error.val[element] += kElementNoise * random.normal();
    } else {
      const double scale = std::exp(kScaleNoise * random.normal());
      error = scaledRotation(scale, kAngleNoise * random.normal());
    }
    change = spec.noise > 0 ? match.map * error : match.map;
  }
  matches.left_frame.push_back(frame(left, match.left));
  matches.right_frame.push_back(frame(change * left, match.right));
}

}  // namespace

MatchScene makeScene(const SceneSpec& spec) {
  Random random(spec.seed);
  // The points of other kinds than kPlane do not depend on their frames.
  Random of_frames(~spec.seed);
  MatchScene scene;
  scene.inlier.assign(spec.n, 0);
  std::fill_n(scene.inlier.begin(), std::llround(spec.inlier_ratio * double(spec.n)), std::uint8_t{1});
  for (std::size_t i = spec.n; i > 1; --i) {
    std::swap(scene.inlier[i - 1], scene.inlier[random.index(std::uint32_t(i))]);
  }
  Correspondences& m = scene.matches;
  m.left_size = m.right_size = {kWidth, kHeight};
  const bool repetitive = spec.kind == MatchSceneKind::kFacade;
  for (const bool inlier : scene.inlier) {
    const Drawn match = inlier ? drawInlier(spec, random) : drawOutlier(spec, random);
    m.add(match.left, match.right);
    scene.structure.push_back(match.structure);
    const double ratio = repetitive ? 0.85 + 0.08 * random.normal()
                         : inlier   ? 0.60 + 0.12 * random.normal()
                                    : 0.78 + 0.10 * random.normal();
    m.second_distance.push_back(float(random.uniform(200, 400)));
    m.distance.push_back(float(std::clamp(ratio, 0.05, 1.0)) * m.second_distance.back());
    addFrames(spec, match, spec.kind == MatchSceneKind::kPlane ? random : of_frames, m);
  }
  if (spec.sorted) {
    std::vector<std::uint32_t> order(spec.n);
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&m](std::uint32_t a, std::uint32_t b) {
      return m.distance[a] / m.second_distance[a] < m.distance[b] / m.second_distance[b];
    });
    std::vector<std::uint8_t> inlier, structure;
    for (const std::uint32_t row : order) {
      inlier.push_back(scene.inlier[row]);
      structure.push_back(scene.structure[row]);
    }
    scene.inlier = inlier;
    scene.structure = structure;
    m = m.subset(order);
  }
  if (!spec.frames) m.left_frame = m.right_frame = {};
  if (!spec.distances) m.distance = m.second_distance = {};
  if (!spec.sizes) m.left_size = m.right_size = {};
  for (std::size_t i = 0; i < spec.n; ++i) {
    scene.left.emplace_back(m.left_x[i], m.left_y[i]);
    scene.right.emplace_back(m.right_x[i], m.right_y[i]);
  }
  return scene;
}

Camera sceneCamera() {
  Camera camera;
  camera.matrix = {kFocal, 0, kCentre.x, 0, kFocal, kCentre.y, 0, 0, 1};
  camera.size = {kWidth, kHeight};
  return camera;
}

}  // namespace corrsel::core
