#include "features/detectors/sift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "base/parallel.h"
#include "features/parts/dog_keypoints.h"
#include "features/parts/feature_list.h"
#include "features/parts/root_sift.h"
#include "features/parts/sift_descriptor.h"

namespace corrsel::core {

void SiftOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.integer(
      {"first_octave", -1, 0, "-", "SIFT: -1 doubles the image: smaller features, 3 to 4 times the time"},
      &SiftOptions::first_octave);
  visitor.integer({"octave_layers", 1, 10, "-", "SIFT: layers per octave"}, &SiftOptions::octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "SIFT: extrema weaker than this are dropped"},
                 &SiftOptions::contrast_threshold);
  visitor.number({"edge_threshold", 1, 100, "-", "SIFT: edge-like extrema are dropped; larger keeps more"},
                 &SiftOptions::edge_threshold);
  visitor.number({"sigma", 0.5, 5, "px", "SIFT: blur of the first octave"}, &SiftOptions::sigma);
  visitor.flag("root", "SIFT descriptor of any detector: RootSIFT, square roots of its values",
               &SiftOptions::root);
}

namespace {

DogOptions dogOptions(const SiftOptions& options) {
  DogOptions result;
  result.first_octave = options.first_octave;
  result.octave_layers = options.octave_layers;
  result.contrast_threshold = options.contrast_threshold;
  result.edge_threshold = options.edge_threshold;
  result.sigma = options.sigma;
  return result;
}

/// Octave, level and part of a level in one number, as OpenCV's SIFT does it.
int packed(const DogKeypoint& keypoint, int first_octave) {
  const auto part =
      static_cast<int>(std::lround((keypoint.layer - static_cast<float>(keypoint.level) + 0.5F) * 255));
  return ((keypoint.octave + first_octave) & 255) | keypoint.level << 8 | part << 16;
}

/// The level of a packed number.
const ScaleLevel& levelOf(const ScaleSpace& space, int packed) {
  const int octave = static_cast<std::int8_t>(packed & 255) - space.octaves()[0].number;
  return space.octaves()[static_cast<std::size_t>(octave)]
      .levels[static_cast<std::size_t>(packed >> 8 & 255)];
}

/// One keypoint for every direction of the given DoG keypoints, in their order.
std::vector<cv::KeyPoint> oriented(const DogKeypoints& dog, const std::vector<std::size_t>& chosen,
                                   int first_octave, int threads) {
  constexpr std::size_t kBlock = 64;
  std::vector<std::vector<cv::KeyPoint>> blocks((chosen.size() + kBlock - 1) / kBlock);
  forEachBlock(chosen.size(), kBlock, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<cv::KeyPoint>& block = blocks[begin / kBlock];
    block.reserve(kBlock + kBlock / 2);
    std::vector<float> angles;
    for (std::size_t i = begin; i < end; ++i) {
      const DogKeypoint& keypoint = dog.keypoints()[chosen[i]];
      if (i + 1 < end) {
        const DogKeypoint& next = dog.keypoints()[chosen[i + 1]];
        prefetch(dog.levelOf(next), next.x, next.y, DogKeypoints::reachOfDirections(next));
      }
      dog.directions(keypoint, angles);
      const int octave = packed(keypoint, first_octave);
      for (const float angle : angles) {
        const auto degrees = static_cast<float>(angle * 180 / CV_PI);
        block.emplace_back(keypoint.x, keypoint.y, 2 * keypoint.sigma, degrees < 360 ? degrees : 0,
                           keypoint.response, octave);
      }
    }
  });
  std::vector<cv::KeyPoint> all;
  for (const std::vector<cv::KeyPoint>& block : blocks) all.insert(all.end(), block.begin(), block.end());
  return all;
}

/// The oriented keypoints among which the strongest `max_features` are; 0 = all.
std::vector<cv::KeyPoint> strongestOriented(const DogKeypoints& dog, std::size_t max_features,
                                            int first_octave, int threads) {
  const std::vector<DogKeypoint>& found = dog.keypoints();
  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (max_features == 0 || max_features >= found.size()) return oriented(dog, order, first_octave, threads);
  std::sort(order.begin(), order.end(), [&found](std::size_t a, std::size_t b) {
    return found[a].response != found[b].response ? found[a].response > found[b].response : a < b;
  });
  std::vector<cv::KeyPoint> all;
  for (std::size_t begin = 0; begin < order.size() && all.size() < max_features;) {
    std::size_t end = std::min(order.size(), begin + (max_features - all.size()));
    // Those as strong as the last one compete with it.
    while (end < order.size() && found[order[end]].response == found[order[end - 1]].response) ++end;
    const std::vector<cv::KeyPoint> next = oriented(dog,
                                                    {order.begin() + static_cast<std::ptrdiff_t>(begin),
                                                     order.begin() + static_cast<std::ptrdiff_t>(end)},
                                                    first_octave, threads);
    all.insert(all.end(), next.begin(), next.end());
    begin = end;
  }
  return all;
}

/// Describes every keypoint on the level on which it was found.
void describe(const ScaleSpace& space, int threads, Features& features) {
  constexpr std::size_t kBlock = 64;
  const std::size_t n = features.keypoints.size();
  features.descriptors.create(static_cast<int>(n), kSiftLength, CV_32F);
  forEachBlock(n, kBlock, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + 1 < end) {
        // The region of a descriptor is a square of 7.5 units in any direction.
        const cv::KeyPoint& next = features.keypoints[i + 1];
        prefetch(levelOf(space, next.octave), next.pt.x, next.pt.y, 5 * next.size);
      }
      siftDescriptor(levelOf(space, features.keypoints[i].octave), features.frames[i],
                     features.descriptors.ptr<float>(static_cast<int>(i)));
    }
  });
}

}  // namespace

SiftDetector::SiftDetector(const SiftOptions& options) : options_(options) { options_.check(); }

void SiftDetector::detect(const DetectionRequest& request, Features& features) const {
  DogKeypoints& dog = request.workspace.part<DogKeypoints>();
  dog.find(request.image, dogOptions(options_), request.mask, request.threads);
  const std::size_t max_features = options_.spread ? 0 : static_cast<std::size_t>(options_.max_features);
  features.keypoints = strongestOriented(dog, max_features, options_.first_octave, request.threads);
  features.frames = similarityFrames(features.keypoints);
  features.descriptors.release();
  if (!request.describe) return;
  keepStrongest(options_.max_features, options_.spread, request.image.size(), features);
  describe(dog.space(), request.threads, features);
  if (options_.root) toRootSift(features.descriptors);
}

}  // namespace corrsel::core
