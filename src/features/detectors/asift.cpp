#include "features/detectors/asift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "features/parts/fast_sift.h"

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
  visitor.number({"margin", 0, 20, "radii", "ASIFT: simulated views: least distance from the image border"},
                 &AsiftOptions::margin);
  visitor.number({"merge_distance", 0, 5, "radii", "ASIFT: views of one keypoint are at most so far apart"},
                 &AsiftOptions::merge_distance);
  visitor.number({"merge_shape", 0, 5, "-", "ASIFT: and their frames differ at most by this"},
                 &AsiftOptions::merge_shape);
}

namespace {

constexpr int kDescriptorLength = 128;

struct ViewFeature {
  cv::KeyPoint keypoint;
  AffineFrame frame;
  std::array<std::uint8_t, kDescriptorLength> descriptor;
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

struct SimulatedView {
  cv::Mat pixels;        ///< CV_32F, 0..255
  cv::Matx23d to_image;  ///< from its pixels to those of the image
};

/// The image, rotated by OpenCV in strips that are too small for its own threads.
cv::Mat turned(const cv::Mat& image, const cv::Matx23d& to_image, const cv::Size& size) {
  constexpr int kSerialPixels = 1 << 16;
  cv::Mat result(size, CV_8U);
  const int rows = std::max(1, kSerialPixels / size.width);
  for (int top = 0; top < size.height; top += rows) {
    cv::Mat strip = result.rowRange(top, std::min(top + rows, size.height));
    cv::Matx23d map = to_image;
    map(0, 2) += map(0, 1) * top;
    map(1, 2) += map(1, 1) * top;
    cv::warpAffine(image, strip, map, strip.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REPLICATE);
  }
  return result;
}

/// Every tilt-th row, after a blur that prevents aliasing.
cv::Mat compressed(const cv::Mat& image, double tilt) {
  const double sigma = 0.8 * std::sqrt(tilt * tilt - 1);
  const int rows = static_cast<int>(std::floor((image.rows - 1) / tilt)) + 1;
  cv::Mat result(rows, image.cols, CV_32F);
  std::vector<float> weights;
  for (int row = 0; row < rows; ++row) {
    const double centre = row * tilt;
    const int first = std::max(0, static_cast<int>(std::ceil(centre - 3 * sigma)));
    const int last = std::min(image.rows - 1, static_cast<int>(std::floor(centre + 3 * sigma)));
    double sum = 0;
    weights.clear();
    for (int y = first; y <= last; ++y) {
      const double d = (y - centre) / sigma;
      weights.push_back(static_cast<float>(std::exp(-0.5 * d * d)));
      sum += weights.back();
    }
    float* const out = result.ptr<float>(row);
    std::fill(out, out + image.cols, 0.0F);
    for (int y = first; y <= last; ++y) {
      const auto weight = static_cast<float>(weights[static_cast<std::size_t>(y - first)] / sum);
      const std::uint8_t* const in = image.ptr<std::uint8_t>(y);
      for (int x = 0; x < image.cols; ++x) out[x] += weight * static_cast<float>(in[x]);
    }
  }
  return result;
}

SimulatedView simulate(const cv::Mat& image, const View& view) {
  SimulatedView result;
  if (view.tilt == 1) {
    image.convertTo(result.pixels, CV_32F);
    result.to_image = {1, 0, 0, 0, 1, 0};
    return result;
  }
  const double c = std::cos(view.turn), s = std::sin(view.turn);
  const double right = image.cols - 1, bottom = image.rows - 1;
  // x' = c x + s y, y' = -s x + c y
  const double left_edge = std::min({0.0, c * right, s * bottom, c * right + s * bottom});
  const double right_edge = std::max({0.0, c * right, s * bottom, c * right + s * bottom});
  const double top_edge = std::min({0.0, -s * right, c * bottom, c * bottom - s * right});
  const double bottom_edge = std::max({0.0, -s * right, c * bottom, c * bottom - s * right});
  const cv::Size size(static_cast<int>(std::ceil(right_edge - left_edge)) + 1,
                      static_cast<int>(std::ceil(bottom_edge - top_edge)) + 1);
  const cv::Matx23d back(c, -s, c * left_edge - s * top_edge, s, c, s * left_edge + c * top_edge);
  result.pixels = compressed(turned(image, back, size), view.tilt);
  result.to_image = back;
  result.to_image(0, 1) *= view.tilt;
  result.to_image(1, 1) *= view.tilt;
  return result;
}

std::vector<ViewFeature> viewFeatures(const cv::Mat& image, const View& view, int index,
                                      const AsiftOptions& options, bool with_descriptors) {
  const SimulatedView simulated = simulate(image, view);
  const cv::Matx23d& m = simulated.to_image;
  const auto toImage = [&m](double x, double y) {
    return cv::Point2d(m(0, 0) * x + m(0, 1) * y + m(0, 2), m(1, 0) * x + m(1, 1) * y + m(1, 2));
  };
  // Pixels of the image per pixel of the view, perpendicular to the borders.
  const double x_slope = std::hypot(m(0, 0), m(0, 1)), y_slope = std::hypot(m(1, 0), m(1, 1));
  const double margin = view.tilt == 1 ? 0 : options.margin;
  const auto inside = [&](float x, float y, float sigma) {
    const cv::Point2d p = toImage(x, y);
    const double distance = std::min(std::min(p.x, image.cols - 1 - p.x) / x_slope,
                                     std::min(p.y, image.rows - 1 - p.y) / y_slope);
    return distance >= margin * sigma;
  };
  FastSiftParameters parameters;
  parameters.octave_layers = options.octave_layers;
  parameters.contrast_threshold = options.contrast_threshold;
  parameters.edge_threshold = options.edge_threshold;
  parameters.sigma = options.sigma;
  parameters.describe = with_descriptors;
  std::vector<ViewFeature> features;
  for (const FastSiftFeature& found : fastSift(simulated.pixels, parameters, inside)) {
    const double c = found.sigma * std::cos(found.angle), s = found.sigma * std::sin(found.angle);
    const cv::Point2d at = toImage(found.x, found.y);
    const double a11 = m(0, 0) * c + m(0, 1) * s, a12 = m(0, 1) * c - m(0, 0) * s;
    const double a21 = m(1, 0) * c + m(1, 1) * s, a22 = m(1, 1) * c - m(1, 0) * s;
    ViewFeature feature;
    feature.frame = {static_cast<float>(a11), static_cast<float>(a12), static_cast<float>(at.x),
                     static_cast<float>(a21), static_cast<float>(a22), static_cast<float>(at.y)};
    auto angle = static_cast<float>(std::atan2(a21, a11) * 180 / CV_PI);
    if (angle < 0) angle += 360;
    feature.keypoint = cv::KeyPoint(at, static_cast<float>(2 * found.sigma * std::sqrt(view.tilt)),
                                    angle >= 360 ? 0 : angle, found.response, found.octave, index);
    feature.descriptor = found.descriptor;
    features.push_back(feature);
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
  // Level l holds frames that reach up to 2^l px, in cells of twice this size, so each frame is in at most
  // four cells.
  using Grid = std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>;
  std::vector<Grid> levels;
  const auto cell = [](double x, double y, double side) {
    const auto number = [side](double v) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(static_cast<int>(std::floor(v / side))));
    };
    return number(y) << 32 | number(x);
  };
  std::vector<ViewFeature> kept;
  for (const ViewFeature& feature : features) {
    const double x = feature.keypoint.pt.x, y = feature.keypoint.pt.y;
    bool is_new = true;
    for (std::size_t l = 0; l < levels.size() && is_new; ++l) {
      const auto found = levels[l].find(cell(x, y, std::ldexp(2.0, int(l))));
      if (found == levels[l].end()) continue;
      for (const std::uint32_t i : found->second) {
        double distance;
        if (difference(kept[i].frame, feature.frame, distance) <= options.merge_shape &&
            distance <= options.merge_distance) {
          is_new = false;
          break;
        }
      }
    }
    if (!is_new) continue;
    const AffineFrame& f = feature.frame;
    const double reach = options.merge_distance * std::hypot(std::hypot(f[0], f[1]), std::hypot(f[3], f[4]));
    const auto level = static_cast<std::size_t>(std::max(0.0, std::ceil(std::log2(std::max(reach, 1e-3)))));
    if (level >= levels.size()) levels.resize(level + 1);
    const double side = std::ldexp(2.0, int(level));
    const auto number = static_cast<std::uint32_t>(kept.size());
    std::array<std::uint64_t, 4> cells = {cell(x - reach, y - reach, side), cell(x + reach, y - reach, side),
                                          cell(x - reach, y + reach, side), cell(x + reach, y + reach, side)};
    std::sort(cells.begin(), cells.end());
    const auto end = std::unique(cells.begin(), cells.end());
    for (auto c = cells.begin(); c != end; ++c) levels[level][*c].push_back(number);
    kept.push_back(feature);
  }
  return kept;
}

/// The merged features of all views, strongest first.
std::vector<ViewFeature> allFeatures(const cv::Mat& grey, int threads, const AsiftOptions& options,
                                     bool with_descriptors) {
  const std::vector<View> views = viewsOf(options);
  std::vector<std::vector<ViewFeature>> found(views.size());
  forEachBlock(views.size(), 1, threads, [&](std::size_t i, std::size_t) {
    found[i] = viewFeatures(grey, views[i], static_cast<int>(i), options, with_descriptors);
  });
  std::vector<ViewFeature> all;
  for (const std::vector<ViewFeature>& some : found) all.insert(all.end(), some.begin(), some.end());
  return merged(std::move(all), options);
}

}  // namespace

AsiftDetector::AsiftDetector(const AsiftOptions& options) : options_(options) { options_.check(); }

void AsiftDetector::detect(const DetectionRequest& request, Features& features) const {
  const std::vector<ViewFeature> all =
      allFeatures(request.image, request.threads, options_, request.describe);
  features.keypoints.clear();
  features.frames.clear();
  features.descriptors.release();
  if (request.describe) {
    features.descriptors.create(static_cast<int>(all.size()), kDescriptorLength, CV_32F);
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
