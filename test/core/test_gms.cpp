#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "base/text.h"
#include "corrsel/selectors/gms.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

/// Smoothly moving clumps of matches among strays, so that some cells pass the test and some do not.
Correspondences clumps(std::uint64_t seed, std::size_t n) {
  Random random(seed);
  Correspondences m;
  m.left_size = {640, 480};
  m.right_size = {800, 500};
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(0, 640), y = random.uniform(0, 480);
    if (random.index(3) == 0) {
      m.add({float(x), float(y)}, {float(random.uniform(0, 800)), float(random.uniform(0, 500))});
    } else {
      m.add({float(0.4 * x + 0.5 * y), float(0.7 * y)}, {float(0.5 * x + 0.6 * y), float(0.6 * y + 100)});
    }
  }
  return m;
}

/// One variant of GMS as it is defined, on whole tables. Rotation r turns the right neighbourhood by r
/// eighths clockwise; `side` is the number of right cells per side.
Mask byDefinition(const Correspondences& m, const GmsOptions& o, int side, int rotation) {
  const std::vector<cv::Point> ring = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};
  Mask mask(m.size(), 0);
  for (const double dx : {0.0, 0.5}) {
    for (const double dy : {0.0, 0.5}) {
      std::map<std::pair<int, int>, std::map<std::pair<int, int>, int>> count;
      std::vector<std::pair<int, int>> left, right;  // (row, column)
      for (std::size_t i = 0; i < m.size(); ++i) {
        left.emplace_back(int(m.left_y[i] / double(m.left_size.height) * o.grid + dy),
                          int(m.left_x[i] / double(m.left_size.width) * o.grid + dx));
        right.emplace_back(int(m.right_y[i] / double(m.right_size.height) * side),
                           int(m.right_x[i] / double(m.right_size.width) * side));
        const bool dropped =
            o.drop_first_cells && ((dx > 0 && left[i].second == 0) || (dy > 0 && left[i].first == 0));
        if (dropped || left[i].first >= o.grid || left[i].second >= o.grid) left[i] = {-9, -9};
        if (left[i].first >= 0) ++count[left[i]][right[i]];
      }
      const auto total = [&count](const std::pair<int, int>& cell) {
        int sum = 0;
        if (count.count(cell)) {
          for (const auto& entry : count[cell]) sum += entry.second;
        }
        return sum;
      };
      const auto inside = [](const std::pair<int, int>& cell, int cells) {
        return cell.first >= 0 && cell.second >= 0 && cell.first < cells && cell.second < cells;
      };
      std::map<std::pair<int, int>, std::pair<int, int>> accepted;
      for (const auto& [cell, partners] : std::map(count)) {
        auto best = partners.begin();
        for (auto p = partners.begin(); p != partners.end(); ++p) {
          if (p->second > best->second) best = p;
        }
        double score = best->second, sum = total(cell), pairs = 1;
        for (std::size_t k = 0; k < 8; ++k) {
          const cv::Point to = ring[(k + std::size_t(rotation)) % 8];
          const std::pair<int, int> l(cell.first + ring[k].y, cell.second + ring[k].x);
          const std::pair<int, int> r(best->first.first + to.y, best->first.second + to.x);
          if (!inside(l, o.grid) || !inside(r, side)) continue;
          ++pairs;
          sum += total(l);
          if (count.count(l) && count[l].count(r)) score += count[l][r];
        }
        if (score >= o.alpha * std::sqrt(sum / pairs)) accepted[cell] = best->first;
      }
      for (std::size_t i = 0; i < m.size(); ++i) {
        const auto found = accepted.find(left[i]);
        if (found != accepted.end() && found->second == right[i]) mask[i] = 1;
      }
    }
  }
  return mask;
}

TEST(Gms, FollowsTheDefinition) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Correspondences m = clumps(seed, 1200);
    for (const double alpha : {2.0, 4.0}) {
      for (const int grid : {7, 20}) {
        for (const bool drop : {false, true}) {
          GmsOptions options;
          options.alpha = alpha;
          options.grid = grid;
          options.drop_first_cells = drop;
          const Selection s = GmsSelector(options).select(m);
          EXPECT_EQ(s.mask, byDefinition(m, options, grid, 0)) << "seed " << seed << ", alpha " << alpha;
          EXPECT_TRUE(s.n_selected > 0 && s.n_selected < m.size()) << s.n_selected;
          EXPECT_EQ(s.iterations, 4);
        }
      }
    }
  }
}

TEST(Gms, TakesTheVariantThatSelectsMost) {
  const double factors[] = {1, 0.5, std::sqrt(0.5), std::sqrt(2.0), 2};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const Correspondences m = clumps(seed, 600);
    GmsOptions options;
    options.alpha = 5;
    options.rotation = options.scale = true;
    Mask best(m.size(), 0);
    std::size_t most = 0;
    for (const double factor : factors) {
      for (int rotation = 0; rotation < 8; ++rotation) {
        const Mask mask = byDefinition(m, options, int(std::lround(20 * factor)), rotation);
        const std::size_t selected = selectedRows(mask).size();
        if (selected > most) {
          most = selected;
          best = mask;
        }
      }
    }
    const Selection s = GmsSelector(options).select(m);
    EXPECT_EQ(s.mask, best);
    EXPECT_EQ(s.iterations, 4 * 8 * 5);
  }
}

TEST(Gms, EveryKernelLevelSelectsTheSame) {
  const KernelLevel before = kernelLevel();
  for (const std::size_t n : {1, 17, 333, 5000}) {
    Correspondences m = clumps(n, n);
    m.left_x[0] = -2;  // outside
    for (const char* spec : {"gms", "gms:scale", "gms:rotation", "gms:rotation_scale"}) {
      setKernelLevel(KernelLevel::kPlain);
      const auto selector = createSelector(spec);
      const Selection expected = selector->select(m);
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        const Selection s = selector->select(m);
        EXPECT_EQ(s.mask, expected.mask) << toString(level) << " " << spec << " " << n;
        EXPECT_EQ(s.message, expected.message) << toString(level) << " " << spec << " " << n;
      }
    }
  }
  setKernelLevel(before);
}

TEST(Gms, PointsOnTheSidesOfCellsBelongToTheNextOne) {
  const KernelLevel before = kernelLevel();
  // Sides at whole pixels (600 / 20 = 30), and at fractions that no float holds (100 / 14): the first float
  // that is not below the side, and the last that is.
  for (const auto& [size, grid] : {std::pair<int, int>{600, 20}, {100, 14}, {640, 7}}) {
    for (int cell = 1; cell < grid; ++cell) {
      const float side = float(double(size) * cell / grid);
      const bool exact = double(side) * grid >= double(size) * cell;
      const float first = exact ? side : std::nextafter(side, float(size)),
                  below = std::nextafter(first, 0.0f);
      const double cells_per_px = grid * (1 + std::ldexp(1.0, -40)) / size;
      const ImageGrid image{cells_per_px, cells_per_px, float(size), float(size), grid, 0xFFFF};
      const float x[] = {below, first}, y[] = {0, 0};
      for (const KernelLevel level : supportedKernelLevels()) {
        setKernelLevel(level);
        std::uint16_t cells[2];
        kernels().gms.cells(x, y, 2, image, cells);
        EXPECT_EQ(cells[0], cell - 1) << size << " " << grid;
        EXPECT_EQ(cells[1], cell) << size << " " << grid;
      }
    }
  }
  setKernelLevel(before);
}

/// Matches of a square image with the same image turned and scaled about its centre.
Correspondences turned(double degrees, double scale) {
  Random random(11);
  Correspondences m;
  m.left_size = m.right_size = {600, 600};
  const double c = scale * std::cos(degrees * CV_PI / 180), s = scale * std::sin(degrees * CV_PI / 180);
  while (m.size() < 3000) {
    const double x = random.uniform(-300, 300), y = random.uniform(-300, 300);
    const double u = c * x - s * y, v = s * x + c * y;
    if (std::max(std::abs(u), std::abs(v)) < 299)
      m.add({float(x + 300), float(y + 300)}, {float(u + 300), float(v + 300)});
  }
  return m;
}

TEST(Gms, NamesRotationAndScale) {
  // Clockwise on the screen, since y points down.
  const struct {
    double degrees, scale;
    const char* message;
  } cases[] = {{90, 1, "rotation 90 deg, scale 1"},   {180, 1, "rotation 180 deg, scale 1"},
               {270, 1, "rotation 270 deg, scale 1"}, {0, 1, "rotation 0 deg, scale 1"},
               {0, 2, "rotation 0 deg, scale 0.5"},   {0, 0.5, "rotation 0 deg, scale 2"}};
  for (const auto& c : cases) {
    const Correspondences m = turned(c.degrees, c.scale);
    const Selection s = createSelector("gms:rotation_scale", {{"alpha", "6"}})->select(m);
    EXPECT_EQ(s.message, c.message);
    EXPECT_GT(s.n_selected, 0.85 * double(m.size())) << c.message;
  }
  const Correspondences quarter = turned(90, 1);
  EXPECT_GT(createSelector("gms:rotation", {{"alpha", "8"}})->select(quarter).n_selected,
            createSelector("gms", {{"alpha", "8"}})->select(quarter).n_selected + 500);
  EXPECT_EQ(createSelector("gms")->select(quarter).message, "");
}

/// n equal matches in the middle of a cell inside the grid.
Correspondences equalMatches(std::size_t n, float x = 310, float y = 310) {
  Correspondences m;
  m.left_size = m.right_size = {600, 600};
  for (std::size_t i = 0; i < n; ++i) m.add({x, y}, {x, y});
  return m;
}

TEST(Gms, AcceptsAtTheThresholdItself) {
  // 9 matches in one of 9 cells: S = 9, threshold = alpha * sqrt(1).
  GmsOptions options;
  options.alpha = 9;
  EXPECT_EQ(GmsSelector(options).select(equalMatches(9)).n_selected, 9u);
  options.alpha = 9.01;
  EXPECT_EQ(GmsSelector(options).select(equalMatches(9)).n_selected, 0u);
  // In the corner of all grids only 4 cells take part: S = 16 = alpha * sqrt(16 / 4) for alpha 8.
  options.alpha = 8;
  EXPECT_EQ(GmsSelector(options).select(equalMatches(16, 1, 1)).n_selected, 16u);
  options.alpha = 8.01;
  EXPECT_EQ(GmsSelector(options).select(equalMatches(16, 1, 1)).n_selected, 0u);
  // A single match never passes with the default, two in one cell do: 2 >= 4 sqrt(2 / 9).
  EXPECT_EQ(GmsSelector().select(equalMatches(1)).n_selected, 0u);
  EXPECT_EQ(GmsSelector().select(equalMatches(2)).n_selected, 2u);
  EXPECT_EQ(GmsSelector().select(equalMatches(2, 1, 1)).n_selected, 0u);  // 2 < 4 sqrt(2 / 4)
}

TEST(Gms, TheFirstOfEqualVariantsWins) {
  const Selection s = createSelector("gms:rotation_scale")->select(equalMatches(200));
  EXPECT_EQ(s.n_selected, 200u);
  EXPECT_EQ(s.message, "rotation 0 deg, scale 1");
}

TEST(Gms, PullsInPointsUpToOnePixelOutside) {
  for (const bool left : {true, false}) {
    const struct {
      float x, y;
      bool kept;
    } cases[] = {{-1, 300, true}, {-1.01f, 300, false}, {600, 300, true},  {600.01f, 300, false},
                 {300, -1, true}, {300, -1.01f, false}, {300, 600, true},  {300, 600.01f, false},
                 {-1, 600, true}, {-500, 300, false},   {300, 1e6f, false}};
    for (const auto& c : cases) {
      Correspondences m = equalMatches(50);
      (left ? m.left_x : m.right_x).assign(50, c.x);
      (left ? m.left_y : m.right_y).assign(50, c.y);
      // In shifted grids the last half cell is lost, in the first one it is not.
      EXPECT_EQ(GmsSelector().select(m).n_selected, c.kept ? 50u : 0u) << left << " " << c.x << " " << c.y;
    }
  }
}

TEST(Gms, RejectedPointsDoNotCount) {
  Correspondences m = clumps(1, 800);
  const Mask expected = GmsSelector().select(m).mask;
  for (int i = 0; i < 300; ++i) m.add({100, 100}, {900, 100});
  const Mask mask = GmsSelector().select(m).mask;
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), mask.begin()));
  EXPECT_EQ(std::count(mask.begin() + 800, mask.end(), 1), 0);
}

TEST(Gms, NamesTheMissingSize) {
  Correspondences m = equalMatches(50);
  m.right_size = {};
  EXPECT_EQ(GmsSelector().select(m).status, Status::kUnsupportedInput);
  EXPECT_EQ(GmsSelector().select(m).message, "gms needs the size of the right image");
  m.left_size = {0, 5};
  EXPECT_EQ(GmsSelector().select(m).message, "gms needs the size of the left image");
  EXPECT_EQ(GmsSelector().select({}).status, Status::kOk);
}

TEST(Gms, FindsTheRightMatches) {
  const Scene scene = homographyScene({3000, 0.5, 1.0, 4});
  const Quality q = quality(GmsSelector().select(scene.matches).mask, scene.inlier);
  EXPECT_GT(q.precision, 97);
  EXPECT_GT(q.recall, 90);
}

class GmsOnAdelaideRmf : public ::testing::Test {
 protected:
  void SetUp() override {
    if (adelaidePairs().empty()) GTEST_SKIP() << "skipped: the AdelaideRMF files are not here";
  }
  static void expectMeans(const std::string& spec, const OptionMap& options, double p, double r, double f) {
    const Quality q = adelaideMeans(spec, options);
    EXPECT_NEAR(q.precision, p, 0.1);
    EXPECT_NEAR(q.recall, r, 0.1);
    EXPECT_NEAR(q.f, f, 0.1);
  }
};

TEST_F(GmsOnAdelaideRmf, ReachesThePublishedMeans) {
  ASSERT_EQ(adelaidePairs().size(), 36u);
  expectMeans("gms", {}, 98.47, 78.40, 86.72);
  expectMeans("gms", {{"drop_first_cells", "true"}}, 98.43, 78.23, 86.61);
  expectMeans("gms", {{"alpha", "6"}}, 99.41, 52.74, 65.93);
  expectMeans("gms:scale", {}, 98.03, 83.41, 89.76);
}

TEST_F(GmsOnAdelaideRmf, SelectsAsManyAsTheReferenceCodesPerPair) {
  std::ifstream file(sharedData("adelaidermf") + "/../../reference/adelaide_per_pair.csv");
  if (!file) GTEST_SKIP() << "skipped: the reference counts are not here";
  std::map<std::string, std::map<std::string, std::pair<std::string, std::string>>> counts;
  std::size_t rows = 0;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = parseCsvLine(line);
    ASSERT_EQ(fields.size(), 11u) << line;
    counts[fields[2]][fields[0]] = {fields[9], fields[10]};
  }
  const std::pair<const char*, std::pair<const char*, OptionMap>> variants[] = {
      {"GMS cv::matchGMS rot=0 scale=0 alpha=4", {"gms", {}}},
      {"GMS cv::matchGMS rot=0 scale=0 alpha=6", {"gms", {{"alpha", "6"}}}},
      {"GMS cv::matchGMS rot=0 scale=1 alpha=4", {"gms:scale", {}}},
      {"GMS official code alpha=4", {"gms", {{"drop_first_cells", "true"}}}}};
  for (const auto& [variant, configuration] : variants) {
    const auto selector = createSelector(configuration.first, configuration.second);
    for (const LabelledPair& pair : adelaidePairs()) {
      const auto found = counts[variant].find(pair.name);
      if (found == counts[variant].end()) continue;
      ++rows;
      const Mask mask = selector->select(pair.matches).mask;
      std::size_t correct = 0;
      for (const std::uint32_t i : selectedRows(mask)) correct += pair.truth.labels[i] > 0;
      EXPECT_EQ(std::to_string(selectedRows(mask).size()), found->second.first)
          << variant << " " << pair.name;
      EXPECT_EQ(std::to_string(correct), found->second.second) << variant << " " << pair.name;
    }
  }
  EXPECT_EQ(rows, 4u * 36);
}

}  // namespace
}  // namespace corrsel::core
