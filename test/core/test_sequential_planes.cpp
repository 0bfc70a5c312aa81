#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "search/homography_model.h"
#include "search/local_proposal.h"
#include "selectors/parts/sequential_planes.h"
#include "test_support.h"
#include "two_planes.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Rows = std::vector<std::uint32_t>;

/// Rows of the matches of one plane of twoPlanes(), or of its outliers (0).
Rows rowsOf(const Scene& scene, int plane) {
  Rows rows;
  for (std::uint32_t i = 0; i < scene.inlier.size(); ++i)
    if (scene.inlier[i] == plane) rows.push_back(i);
  return rows;
}

struct Search {
  SequentialPlanes planes;
  Rows rows;

  Search(const Scene& scene, const Rows* trusted, const PlanesOptions& options = {})
      : rows(permutation(scene.matches.size(), 1)) {
    Selection remarks;
    Workspace workspace;
    planes.find(scene.matches, rows, trusted, {HomographyModel(), workspace.part<LocalProposal>()}, options,
                Deadline(0), workspace, remarks);
  }
  /// Share of the rows that are in a group.
  double share(const Rows& of, std::int32_t group) const {
    const auto in_group = [&](std::uint32_t row) { return planes.group()[row] == group; };
    return static_cast<double>(std::count_if(of.begin(), of.end(), in_group)) /
           static_cast<double>(of.size());
  }
};

TEST(SequentialPlanes, NumbersPlanesAndLeavesTheOtherRows) {
  const Scene scene = twoPlanes(1);
  const Search search(scene, nullptr);
  EXPECT_EQ(search.planes.planes(), 2);
  EXPECT_GE(search.planes.confidence(), kSignificantConfidence);
  EXPECT_EQ(search.rows.size(), static_cast<std::size_t>(std::count(search.planes.group().begin(),
                                                                    search.planes.group().end(), -1)));
  for (const std::uint32_t row : search.rows) EXPECT_EQ(search.planes.group()[row], -1);
}

TEST(SequentialPlanes, SamplesOnlyTrustedMatches) {
  const Scene scene = twoPlanes(1);
  const Rows first = rowsOf(scene, 1), second = rowsOf(scene, 2);
  const Search search(scene, &second);
  EXPECT_EQ(search.planes.planes(), 1);
  EXPECT_GE(search.share(second, 0), 0.95);
  EXPECT_LE(search.share(first, 0), 0.05);
}

TEST(SequentialPlanes, CoversMatchesThatWereNotSearched) {
  const Scene scene = twoPlanes(1);
  Rows half = rowsOf(scene, 1);
  const Rows others(half.begin() + 100, half.end());
  half.resize(100);
  SequentialPlanes planes;
  Selection remarks;
  Workspace workspace;
  planes.find(scene.matches, half, nullptr, {HomographyModel(), workspace.part<LocalProposal>()}, {},
              Deadline(0), workspace, remarks);
  ASSERT_EQ(planes.planes(), 1);
  std::size_t found = 0;
  for (const std::uint32_t row : others) found += planes.group()[row] == 0 ? 1 : 0;
  EXPECT_GE(found, 95u);
}

TEST(SequentialPlanes, SevenTrustedMatchesAreTooFew) {
  const Scene scene = twoPlanes(1);
  Rows trusted = rowsOf(scene, 1);
  trusted.resize(7);
  const Search search(scene, &trusted);
  EXPECT_EQ(search.planes.planes(), 0);
  EXPECT_EQ(search.rows.size(), scene.matches.size());
  EXPECT_EQ(search.planes.model(), cv::Matx33d::zeros());
}

TEST(SequentialPlanes, NoMatchesHaveNoPlane) {
  const Rows none;
  const Search search({}, &none);
  EXPECT_EQ(search.planes.planes(), 0);
}

}  // namespace
}  // namespace corrsel::core
