#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "features/parts/scale_space.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class ScaleSpaces : public ::testing::Test {
 protected:
  ~ScaleSpaces() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

cv::Mat noise(const cv::Size& size, std::uint32_t seed = 1) {
  Random random(seed);
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) image.at<std::uint8_t>(y, x) = std::uint8_t(random.index(256));
  }
  return image;
}

/// Ramps and discs: smooth enough for comparisons with a blur in floating point.
cv::Mat picture(const cv::Size& size) {
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double value =
          128 + 60 * std::sin(0.13 * x) * std::cos(0.09 * y) + 50 * std::sin(0.02 * x * y / 9);
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(value);
    }
  }
  return image;
}

std::vector<cv::Mat> levelsOf(const ScaleSpace& space) {
  std::vector<cv::Mat> levels;
  for (const ScaleLevel& level : space.levels()) {
    cv::Mat pixels(level.height, level.width, CV_16S);
    for (int y = 0; y < level.height; ++y) {
      std::copy_n(level.pixels + y * level.stride, level.width, pixels.ptr<std::int16_t>(y));
    }
    levels.push_back(pixels);
  }
  return levels;
}

std::vector<cv::Mat> computed(const cv::Mat& image, const ScaleSpaceOptions& options = {}, int threads = 1) {
  ScaleSpace space;
  space.compute(image, options, threads);
  return levelsOf(space);
}

void expectSame(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].size(), b[i].size());
    ASSERT_EQ(cv::countNonZero(a[i] != b[i]), 0) << "level " << i;
  }
}

ScaleSpaceOptions optionsOf(int first_octave, int resolution, int first_level, int last_level,
                            double sigma = 1.6) {
  ScaleSpaceOptions options;
  options.first_octave = first_octave;
  options.resolution = resolution;
  options.first_level = first_level;
  options.last_level = last_level;
  options.sigma = sigma;
  return options;
}

const std::vector<ScaleSpaceOptions> kGeometries = {optionsOf(-1, 3, 0, 5),     optionsOf(0, 3, 0, 5),
                                                    optionsOf(0, 3, -1, 3),     optionsOf(0, 3, 0, 2),
                                                    optionsOf(2, 10, -1, 10),   optionsOf(-1, 1, 0, 3, 5.0),
                                                    optionsOf(0, 2, 0, 4, 0.5), optionsOf(-1, 4, 0, 6, 0.5)};

TEST_F(ScaleSpaces, AreTheSameAtEveryKernelLevelAndForAnyNumberOfThreads) {
  for (const cv::Size size : {cv::Size(401, 303), cv::Size(64, 700), cv::Size(33, 47)}) {
    for (ScaleSpaceOptions options : kGeometries) {
      options.min_side = 4;
      const cv::Mat image = noise(size);
      setKernelLevel(KernelLevel::kPlain);
      const std::vector<cv::Mat> expected = computed(image, options);
      ASSERT_FALSE(expected.empty());
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        for (const int threads : {1, 2, 3, 7}) {
          SCOPED_TRACE(toString(level) + " " + std::to_string(threads));
          expectSame(computed(image, options, threads), expected);
        }
      }
    }
  }
}

TEST_F(ScaleSpaces, LevelsAreGaussianBlursOfTheImage) {
  const cv::Mat image = picture({320, 240});
  cv::Mat grey;
  image.convertTo(grey, CV_64F);
  for (const ScaleSpaceOptions& options :
       {optionsOf(0, 3, -1, 4), optionsOf(0, 3, 0, 2), optionsOf(0, 5, 0, 7), optionsOf(1, 3, 0, 5, 3.2)}) {
    ScaleSpace space;
    space.compute(image, options, 1);
    int compared = 0;
    for (const ScaleLevel& level : space.levels()) {
      // Far from the border, where both see the same pixels.
      const int margin = int(4 * level.sigma) + 1;
      const double missing = std::sqrt(level.sigma * level.sigma - kCameraBlur * kCameraBlur);
      cv::Mat blurred;
      cv::GaussianBlur(grey, blurred, {}, missing, 0, cv::BORDER_REFLECT_101);
      for (int y = 0; y < level.height; ++y) {
        for (int x = 0; x < level.width; ++x) {
          const int at_x = int(x * level.step), at_y = int(y * level.step);
          if (std::min({at_x, at_y, image.cols - 1 - at_x, image.rows - 1 - at_y}) < margin) continue;
          const double value = level.pixels[y * level.stride + x] / double(kGreyUnit);
          ASSERT_NEAR(value, blurred.at<double>(at_y, at_x), 0.5) << "sigma " << level.sigma;
          ++compared;
        }
      }
    }
    EXPECT_GT(compared, 10000);
  }
}

TEST_F(ScaleSpaces, ShowRampsWhereTheGeometryPlacesThem) {
  // A ramp stays a ramp under blur and linear interpolation.
  cv::Mat smooth(200, 220, CV_16S);
  for (int y = 0; y < smooth.rows; ++y) {
    for (int x = 0; x < smooth.cols; ++x) smooth.at<std::int16_t>(y, x) = std::int16_t(20 * x + 50 * y);
  }
  for (const int first_octave : {-1, 0, 1}) {
    ScaleSpace space;
    space.compute(smooth, optionsOf(first_octave, 3, 0, 5), 2);
    ASSERT_GE(space.octaves().size(), 3u);
    for (const ScaleOctave& octave : {space.octaves()[0], space.octaves()[1]}) {
      for (const ScaleLevel& level : octave.levels) {
        EXPECT_EQ(level.step, std::ldexp(1.0, octave.number));
        EXPECT_EQ(level.width, octave.width);
        const int margin = int(4 * level.sigma / level.step) + 2;
        for (int y = margin; y < level.height - margin; ++y) {
          for (int x = margin; x < level.width - margin; ++x) {
            const double at_x = level.offset + x * level.step, at_y = level.offset + y * level.step;
            ASSERT_NEAR(level.pixels[y * level.stride + x], 20 * at_x + 50 * at_y, 2)
                << "sigma " << level.sigma;
          }
        }
      }
    }
  }
}

TEST_F(ScaleSpaces, BlursAreThoseOfTheOptions) {
  ScaleSpace space;
  space.compute(noise({200, 160}), optionsOf(-1, 4, -1, 5, 1.4), 1);
  const std::vector<ScaleOctave>& octaves = space.octaves();
  ASSERT_EQ(octaves.size(), 5u);  // 400 x 320 to 25 x 20
  for (std::size_t o = 0; o < octaves.size(); ++o) {
    EXPECT_EQ(octaves[o].number, int(o) - 1);
    EXPECT_EQ(octaves[o].width, 400 >> o);
    EXPECT_EQ(octaves[o].height, 320 >> o);
    ASSERT_EQ(octaves[o].levels.size(), 7u);
    for (int k = 0; k < 7; ++k) {
      EXPECT_NEAR(octaves[o].levels[std::size_t(k)].sigma, 1.4 * std::exp2((k - 1) / 4.0 + double(o) - 1),
                  1e-9);
    }
  }
}

TEST_F(ScaleSpaces, ConstantImagesStayConstant) {
  for (const int grey : {0, 1, 100, 255}) {
    for (const ScaleSpaceOptions& options : kGeometries) {
      for (const cv::Mat& level : computed(cv::Mat(70, 90, CV_8U, cv::Scalar(grey)), options, 2)) {
        ASSERT_EQ(cv::countNonZero(level != grey * kGreyUnit), 0);
      }
    }
  }
}

TEST_F(ScaleSpaces, SixteenBitImagesGiveTheSameAsEightBits) {
  const cv::Mat image = noise({150, 120});
  cv::Mat wide;
  image.convertTo(wide, CV_16S, kGreyUnit);
  for (const ScaleSpaceOptions& options : kGeometries)
    expectSame(computed(image, options), computed(wide, options));
}

TEST_F(ScaleSpaces, ImagesOfAnySizeWork) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 40), cv::Size(40, 1), cv::Size(2, 3),
                              cv::Size(5, 300), cv::Size(31, 32), cv::Size(33, 65)}) {
    for (ScaleSpaceOptions options : kGeometries) {
      const int step = options.first_octave > 0 ? 1 << options.first_octave : 1;
      if (std::min(size.width, size.height) < step) continue;
      options.min_side = 1;
      const cv::Mat image = noise(size);
      const std::vector<cv::Mat> levels = computed(image, options, 3);
      ASSERT_FALSE(levels.empty());
      expectSame(levels, computed(image, options, 1));
      // A blur keeps the range of the pixels.
      for (const cv::Mat& level : levels) {
        double low, high;
        cv::minMaxLoc(level, &low, &high);
        ASSERT_GE(low, 0);
        ASSERT_LE(high, 255 * kGreyUnit);
      }
    }
  }
  EXPECT_TRUE(computed(noise({11, 200}), optionsOf(0, 3, 0, 5)).empty());
}

TEST_F(ScaleSpaces, MemoryOfAnotherImageDoesNotMatter) {
  ScaleSpace space;
  space.compute(noise({500, 400}), {}, 2);
  const cv::Mat image = noise({90, 70}, 2);
  space.compute(image, {}, 1);
  expectSame(levelsOf(space), computed(image));
}

/// Remembers the rows that it sees.
class Recorder : public ScaleRowVisitor {
 public:
  void begin(const ScaleOctave& octave, int bands) override {
    seen.push_back(std::vector<int>(std::size_t(octave.height), 0));
    last.assign(std::size_t(bands), -1);
    copies.push_back(
        std::vector<cv::Mat>(octave.levels.size(), cv::Mat(octave.height, octave.width, CV_16S)));
    for (cv::Mat& copy : copies.back()) copy = copy.clone();
  }
  void visit(const ScaleOctave& octave, const ScaleRows& rows, int y) override {
    ++seen.back()[std::size_t(y)];
    const auto band = std::size_t(rows.band());
    in_order = in_order && last[band] < y;
    last[band] = y;
    for (std::size_t l = 0; l < octave.levels.size(); ++l) {
      std::copy_n(rows(l, y), octave.width, copies.back()[l].ptr<std::int16_t>(y));
      // The rows above and below are there as well, and are those of the level.
      for (const int near : {std::max(0, y - 1), std::min(octave.height - 1, y + 1)})
        neighbours += rows(l, near)[0];
    }
  }
  std::vector<std::vector<int>> seen;
  std::vector<int> last;
  std::vector<std::vector<cv::Mat>> copies;
  bool in_order = true;
  std::int64_t neighbours = 0;
};

TEST_F(ScaleSpaces, VisitorsSeeEveryRowOnce) {
  const cv::Mat image = noise({120, 300});
  std::int64_t neighbours = 0;
  // One thread at a time may write to the recorder's sums, so only one thread works here.
  ScaleSpace space;
  Recorder recorder;
  space.compute(image, {}, 1, &recorder);
  ASSERT_EQ(recorder.seen.size(), space.octaves().size());
  EXPECT_TRUE(recorder.in_order);
  std::vector<cv::Mat> copies;
  for (std::size_t o = 0; o < recorder.seen.size(); ++o) {
    for (const int count : recorder.seen[o]) ASSERT_EQ(count, 1);
    copies.insert(copies.end(), recorder.copies[o].begin(), recorder.copies[o].end());
    for (const ScaleLevel& level : space.octaves()[o].levels) {
      for (int y = 0; y < level.height; ++y) {
        neighbours += level.pixels[std::max(0, y - 1) * level.stride];
        neighbours += level.pixels[std::min(level.height - 1, y + 1) * level.stride];
      }
    }
  }
  expectSame(copies, levelsOf(space));
  EXPECT_EQ(recorder.neighbours, neighbours);
}

TEST_F(ScaleSpaces, KernelsFilterAsAPlainLoopDoes) {
  Random random(5);
  constexpr int kSlack = ScaleSpaceKernels::kRowSlack;
  const auto pixel = [&random] { return std::int16_t(random.index(255 * kGreyUnit + 1)); };
  for (const int n : {1, 7, 31, 32, 33, 64, 100, 129, 300}) {
    for (const int pairs : {1, 2, 5, 12}) {
      std::vector<std::vector<std::int16_t>> rows(std::size_t(2 * pairs));
      std::vector<const std::int16_t*> pointers;
      for (auto& row : rows) {
        for (int x = 0; x < n + 2 * pairs + kSlack; ++x) row.push_back(pixel());
        pointers.push_back(row.data());
      }
      std::vector<int> first(rows.size()), second(rows.size());
      std::vector<std::int32_t> first_pairs, second_pairs;
      for (auto* weights : {&first, &second}) {
        int rest = 1 << 15;
        for (std::size_t k = 0; k + 1 < weights->size(); ++k) {
          (*weights)[k] = int(random.index(std::uint32_t(rest) / 2 + 1));
          rest -= (*weights)[k];
        }
        weights->back() = std::min(rest, 32767);
      }
      for (int j = 0; j < pairs; ++j) {
        first_pairs.push_back(first[std::size_t(2 * j)] | first[std::size_t(2 * j + 1)] << 16);
        second_pairs.push_back(second[std::size_t(2 * j)] | second[std::size_t(2 * j + 1)] << 16);
      }
      const auto rounded = [](std::int64_t sum) { return std::int16_t((sum + (1 << 14)) >> 15); };
      std::vector<std::int16_t> columns_first, columns_second, row, doubled;
      for (int x = 0; x < n; ++x) {
        std::int64_t a = 0, b = 0, c = 0, d = 0;
        for (std::size_t k = 0; k < rows.size(); ++k) {
          a += first[k] * rows[k][std::size_t(x)];
          b += second[k] * rows[k][std::size_t(x)];
          c += first[k] * rows[0][std::size_t(x) + k];
          d += second[k] * rows[0][std::size_t(x) + k];
        }
        columns_first.push_back(rounded(a));
        columns_second.push_back(rounded(b));
        row.push_back(rounded(c));
        doubled.push_back(rounded(c));
        doubled.push_back(rounded(d));
      }
      for (const KernelLevel level : supportedKernelLevels()) {
        SCOPED_TRACE(toString(level) + " " + std::to_string(n) + " " + std::to_string(pairs));
        setKernelLevel(level);
        const ScaleSpaceKernels& kernel = kernels().scale_space;
        std::vector<std::int16_t> a(std::size_t(n + kSlack)), b = a, c = a, d(2 * a.size());
        kernel.filterColumns(pointers.data(), first_pairs.data(), second_pairs.data(), pairs, n, a.data(),
                             b.data());
        kernel.filterRow(rows[0].data(), first_pairs.data(), pairs, n, c.data());
        kernel.doubleRow(rows[0].data(), first_pairs.data(), second_pairs.data(), pairs, n, d.data());
        for (auto* values : {&a, &b, &c}) values->resize(std::size_t(n));
        d.resize(std::size_t(2 * n));
        EXPECT_EQ(a, columns_first);
        EXPECT_EQ(b, columns_second);
        EXPECT_EQ(c, row);
        EXPECT_EQ(d, doubled);
      }
    }
  }
}

TEST_F(ScaleSpaces, KernelsFindTheExtremaThatAPlainLoopFinds) {
  constexpr int kSlack = ScaleSpaceKernels::kRowSlack;
  Random random(6);
  using Places = std::vector<std::pair<int, int>>;
  int maxima = 0, minima = 0, ties = 0;
  for (const int n : {3, 20, 33, 64, 200, 600}) {
    for (const int range : {3, 50, 30000}) {
      for (const int levels : {1, 3, 10}) {
        for (int round = 0; round < 5; ++round) {
          std::vector<std::vector<std::int16_t>> rows(std::size_t(3 * (levels + 2)));
          std::vector<const std::int16_t*> pointers;
          for (auto& row : rows) {
            for (int x = 0; x < n + kSlack; ++x) {
              row.push_back(std::int16_t(int(random.index(std::uint32_t(2 * range + 1))) - range));
            }
            pointers.push_back(row.data());
          }
          const auto threshold = std::int16_t(range / 4);
          Places expected;
          for (int x = 1; x < n - 1; ++x) {
            for (int level = 1; level <= levels; ++level) {
              const int value = rows[std::size_t(3 * level + 1)][std::size_t(x)];
              bool is_maximum = value > threshold, is_minimum = value < -threshold;
              bool largest_or_equal = is_maximum;
              for (int k = 0; k < 27; ++k) {
                if (k == 13) continue;
                const int near = rows[std::size_t(3 * (level - 1) + k / 3)][std::size_t(x + k % 3 - 1)];
                // An equal neighbour that comes first takes precedence.
                is_maximum = is_maximum && (k < 13 ? near < value : near <= value);
                is_minimum = is_minimum && (k < 13 ? near > value : near >= value);
                largest_or_equal = largest_or_equal && near <= value;
              }
              if (is_maximum || is_minimum) expected.emplace_back(x, level);
              maxima += is_maximum;
              minima += is_minimum;
              ties += largest_or_equal && !is_maximum;
            }
          }
          for (const KernelLevel level : supportedKernelLevels()) {
            setKernelLevel(level);
            std::vector<ExtremumPlace> found(std::size_t(n * levels));
            const int count =
                kernels().scale_space.extrema(pointers.data(), levels, 1, n - 1, threshold, found.data());
            Places places;
            for (int k = 0; k < count; ++k) {
              places.emplace_back(found[std::size_t(k)].column, found[std::size_t(k)].level);
            }
            std::sort(places.begin(), places.end());
            ASSERT_EQ(places, expected) << toString(level);
          }
        }
      }
    }
  }
  EXPECT_GT(maxima, 50);
  EXPECT_GT(minima, 50);
  EXPECT_GT(ties, 50);
}

}  // namespace
}  // namespace corrsel::core
