#include "features/parts/sift_descriptor.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.h"
#include "features/parts/affine_patch.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

static_assert(CellTables::kLength == kSiftLength);

constexpr double kSpacing = 0.5;  // of the samples, in units of the frame

CellTables cellTables() {
  constexpr int kSamples = CellTables::kCellSamples, kMiddle = Patch::kInner / 2;
  constexpr double kWindow = 2.0 * kSamples;  // sigma of the Gaussian weight, samples
  CellTables tables = {};
  const PatchWeights window = gaussianWindow(kWindow);
  for (int i = 0; i < Patch::kInner; ++i) {
    // The middle of cell 0 is one and a half cells before the centre, that of cell -1 two and a half.
    const int sample = i - kMiddle + Patch::kHalf, cell = sample / kSamples - 1;
    const auto share = static_cast<float>(sample % kSamples) / kSamples;
    for (int c = 0; c < Patch::kInner; ++c) {
      const float weight = window.values[i * Patch::kPitch + c];
      tables.rows[sample][0][c] = (1 - share) * weight;
      tables.rows[sample][1][c] = share * weight;
    }
    if (cell >= 0) tables.columns[cell][i] = 1 - share;
    if (cell + 1 < CellTables::kCells) tables.columns[cell + 1][i] = share;
  }
  return tables;
}

bool describePatch(const Patch& patch, float* descriptor) {
  static const CellTables tables = cellTables();
  return kernels().patches.describe(patch, tables, descriptor);
}

/// Returns false where siftDescriptor() fails for the region of a describable frame.
bool describeInside(const ScaleLevel& level, const AffineFrame& frame, float* descriptor) {
  Patch patch;
  const int outside = samplePatch(level, frame, kSpacing, patch);
  return 2 * outside <= Patch::kSide * Patch::kSide && describePatch(patch, descriptor);
}

}  // namespace

bool isDescribable(const AffineFrame& frame, const cv::Size& image) {
  for (const float value : frame) {
    if (!std::isfinite(value)) return false;
  }
  return image.width > 1 && image.height > 1 && frame[2] >= 0 && frame[5] >= 0 &&
         frame[2] <= static_cast<float>(image.width - 1) &&
         frame[5] <= static_cast<float>(image.height - 1) && halfAxes(frame).smaller > 0;
}

bool siftDescriptor(const std::vector<ScaleLevel>& levels, const AffineFrame& frame, const cv::Size& image,
                    float* descriptor) {
  return isDescribable(frame, image) &&
         describeInside(levelFor(levels, halfAxes(frame).smaller), frame, descriptor);
}

void siftDescriptor(const ScaleLevel& level, const AffineFrame& frame, float* descriptor) {
  Patch patch;
  samplePatch(level, frame, kSpacing, patch);
  if (!describePatch(patch, descriptor)) std::fill_n(descriptor, kSiftLength, 0.0F);
}

std::vector<char> siftDescriptors(const std::vector<ScaleLevel>& levels,
                                  const std::vector<AffineFrame>& frames, const cv::Size& image, int threads,
                                  cv::Mat& descriptors) {
  constexpr std::size_t kBlock = 64;
  descriptors.create(static_cast<int>(frames.size()), kSiftLength, CV_32F);
  std::vector<char> described(frames.size());
  // Frames of the same level come together, from top to bottom, so that their pixels are still in the cache.
  struct Place {
    std::size_t level, frame;
    float y;
  };
  std::vector<Place> places;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!isDescribable(frames[i], image)) continue;
    const ScaleLevel& level = levelFor(levels, halfAxes(frames[i]).smaller);
    places.push_back({static_cast<std::size_t>(&level - levels.data()), i, frames[i][5]});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tie(a.level, a.y, a.frame) < std::tie(b.level, b.y, b.frame);
  });
  forEachBlock(places.size(), kBlock, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = places[k].frame;
      float* const descriptor = descriptors.ptr<float>(static_cast<int>(i));
      described[i] = describeInside(levels[places[k].level], frames[i], descriptor) ? 1 : 0;
    }
  });
  return described;
}

}  // namespace corrsel::core
