#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include "base/progress_meter.h"

namespace corrsel::core {
namespace {

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Progress, RateCountsThisSessionOnly) {
  const ProgressMeter meter(100, 40);
  EXPECT_TRUE(std::isnan(meter.at(40, "").rate));
  EXPECT_TRUE(std::isnan(meter.at(40, "").remaining));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const Progress progress = meter.at(70, "x");
  EXPECT_LE(progress.rate, 30 / 0.05);
  EXPECT_GT(progress.rate, 0);
  EXPECT_NEAR(progress.remaining * progress.rate, 30, 1e-6);
  EXPECT_EQ(meter.at(100, "").remaining, 0);
}

TEST(Progress, LinesElsewhereAreRareAndTheLastIsShown) {
  std::ostringstream out;
  ProgressPrinter printer(out, false, 3600);
  const ProgressMeter meter(50, 0);
  for (std::size_t done = 0; done <= 50; ++done) printer.show(meter.at(done, "pair"));
  printer.finish();
  EXPECT_EQ(lines(out.str()), 2U) << out.str();
  EXPECT_NE(out.str().find("50/50 pairs"), std::string::npos);
  EXPECT_EQ(out.str().find('\r'), std::string::npos);
}

TEST(Progress, TerminalGetsABarInPlace) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  const ProgressMeter meter(2, 0);
  for (std::size_t done = 0; done <= 2; ++done) printer.show(meter.at(done, "pair"));
  EXPECT_EQ(lines(out.str()), 0U);
  EXPECT_NE(out.str().find(std::string(30, '#')), std::string::npos);
  printer.finish();
  EXPECT_EQ(lines(out.str()), 1U);
}

TEST(Progress, EmptyRun) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  printer.show(ProgressMeter(0, 0).at(0, ""));
  EXPECT_NE(out.str().find("0/0"), std::string::npos);
}

}  // namespace
}  // namespace corrsel::core
