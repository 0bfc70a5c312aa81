#include <gtest/gtest.h>

#include <vector>

#include "features/parts/orientation_histogram.h"

namespace corrsel::core {
namespace {

using Histogram = OrientationHistogram<double>;

std::vector<Histogram::Peak> peaksOf(const Histogram& histogram) {
  std::vector<Histogram::Peak> peaks;
  histogram.forEachPeak([&](const Histogram::Peak& peak) { peaks.push_back(peak); });
  return peaks;
}

TEST(OrientationHistogram, IsACircle) {
  Histogram histogram;
  histogram.add(35, 1);
  histogram.add(36, 4);  // bin 0
  histogram.add(1, 2);
  const auto peaks = peaksOf(histogram);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_EQ(peaks[0].bin, 0u);
  EXPECT_EQ(peaks[0].before, 1);
  EXPECT_EQ(peaks[0].here, 4);
  EXPECT_EQ(peaks[0].after, 2);
}

TEST(OrientationHistogram, OffsetsAreTheVertexOfTheParabola) {
  // 5 - (x - 0.25)^2 at -1, 0 and 1.
  Histogram histogram;
  histogram.add(9, 5 - 1.5625);
  histogram.add(10, 5 - 0.0625);
  histogram.add(11, 5 - 0.5625);
  EXPECT_DOUBLE_EQ(histogram.highest().offset(), 0.25);
  EXPECT_DOUBLE_EQ(histogram.highest().curvature(), -2);
}

TEST(OrientationHistogram, SmoothingSeesTwoBinsToEachSideAcrossTheEnds) {
  for (const std::size_t bin : {0, 1, 17, 34, 35}) {
    Histogram histogram, expected;
    histogram.add(bin, 1);
    histogram.smooth(1, [](const auto& at) {
      return 100000 * at(-2) + 10000 * at(-1) + 1000 * at(0) + 100 * at(1) + 10 * at(2);
    });
    const std::vector<double> values = {10, 100, 1000, 10000, 100000};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t at = (bin + Histogram::kBins + k - 2) % Histogram::kBins;
      expected.add(at, values[k]);
    }
    ASSERT_EQ(histogram.highest().bin, (bin + 2) % Histogram::kBins);
    EXPECT_EQ(histogram.highest().here, expected.highest().here);
    EXPECT_EQ(histogram.highest().before, expected.highest().before);
    EXPECT_EQ(histogram.highest().after, 0);
  }
}

TEST(OrientationHistogram, RoundsAreApplied) {
  Histogram histogram;
  histogram.add(5, 81);
  histogram.smooth(2, [](const auto& at) { return (at(-1) + at(0) + at(1)) / 3; });
  EXPECT_DOUBLE_EQ(histogram.highest().here, 27);
  EXPECT_DOUBLE_EQ(histogram.highest().before, 18);
}

TEST(OrientationHistogram, PlateausAndEmptyOnesHaveNoPeaksButAHighestBin) {
  Histogram histogram;
  EXPECT_TRUE(peaksOf(histogram).empty());
  EXPECT_EQ(histogram.highest().bin, 0u);
  histogram.add(7, 3);
  histogram.add(8, 3);
  EXPECT_TRUE(peaksOf(histogram).empty());
  EXPECT_EQ(histogram.highest().bin, 7u);
}

}  // namespace
}  // namespace corrsel::core
