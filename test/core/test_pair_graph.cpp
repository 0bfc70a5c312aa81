#include <gtest/gtest.h>

#include <cmath>

#include "geometry/frame_map.h"
#include "points/distinct_matches.h"
#include "reference/pair_graph.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// The matches of a scene with frames, and their graph.
struct Fixture {
  explicit Fixture(const Scene& scene, int k) : matches(scene.matches) {
    std::vector<LinearMap> maps;
    std::vector<std::uint32_t> rows;
    findFrameMaps(matches, maps, rows);
    distinct.assign(matches, maps, rows);
    graph.build(distinct.columns(), distinct.size(), k);
  }

  /// The mean of the four errors, written out.
  double error(std::size_t a, std::size_t b) const {
    const PairColumns c = distinct.columns();
    const auto at = [&](std::size_t i) {
      return std::pair(cv::Vec2d(c.left_x[i], c.left_y[i]), cv::Vec2d(c.right_x[i], c.right_y[i]));
    };
    double sum = 0;
    for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
      const cv::Matx22d map(c.a11[i], c.a12[i], c.a21[i], c.a22[i]);
      sum += cv::norm(at(i).second + map * (at(j).first - at(i).first) - at(j).second);
      sum += cv::norm(at(i).first + map.inv() * (at(j).second - at(i).second) - at(j).first);
    }
    return sum / 4;
  }

  Correspondences matches;
  DistinctMatches distinct;
  PairGraph graph;
};

TEST(PairGraph, JoinsTheNearestAndMeasuresTheirErrors) {
  Scene scene = homographyScene({200, 0.6, 1.0, 1});
  addFrames(scene);
  const Fixture f(scene, 20);
  ASSERT_EQ(f.graph.size(), f.distinct.size());
  ASSERT_EQ(f.graph.degree(), 20u);
  const PairColumns c = f.distinct.columns();
  std::vector<float> errors(20);
  for (std::size_t i = 0; i < f.graph.size(); ++i) {
    const auto distance = [&](std::size_t j) {
      return std::hypot(double(c.left_x[j]) - c.left_x[i], double(c.left_y[j]) - c.left_y[i]);
    };
    std::vector<std::pair<double, std::uint32_t>> sorted;
    for (std::uint32_t j = 0; j < f.graph.size(); ++j) {
      if (j != i) sorted.push_back({distance(j), j});
    }
    std::sort(sorted.begin(), sorted.end());
    f.graph.errors(i, errors.data());
    for (std::size_t k = 0; k < 20; ++k) {
      const std::uint32_t j = f.graph.neighbours(i)[k];
      ASSERT_EQ(j, sorted[k].second) << i;
      ASSERT_NEAR(errors[k], f.error(i, j), 1e-3 * (1 + f.error(i, j))) << i << " " << j;
    }
  }
}

TEST(PairGraph, HasNoEdgeBetweenMatchesThatShareAPoint) {
  Scene scene = homographyScene({40, 1.0, 0.0, 2});
  Correspondences& m = scene.matches;
  m.left_x[1] = m.left_x[0] + 0.9F;
  m.left_y[1] = m.left_y[0];
  m.right_x[3] = m.right_x[2];
  m.right_y[3] = m.right_y[2] - 0.9F;
  m.left_x[5] = m.left_x[4] + 1.1F;
  m.left_y[5] = m.left_y[4];
  addFrames(scene);
  const Fixture f(scene, 39);
  std::vector<float> errors(39);
  int missing = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    f.graph.errors(i, errors.data());
    for (std::size_t k = 0; k < 39; ++k) {
      const bool expected = [&] {
        for (const auto& [a, b] : {std::pair(0U, 1U), std::pair(2U, 3U)}) {
          const std::uint32_t p = f.distinct.ofRow(a), q = f.distinct.ofRow(b), j = f.graph.neighbours(i)[k];
          if ((i == p && j == q) || (i == q && j == p)) return true;
        }
        return false;
      }();
      EXPECT_EQ(errors[k] == PairGraph::kNoEdge, expected);
      missing += errors[k] == PairGraph::kNoEdge;
    }
  }
  EXPECT_EQ(missing, 4);
}

TEST(PairGraph, TakesFewAndCrowdedMatches) {
  Scene scene = homographyScene({100, 1.0, 0.0, 3});
  for (std::size_t i = 0; i < 90; ++i) {
    scene.matches.left_x[i] = 50;
    scene.matches.left_y[i] = 60;
  }
  addFrames(scene);
  const Fixture f(scene, PairGraph::kMaxNeighbours);
  for (std::size_t i = 0; i < f.graph.size(); ++i) {
    std::vector<std::uint32_t> list(f.graph.neighbours(i), f.graph.neighbours(i) + f.graph.degree());
    EXPECT_EQ(std::count(list.begin(), list.end(), i), 0);
    std::sort(list.begin(), list.end());
    EXPECT_EQ(std::unique(list.begin(), list.end()), list.end());
  }
  for (const std::size_t n : {0, 1, 2}) {
    Scene few = homographyScene({n, 1.0, 0.0, 4});
    addFrames(few);
    EXPECT_EQ(Fixture(few, 20).graph.degree(), n > 1 ? n - 1 : 0);
  }
}

}  // namespace
}  // namespace corrsel::core
