#include "features/parts/tilted_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "features/parts/scale_level.h"
#include "features/parts/whole_weights.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

static_assert(kGreyUnit == 128, "the unit of ViewKernels");

constexpr int kSlack = std::max(ScaleSpaceKernels::kRowSlack, ViewKernels::kSlack);

std::int32_t fixedPoint(double px) { return static_cast<std::int32_t>(std::lrint(px * 65536)); }

/// The rows of the rotated image, of which the last ones are kept.
class RotatedRows {
 public:
  /// @param back  from the rotated image to the image
  RotatedRows(const std::vector<std::uint32_t>& quads, const cv::Size& image, const cv::Matx23d& back,
              const cv::Size& size, int kept, std::vector<std::int16_t>& memory)
      : quads_(quads), image_(image), back_(back), size_(size), memory_(memory) {
    while (kept_ < kept) kept_ *= 2;
    stride_ = size.width + kSlack;
    const auto total = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(kept_);
    if (memory_.size() < total) memory_.resize(total);
  }

  const std::int16_t* operator()(int y) {
    for (; next_ <= y; ++next_) compute(next_);
    return rowOf(y);
  }

 private:
  std::int16_t* rowOf(int y) { return memory_.data() + std::ptrdiff_t{y & (kept_ - 1)} * stride_; }

  /// The pixels [first, last] of row y that show the image; first > last where there is none.
  void inside(int y, int& first, int& last) const {
    double low = 0, high = size_.width - 1;
    for (int axis = 0; axis < 2; ++axis) {
      const double slope = back_(axis, 0), start = back_(axis, 1) * y + back_(axis, 2);
      const double last = axis == 0 ? image_.width - 1 : image_.height - 1;
      if (std::abs(slope) < 1e-9) {
        if (start < -0.5 || start > last + 0.5) high = -1;
        continue;
      }
      const double a = -start / slope, b = (last - start) / slope;
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    }
    first = static_cast<int>(std::ceil(low));
    last = static_cast<int>(std::floor(high));
  }

  void compute(int y) {
    constexpr int kBlock = 512;  // short enough for positions in 16 bits
    std::int16_t* const row = rowOf(y);
    int first, last;
    inside(y, first, last);
    if (first > last) {
      // Only next to the corners of the image.
      if (y > 0) {
        std::copy_n(rowOf(y - 1), size_.width, row);
      } else {
        std::fill_n(row, size_.width, cornerPixel());
      }
      return;
    }
    for (int x = first; x <= last; x += kBlock) {
      const int n = std::min(kBlock, last + 1 - x);
      const double px = back_(0, 0) * x + back_(0, 1) * y + back_(0, 2);
      const double py = back_(1, 0) * x + back_(1, 1) * y + back_(1, 2);
      // Rounding must not lead out of the image, neither at the first nor at the last pixel of the block.
      const auto placed = [n](double start, double slope, int last, int& origin, std::int32_t& at,
                              std::int32_t& step) {
        origin = std::clamp(static_cast<int>(std::floor(start)), 0, last);
        step = fixedPoint(slope);
        const double low = -static_cast<double>(origin),
                     high = last - static_cast<double>(origin) + 65535.0 / 65536;
        const auto travel = static_cast<double>(step) * (n - 1) / 65536;
        at = fixedPoint(
            std::clamp(start - origin, low + std::max(0.0, -travel), high - std::max(0.0, travel)));
      };
      int origin_x, origin_y;
      std::int32_t at_x, at_y, dx, dy;
      placed(px, back_(0, 0), image_.width - 1, origin_x, at_x, dx);
      placed(py, back_(1, 0), image_.height - 1, origin_y, at_y, dy);
      kernels().views.sampleLine(quads_.data() + std::ptrdiff_t{origin_y} * image_.width + origin_x,
                                 image_.width, at_x, at_y, dx, dy, n, row + x);
    }
    std::fill_n(row, first, row[first]);
    std::fill_n(row + last + 1, size_.width - 1 - last, row[last]);
  }

  std::int16_t cornerPixel() const {
    const auto at = [](double v, int last) { return std::clamp(static_cast<int>(std::lround(v)), 0, last); };
    const double middle = (size_.width - 1) / 2.0;
    const int x = at(back_(0, 0) * middle + back_(0, 2), image_.width - 1);
    const int y = at(back_(1, 0) * middle + back_(1, 2), image_.height - 1);
    const std::uint32_t quad = quads_[static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                                      static_cast<std::size_t>(x)];
    return static_cast<std::int16_t>((quad & 255) * kGreyUnit);
  }

  const std::vector<std::uint32_t>& quads_;
  cv::Size image_;
  cv::Matx23d back_;
  cv::Size size_;
  std::vector<std::int16_t>& memory_;
  std::ptrdiff_t stride_;
  int kept_ = 1, next_ = 0;
};

}  // namespace

TiltedViews::TiltedViews(const cv::Mat& grey)
    : size_(grey.size()), quads_(static_cast<std::size_t>(grey.cols) * static_cast<std::size_t>(grey.rows)) {
  std::uint32_t* quad = quads_.data();
  for (int y = 0; y < grey.rows; ++y) {
    const std::uint8_t* const upper = grey.ptr<std::uint8_t>(y);
    const std::uint8_t* const lower = grey.ptr<std::uint8_t>(std::min(y + 1, grey.rows - 1));
    const auto put = [&](int x, int next) {
      *quad++ = upper[x] | static_cast<std::uint32_t>(upper[next]) << 8 |
                static_cast<std::uint32_t>(lower[x]) << 16 | static_cast<std::uint32_t>(lower[next]) << 24;
    };
    for (int x = 0; x + 1 < grey.cols; ++x) put(x, x + 1);
    put(grey.cols - 1, grey.cols - 1);
  }
}

TiltedView TiltedViews::view(double tilt, double turn, Workspace& workspace) const {
  const double c = std::cos(turn), s = std::sin(turn);
  const double right = size_.width - 1, bottom = size_.height - 1;
  // x' = c x + s y, y' = -s x + c y
  const double left_edge = std::min({0.0, c * right, s * bottom, c * right + s * bottom});
  const double right_edge = std::max({0.0, c * right, s * bottom, c * right + s * bottom});
  const double top_edge = std::min({0.0, -s * right, c * bottom, c * bottom - s * right});
  const double bottom_edge = std::max({0.0, -s * right, c * bottom, c * bottom - s * right});
  const cv::Size turned(static_cast<int>(std::ceil(right_edge - left_edge)) + 1,
                        static_cast<int>(std::ceil(bottom_edge - top_edge)) + 1);
  const cv::Matx23d back(c, -s, c * left_edge - s * top_edge, s, c, s * left_edge + c * top_edge);

  struct Memory {
    std::vector<std::int16_t> pixels, rows, unused;
  };
  Memory& kept = workspace.part<Memory>();
  const double sigma = 0.8 * std::sqrt(tilt * tilt - 1);
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  // Two compressed rows are computed at once.
  const int pairs = (2 * reach + 3 + static_cast<int>(std::ceil(tilt))) / 2;
  RotatedRows rotated(quads_, size_, back, turned, 2 * pairs + 1, kept.rows);

  TiltedView result;
  const int rows = static_cast<int>(std::floor((turned.height - 1) / tilt)) + 1;
  const std::ptrdiff_t stride = turned.width + kSlack;
  const auto total = static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows);
  std::vector<std::int16_t>& pixels = kept.pixels;
  if (pixels.size() < total) pixels.resize(total);
  if (kept.unused.size() < static_cast<std::size_t>(stride))
    kept.unused.resize(static_cast<std::size_t>(stride));
  std::vector<const std::int16_t*> near(static_cast<std::size_t>(2 * pairs));
  std::vector<double> weights(near.size());
  for (int row = 0; row < rows; row += 2) {
    const int first = static_cast<int>(std::ceil(row * tilt)) - reach;
    const auto weightsOf = [&](double centre) {
      for (std::size_t k = 0; k < weights.size(); ++k) {
        const double d = first + static_cast<double>(k) - centre;
        weights[k] = std::abs(d) > 3 * sigma ? 0 : std::exp(-0.5 * d * d / (sigma * sigma));
      }
      return inPairs(wholeWeights(weights), 0, pairs);
    };
    for (std::size_t k = 0; k < near.size(); ++k) {
      // Beyond the border the nearest row is used.
      near[k] = rotated(std::clamp(first + static_cast<int>(k), 0, turned.height - 1));
    }
    std::int16_t* const out = pixels.data() + row * stride;
    kernels().scale_space.filterColumns(near.data(), weightsOf(row * tilt).data(),
                                        weightsOf((row + 1) * tilt).data(), pairs, turned.width, out,
                                        row + 1 < rows ? out + stride : kept.unused.data());
  }
  result.pixels = cv::Mat(rows, turned.width, CV_16S, pixels.data(),
                          static_cast<std::size_t>(stride) * sizeof(std::int16_t));
  result.to_image = back;
  result.to_image(0, 1) *= tilt;
  result.to_image(1, 1) *= tilt;
  return result;
}

}  // namespace corrsel::core
