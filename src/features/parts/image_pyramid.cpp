#include "features/parts/image_pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr int kPadding = ShrinkColumns::kPadding;

/// Interpolation between two neighbouring pixels.
struct Between {
  std::int64_t first;          ///< the pixel before
  std::int64_t rest, divisor;  ///< the weight of the pixel behind: rest / divisor
};

/// Where the centre of a pixel of the smaller image lies on the larger one.
Between between(int i, int smaller, int larger) {
  const std::int64_t divisor = 2 * std::int64_t{smaller};
  const std::int64_t at = (2 * std::int64_t{i} + 1) * larger - smaller;
  return {at / divisor, at % divisor, divisor};
}

/// Tables of ShrinkColumns and two rows of their results.
struct ShrinkMemory {
  int width = 0, reduced = 0;  ///< that the tables are made for
  std::vector<std::int32_t> first;
  std::vector<std::uint8_t> places, weights;
  bool narrow = true;
  std::vector<std::int16_t> rows[2];

  void prepare(int from, int to);
  ShrinkColumns columns() const {
    return {first.data(), places.data(), weights.data(), static_cast<int>(first.size()), narrow};
  }
};

void ShrinkMemory::prepare(int from, int to) {
  constexpr int kGroup = ShrinkColumns::kGroup;
  width = from;
  reduced = to;
  const int groups = (to + 2 * kGroup - 1) / (2 * kGroup) * 2;
  const auto count = static_cast<std::size_t>(groups);
  first.assign(count, 0);
  places.assign(count * 2 * kGroup, 0);
  weights.assign(count * 2 * kGroup, 0);
  narrow = true;
  for (int x = 0; x < to; ++x) {
    const Between here = between(x, to, from);
    auto left = static_cast<int>(here.first);
    auto weight = static_cast<int>((64 * here.rest + here.divisor / 2) / here.divisor);
    if (left + 1 >= from) {
      left = from - 2;
      weight = 64;
    }
    const auto group = static_cast<std::size_t>(x / kGroup);
    if (x % kGroup == 0) first[group] = left;
    const int place = left - first[group];
    narrow = narrow && place + 1 < ShrinkColumns::kReach;
    const std::size_t at = 2 * static_cast<std::size_t>(x);
    places[at] = static_cast<std::uint8_t>(place);
    places[at + 1] = static_cast<std::uint8_t>(place + 1);
    weights[at] = static_cast<std::uint8_t>(64 - weight);
    weights[at + 1] = static_cast<std::uint8_t>(weight);
  }
  for (auto& row : rows) row.resize(static_cast<std::size_t>(groups * kGroup + kPadding));
}

struct BlurMemory {
  std::vector<std::uint16_t> row;
};

/// Several pyramids may be reduced in turn by one thread, so one set of tables per level.
struct ShrinkTables {
  std::vector<ShrinkMemory> levels;
};

std::size_t bufferSize(const PyramidLevel& level) {
  return static_cast<std::size_t>(level.stride) * static_cast<std::size_t>(level.height) + kPadding;
}

}  // namespace

cv::Point PyramidLevel::fromImage(const cv::Point2f& p) const {
  return {static_cast<int>(std::floor((p.x + 0.5) / x_scale)),
          static_cast<int>(std::floor((p.y + 0.5) / y_scale))};
}

void ImagePyramid::start(const cv::Mat& grey, double scale_factor, int levels, bool blur) {
  levels_.resize(static_cast<std::size_t>(levels));
  double scale = 1;
  for (Level& level : levels_) {
    PyramidLevel& image = level.image;
    image.width = static_cast<int>(std::lround(grey.cols / scale));
    image.height = static_cast<int>(std::lround(grey.rows / scale));
    image.stride = (image.width + 2 * kPadding - 1) / kPadding * kPadding;
    image.scale = scale;
    image.x_scale = static_cast<double>(grey.cols) / image.width;
    image.y_scale = static_cast<double>(grey.rows) / image.height;
    if (level.pixels.size() < bufferSize(image)) level.pixels.resize(bufferSize(image));
    if (blur && level.blurred.size() < bufferSize(image)) level.blurred.resize(bufferSize(image));
    image.pixels = level.pixels.data();
    scale *= scale_factor;
  }
  Level& first = levels_.front();
  for (int y = 0; y < grey.rows; ++y) {
    std::memcpy(first.pixels.data() + y * first.image.stride, grey.ptr(y),
                static_cast<std::size_t>(grey.cols));
  }
}

void ImagePyramid::reduce(int number, Workspace& workspace) {
  const PyramidLevel& from = level(number - 1);
  Level& level = levels_[static_cast<std::size_t>(number)];
  const PyramidLevel& to = level.image;
  auto& tables = workspace.part<ShrinkTables>().levels;
  if (tables.size() <= static_cast<std::size_t>(number)) tables.resize(static_cast<std::size_t>(number) + 1);
  ShrinkMemory& memory = tables[static_cast<std::size_t>(number)];
  if (memory.width != from.width || memory.reduced != to.width) memory.prepare(from.width, to.width);
  const ShrinkColumns columns = memory.columns();
  const ShrinkKernels& shrink = kernels().shrink;
  int held[2] = {-1, -1};  // rows of the larger image in memory.rows
  const auto row = [&](int y) {
    const int slot = y % 2;
    if (held[slot] != y) {
      shrink.columns(from.pixels + y * from.stride, columns, memory.rows[slot].data());
      held[slot] = y;
    }
    return memory.rows[slot].data();
  };
  for (int y = 0; y < to.height; ++y) {
    const Between here = between(y, to.height, from.height);
    const auto top = static_cast<int>(here.first);
    const int bottom = std::min(top + 1, from.height - 1);
    const auto weight = static_cast<std::int16_t>((here.rest << 15) / here.divisor);
    shrink.rows(row(top), row(bottom), weight, to.width, level.pixels.data() + y * to.stride);
  }
}

void ImagePyramid::blur(int number, const cv::Rect& part, Workspace& workspace) {
  Level& level = levels_[static_cast<std::size_t>(number)];
  const PyramidLevel& image = level.image;
  const int width = part.width + 2 * kBlurReach;
  std::vector<std::uint16_t>& sums = workspace.part<BlurMemory>().row;
  // The columns behind the last sum are read too, by vectors whose last results are not used.
  sums.resize(std::max(sums.size(), static_cast<std::size_t>(width + kPadding)));
  const ShrinkKernels& shrink = kernels().shrink;
  for (int y = part.y; y < part.br().y; ++y) {
    const std::ptrdiff_t row = y * image.stride + part.x;
    shrink.blur_rows(image.pixels + row - kBlurReach * image.stride - kBlurReach, image.stride, width,
                     sums.data());
    shrink.blur_columns(sums.data(), part.width, level.blurred.data() + row);
  }
}

PyramidLevel ImagePyramid::blurred(int number) const {
  const Level& level = levels_[static_cast<std::size_t>(number)];
  PyramidLevel result = level.image;
  result.pixels = level.blurred.data();
  return result;
}

int usableLevels(const cv::Size& image_size, double scale_factor, int max_levels, int border) {
  const double smallest = border + 1.0;
  int levels = 1;
  for (double side = std::min(image_size.width, image_size.height) / scale_factor;
       levels < max_levels && side > smallest; side /= scale_factor) {
    ++levels;
  }
  return levels;
}

std::vector<int> levelShares(int features, double scale_factor, int levels) {
  const double factor = 1 / scale_factor;
  double share = features * (1 - factor) / (1 - std::pow(factor, levels));
  std::vector<int> result;
  int left = features;
  for (int level = 1; level < levels; ++level, share *= factor) {
    result.push_back(std::min(static_cast<int>(std::lrint(share)), left));
    left -= result.back();
  }
  result.push_back(left);
  return result;
}

}  // namespace corrsel::core
