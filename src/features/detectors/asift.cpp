#include "features/detectors/asift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "features/parts/dog_keypoints.h"
#include "features/parts/sift_descriptor.h"
#include "features/parts/tilted_views.h"
#include "points/place_index.h"

namespace corrsel::core {

void AsiftOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.integer({"tilts", 0, 8, "-", "ASIFT: simulated tilts sqrt(2)^k, k = 1 to this; 0 = plain SIFT"},
                  &AsiftOptions::tilts);
  visitor.number({"rotation_step", 10, 180, "degrees", "ASIFT: between views of tilt t: this / t"},
                 &AsiftOptions::rotation_step);
  visitor.number({"sigma", 0.8, 5, "px", "ASIFT: blur of the first octave"}, &AsiftOptions::sigma);
  visitor.integer({"octave_layers", 1, 10, "-", "ASIFT: layers per octave"}, &AsiftOptions::octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "ASIFT: extrema weaker than this are dropped"},
                 &AsiftOptions::contrast_threshold);
  visitor.number({"edge_threshold", 1, 100, "-", "ASIFT: edge-like extrema are dropped; larger keeps more"},
                 &AsiftOptions::edge_threshold);
  visitor.number(
      {"margin", 0, 20, "radii", "ASIFT: simulated views: smallest distance from the image border"},
      &AsiftOptions::margin);
  visitor.number({"merge_distance", 0, 5, "radii", "ASIFT: views of one keypoint are at most so far apart"},
                 &AsiftOptions::merge_distance);
  visitor.number({"merge_shape", 0, 5, "-", "ASIFT: and their frames differ at most by this"},
                 &AsiftOptions::merge_shape);
}

namespace {

struct ViewFeature {
  cv::KeyPoint keypoint;
  AffineFrame frame;
  std::array<std::uint8_t, kSiftLength> descriptor{};
};

/// One simulated camera: the image is rotated and then compressed vertically by the tilt.
struct View {
  double tilt = 1, turn = 0;
};

std::vector<View> viewsOf(const AsiftOptions& options) {
  std::vector<View> views = {{1, 0}};
  for (int k = 1; k <= options.tilts; ++k) {
    const double tilt = std::pow(2.0, 0.5 * k), step = options.rotation_step / tilt;
    for (int i = 0; i * step < 180; ++i) views.push_back({tilt, i * step * CV_PI / 180});
  }
  return views;
}

/// The features of one view, where `describe` also with descriptors.
std::vector<ViewFeature> viewFeatures(const cv::Mat& image, const TiltedViews& views, const View& view,
                                      int index, const AsiftOptions& options, const PlaceMask& mask,
                                      bool describe, Workspace& workspace) {
  TiltedView simulated{image, {1, 0, 0, 0, 1, 0}};
  if (view.tilt != 1) simulated = views.view(view.tilt, view.turn, workspace);
  const cv::Matx23d& m = simulated.to_image;
  const auto toImage = [&m](double x, double y) {
    return cv::Point2d(m(0, 0) * x + m(0, 1) * y + m(0, 2), m(1, 0) * x + m(1, 1) * y + m(1, 2));
  };
  // Pixels of the image per pixel of the view, perpendicular to the borders.
  const double x_slope = std::hypot(m(0, 0), m(0, 1)), y_slope = std::hypot(m(1, 0), m(1, 1));
  const double margin = view.tilt == 1 ? 0 : options.margin;
  DogOptions dog;
  dog.first_octave = 0;
  dog.octave_layers = options.octave_layers;
  dog.contrast_threshold = options.contrast_threshold;
  dog.edge_threshold = options.edge_threshold;
  dog.sigma = options.sigma;
  DogKeypoints& keypoints = workspace.part<DogKeypoints>();
  keypoints.find(simulated.pixels, dog, {}, 1);
  std::vector<ViewFeature> features;
  std::vector<float> angles;
  for (const DogKeypoint& keypoint : keypoints.keypoints()) {
    const cv::Point2d at = toImage(keypoint.x, keypoint.y);
    const double distance = std::min(std::min(at.x, image.cols - 1 - at.x) / x_slope,
                                     std::min(at.y, image.rows - 1 - at.y) / y_slope);
    if (distance < margin * keypoint.sigma) continue;
    keypoints.directions(keypoint, angles);
    for (const float direction : angles) {
      const double c = keypoint.sigma * std::cos(direction), s = keypoint.sigma * std::sin(direction);
      const double a11 = m(0, 0) * c + m(0, 1) * s, a12 = m(0, 1) * c - m(0, 0) * s;
      const double a21 = m(1, 0) * c + m(1, 1) * s, a22 = m(1, 1) * c - m(1, 0) * s;
      ViewFeature feature;
      feature.frame = {static_cast<float>(a11), static_cast<float>(a12), static_cast<float>(at.x),
                       static_cast<float>(a21), static_cast<float>(a22), static_cast<float>(at.y)};
      auto angle = static_cast<float>(std::atan2(a21, a11) * 180 / CV_PI);
      if (angle < 0) angle += 360;
      feature.keypoint = cv::KeyPoint(at, static_cast<float>(2 * keypoint.sigma * std::sqrt(view.tilt)),
                                      angle >= 360 ? 0 : angle, keypoint.response, keypoint.octave, index);
      // A masked feature may be the stronger one with which others are merged, but it is not returned.
      if (describe && mask.allows(feature.keypoint.pt)) {
        const auto fc = static_cast<float>(c), fs = static_cast<float>(s);
        std::array<float, kSiftLength> descriptor;
        siftDescriptor(keypoints.levelOf(keypoint), {fc, -fs, keypoint.x, fs, fc, keypoint.y},
                       descriptor.data());
        std::transform(descriptor.begin(), descriptor.end(), feature.descriptor.begin(),
                       [](float value) { return static_cast<std::uint8_t>(value); });
      }
      features.push_back(feature);
    }
  }
  return features;
}

/// Frobenius norm of A^-1 B - I, and |A^-1 (q - p)|, for the frames A at p (kept) and B at q.
double difference(const AffineFrame& kept, const AffineFrame& other, double& distance) {
  const double a = kept[0], b = kept[1], c = kept[3], d = kept[4], det = a * d - b * c;
  const double dx = double(other[2]) - kept[2], dy = double(other[5]) - kept[5];
  distance = std::hypot(d * dx - b * dy, a * dy - c * dx) / std::abs(det);
  const double m00 = (d * other[0] - b * other[3]) / det - 1, m01 = (d * other[1] - b * other[4]) / det;
  const double m10 = (a * other[3] - c * other[0]) / det, m11 = (a * other[4] - c * other[1]) / det - 1;
  return std::sqrt(m00 * m00 + m01 * m01 + m10 * m10 + m11 * m11);
}

/// The features that remain after merging (see the class), strongest first.
std::vector<ViewFeature> merged(std::vector<ViewFeature> features, const AsiftOptions& options) {
  std::stable_sort(features.begin(), features.end(), [](const ViewFeature& a, const ViewFeature& b) {
    return a.keypoint.response > b.keypoint.response;
  });
  // Level l holds frames that reach up to 2^l px.
  struct Level {
    PlaceIndex places;
    std::vector<std::uint32_t> kept;  // by number of the place
  };
  std::vector<Level> levels;
  std::vector<ViewFeature> kept;
  for (const ViewFeature& feature : features) {
    const double x = feature.keypoint.pt.x, y = feature.keypoint.pt.y;
    bool is_new = true;
    for (std::size_t l = 0; l < levels.size() && is_new; ++l) {
      const double side = std::ldexp(1.0, int(l));
      is_new = !levels[l].places.visitNear(x, y, side, side, [&](std::uint32_t place) {
        double distance;
        return difference(kept[levels[l].kept[place]].frame, feature.frame, distance) <=
                   options.merge_shape &&
               distance <= options.merge_distance;
      });
    }
    if (!is_new) continue;
    const AffineFrame& f = feature.frame;
    const double reach = options.merge_distance * std::hypot(std::hypot(f[0], f[1]), std::hypot(f[3], f[4]));
    const auto level = static_cast<std::size_t>(std::max(0.0, std::ceil(std::log2(std::max(reach, 1e-3)))));
    while (levels.size() <= level) {
      const auto side = std::ldexp(1.0F, static_cast<int>(levels.size()));
      levels.emplace_back();
      levels.back().places.clear(features.size(), side);
    }
    levels[level].places.add(feature.keypoint.pt.x, feature.keypoint.pt.y);
    levels[level].kept.push_back(static_cast<std::uint32_t>(kept.size()));
    kept.push_back(feature);
  }
  return kept;
}

/// The merged features of all views, strongest first.
std::vector<ViewFeature> allFeatures(const DetectionRequest& request, const AsiftOptions& options) {
  const std::vector<View> views = viewsOf(options);
  const TiltedViews simulator(request.image);
  std::vector<std::vector<ViewFeature>> found(views.size());
  forEachBlock(views.size(), 1, request.threads, [&](std::size_t i, std::size_t) {
    found[i] = viewFeatures(request.image, simulator, views[i], static_cast<int>(i), options, request.mask,
                            request.describe, Workspace::ofThread());
  });
  std::vector<ViewFeature> all;
  for (const std::vector<ViewFeature>& some : found) all.insert(all.end(), some.begin(), some.end());
  return merged(std::move(all), options);
}

}  // namespace

AsiftDetector::AsiftDetector(const AsiftOptions& options) : options_(options) { options_.check(); }

void AsiftDetector::detect(const DetectionRequest& request, Features& features) const {
  const std::vector<ViewFeature> all = allFeatures(request, options_);
  features.keypoints.clear();
  features.frames.clear();
  features.descriptors.release();
  if (request.describe) {
    features.descriptors.create(static_cast<int>(all.size()), kSiftLength, CV_32F);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    features.keypoints.push_back(all[i].keypoint);
    features.frames.push_back(all[i].frame);
    if (!request.describe) continue;
    std::copy(all[i].descriptor.begin(), all[i].descriptor.end(),
              features.descriptors.ptr<float>(static_cast<int>(i)));
  }
  request.mask.apply(features);
}

}  // namespace corrsel::core
