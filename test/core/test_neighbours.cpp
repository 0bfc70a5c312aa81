#include <gtest/gtest.h>

#include <chrono>
#include <limits>

#include "corrsel/neighbours.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using Points = std::vector<cv::Point2f>;
using Indices = std::vector<std::uint32_t>;

/// The k nearest by sorting all, equal distances by index.
Indices byBruteForce(const Points& points, const cv::Point2f& query, int k) {
  std::vector<std::pair<double, std::uint32_t>> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const double dx = double(points[i].x) - query.x, dy = double(points[i].y) - query.y;
    all.emplace_back(dx * dx + dy * dy, i);
  }
  std::partial_sort(all.begin(), all.begin() + std::min<std::ptrdiff_t>(k, std::ptrdiff_t(all.size())),
                    all.end());
  Indices nearest;
  for (std::size_t i = 0; i < all.size() && i < std::size_t(k); ++i) nearest.push_back(all[i].second);
  return nearest;
}

/// Asks for the neighbours of all at once, at every kernel level, with two thirds of the points as members.
void expectExactForAll(const Points& points, int k) {
  std::vector<float> x, y;
  Indices members;
  Points chosen;
  for (const cv::Point2f& p : points) {
    if (x.size() % 3 != 1) {
      members.push_back(std::uint32_t(x.size()));
      chosen.push_back(p);
    }
    x.push_back(p.x);
    y.push_back(p.y);
  }
  const KernelLevel before = kernelLevel();
  for (const bool all : {true, false}) {
    const std::size_t count = all ? points.size() : members.size();
    if (count < std::size_t(k)) continue;
    std::vector<Indices> expected;
    for (const cv::Point2f& p : points) {
      expected.push_back(byBruteForce(all ? points : chosen, p, k));
      if (!all) expected.back() = testing::reordered(members, expected.back());
    }
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      PlanarNeighbours neighbours(x.data(), y.data(), 1, k);  // forgotten
      neighbours.build(x.data(), y.data(), count, k, all ? nullptr : members.data());
      Indices found(points.size() * std::size_t(k) + 1, 4711);
      neighbours.nearestToAll(x.data(), y.data(), points.size(), k, found.data());
      ASSERT_EQ(found.back(), 4711u) << "written beyond the end";
      const Indices queries(members.rbegin(), members.rend());
      Indices of_queries(queries.size() * std::size_t(k));
      neighbours.nearestToAll(x.data(), y.data(), queries.size(), k, of_queries.data(), queries.data());
      const auto row = [k](const Indices& rows, std::size_t i) {
        const auto first = rows.begin() + std::ptrdiff_t(i) * k;
        return Indices(first, first + k);
      };
      const std::string where = std::string(toString(level)) + ", " + std::to_string(points.size()) +
                                " points, k " + std::to_string(k) + ", all " + std::to_string(all) + ", at ";
      for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(row(found, i), expected[i]) << where << i;
      for (std::size_t i = 0; i < queries.size(); ++i)
        ASSERT_EQ(row(of_queries, i), expected[queries[i]]) << where << "query " << i;
    }
  }
  setKernelLevel(before);
}

/// Asks for the neighbours of every point and of `queries`, which must be those found by brute force.
void expectExact(const Points& points, int k, Points queries = {}) {
  std::vector<float> x, y;
  for (const cv::Point2f& p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  const PlanarNeighbours neighbours(x.data(), y.data(), points.size(), k);
  queries.insert(queries.end(), points.begin(), points.end());
  for (const cv::Point2f& query : queries) {
    Indices found(std::size_t(k) + 1, 4711);
    const int count = neighbours.nearest(query.x, query.y, k, found.data());
    ASSERT_EQ(found[std::size_t(k)], 4711u) << "written beyond k";
    found.resize(std::size_t(count));
    ASSERT_EQ(found, byBruteForce(points, query, k))
        << points.size() << " points, k " << k << ", at " << query;
  }
  expectExactForAll(points, k);
}

Points scattered(std::size_t n, std::uint64_t seed, double width = 800, double height = 600) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    points.emplace_back(testing::uniformPoint(random, width, height));
  }
  return points;
}

TEST(Neighbours, EvenlySpread) {
  for (const std::size_t n : {1u, 2u, 9u, 50u, 700u}) {
    for (const int k : {1, 5, 9, 35}) expectExact(scattered(n, n), k, scattered(20, 99, 1000, 1000));
  }
}

TEST(Neighbours, NoPoints) {
  const PlanarNeighbours neighbours(nullptr, nullptr, 0, 4);
  std::uint32_t out = 4711;
  EXPECT_EQ(neighbours.nearest(1, 2, 4, &out), 0);
  EXPECT_EQ(out, 4711u);
}

TEST(Neighbours, FewerAskedForThanPreparedFor) {
  const Points points = scattered(100, 1);
  std::vector<float> x, y;
  for (const cv::Point2f& p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  const PlanarNeighbours neighbours(x.data(), y.data(), 100, 9);
  Indices found(3);
  EXPECT_EQ(neighbours.nearest(400, 300, 3, found.data()), 3);
  EXPECT_EQ(found, byBruteForce(points, {400, 300}, 3));
}

TEST(Neighbours, TiesGoToTheLowestIndex) {
  Points lattice;
  for (const std::uint32_t i : testing::permutation(400, 2))
    lattice.emplace_back(float(i % 20), float(i / 20));
  for (const int k : {1, 3, 4, 6, 9, 13}) expectExact(lattice, k, {{9.5f, 9.5f}, {3, 4.5f}, {-5, 10}});
}

TEST(Neighbours, Duplicates) {
  Points points = scattered(60, 3);
  for (std::size_t i = 0; i < 60; ++i) {
    for (std::size_t copy = 0; copy < i % 12; ++copy) points.push_back(points[i]);
  }
  const Points unordered = testing::reordered(points, testing::permutation(points.size(), 4));
  for (const int k : {1, 4, 9}) expectExact(unordered, k, scattered(20, 5));
  expectExact(Points(100, {7, 7}), 5, {{0, 0}, {7.5f, 7}});
  expectExact(Points(3, {-7, 0}), 5);
}

TEST(Neighbours, FarOutliers) {
  Points points = scattered(300, 6);
  const Points far = {{1e6f, 1e6f}, {-1e6f, 300}, {400, -1e6f}, {1e6f, -999999}, {5000, 300}, {5001, 301}};
  points.insert(points.begin() + 100, far.begin(), far.end());
  expectExact(points, 6, {{-1e6f, -1e6f}, {1e6f, 0}, {2900, 300}});
}

TEST(Neighbours, Collinear) {
  Random random(7);
  Points horizontal, vertical, slanted;
  for (int i = 0; i < 300; ++i) {
    const float t = float(random.uniform(0, 1000));
    horizontal.emplace_back(t, 5.0f);
    vertical.emplace_back(-3.0f, t);
    slanted.emplace_back(t, 2 * t + 1);
  }
  for (const Points& line : {horizontal, vertical, slanted}) expectExact(line, 5, scattered(20, 8));
}

TEST(Neighbours, Clusters) {
  Points points = scattered(200, 9, 0.01, 0.01);
  for (const cv::Point2f& p : scattered(200, 10, 0.01, 0.01)) points.push_back(p + cv::Point2f(900, 0));
  for (const cv::Point2f& p : scattered(30, 11, 900, 900)) points.push_back(p);
  expectExact(points, 7, scattered(50, 12, 1000, 1000));
}

TEST(Neighbours, DistancesThatSinglePrecisionConfuses) {
  // Far from the origin of the grid and close together; and so close that squares vanish.
  Points far = scattered(300, 13, 1e-2, 1e-2), tiny = scattered(300, 14, 1e-21, 1e-21);
  for (cv::Point2f& p : far) p += cv::Point2f(500, 300);
  for (const int k : {5, 9, 12}) {
    expectExact(far, k);
    expectExact(tiny, k);
  }
}

TEST(Neighbours, MorePointsInABlockThanKeysCanTell) {
  // Nearly all in one cell: the outliers at both ends decide the size of the cells.
  Points points = scattered(2300, 15, 1, 1);
  for (const cv::Point2f& p : scattered(300, 16, 4000, 4000)) points.push_back(p);
  expectExact(points, 5);
}

/// Smallest time of three to ask for the k nearest of all points among the members, seconds.
double secondsForAll(const Points& points, const Indices& members, int k) {
  std::vector<float> x, y;
  for (const cv::Point2f& p : points) {
    x.push_back(p.x);
    y.push_back(p.y);
  }
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 3; ++run) {
    const auto start = std::chrono::steady_clock::now();
    PlanarNeighbours neighbours;
    neighbours.build(x.data(), y.data(), members.size(), k, members.data());
    Indices found(points.size() * std::size_t(k));
    neighbours.nearestToAll(x.data(), y.data(), points.size(), k, found.data());
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

TEST(Neighbours, LinesAmongScatteredPointsCostNoMoreThanTheirCells) {
  // The members of a match filter's second pass can be few and on one line, while the queries are everywhere:
  // thin grids once took the square of their cells for each query (found by the fuzzer: 22 s for 218
  // matches).
  constexpr std::size_t kPoints = 2000;
  Points points = scattered(kPoints, 17, 200, 200);
  Indices some;
  for (std::uint32_t i = 0; i < kPoints; i += 20) some.push_back(i);
  const double scattered_seconds = secondsForAll(points, some, 14);
  for (const std::uint32_t i : some) points[i].x = 120;
  EXPECT_LT(secondsForAll(points, some, 14), 20 * scattered_seconds)
      << "against " << scattered_seconds << " s";
  for (const std::uint32_t i : some) std::swap(points[i].x, points[i].y);
  EXPECT_LT(secondsForAll(points, some, 14), 20 * scattered_seconds)
      << "against " << scattered_seconds << " s";
}

}  // namespace
}  // namespace corrsel::core
