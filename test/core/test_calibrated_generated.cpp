#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "datasets/calibrated_generated.h"

namespace corrsel::core {
namespace {

TEST(CalibratedGenerated, HasAllCamerasAndMotions) {
  for (const std::string name :
       {"calibrated30_generated", "calibrated70_generated", "calibrated95_generated"}) {
    EXPECT_TRUE(CalibratedGeneratedReader::isName(name));
    EXPECT_FALSE(needsFolder(name));
    const auto reader = openDataset(name, "");
    ASSERT_EQ(reader->size(), 4u * 5 * 25);
    std::set<std::string> sequences, ids;
    for (std::size_t i = 0; i < reader->size(); ++i) {
      EXPECT_EQ(reader->id(i).dataset, name);
      sequences.insert(reader->id(i).sequence);
      ids.insert(reader->id(i).text());
    }
    EXPECT_EQ(sequences.size(), 20u);
    EXPECT_EQ(ids.size(), reader->size());
    EXPECT_EQ(sequences.count("equirectangular_plane"), 1u);
    EXPECT_THROW(reader->id(500), std::out_of_range);
  }
  EXPECT_FALSE(CalibratedGeneratedReader::isName("calibrated50_generated"));
  EXPECT_TRUE(needsFolder("vgg"));
  EXPECT_TRUE(needsFolder("heinly_generated"));
}

TEST(CalibratedGenerated, PairsHaveMatchesCamerasAndTruth) {
  const CalibratedGeneratedReader reader("calibrated70_generated", 3);
  for (std::size_t i = 0; i < reader.size(); i += 25) {
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.id, reader.id(i));
    ASSERT_TRUE(pair.given && pair.left_camera && pair.truth.pose);
    EXPECT_EQ(pair.given->left_camera, pair.left_camera);
    const std::vector<double> errors = groundTruthErrors(pair.truth, *pair.given);
    const auto near = std::count_if(errors.begin(), errors.end(), [](double e) { return e <= 5; });
    EXPECT_GE(near, 275) << pair.id.text();  // of 280 with noise of 1 px, and some by chance
    EXPECT_LE(near, 310) << pair.id.text();
  }
  EXPECT_EQ(reader.read(0).truth.kind, TruthKind::kHomography);
  EXPECT_EQ(reader.read(499).truth.kind, TruthKind::kEssential);
}

TEST(CalibratedGenerated, PairsDependOnSeedAndId) {
  const CalibratedGeneratedReader reader("calibrated95_generated", 3), other("calibrated95_generated", 4);
  EXPECT_EQ(reader.read(60).given->left_x, reader.read(60).given->left_x);
  EXPECT_NE(reader.read(60).given->left_x, reader.read(61).given->left_x);
  EXPECT_NE(reader.read(60).given->left_x, other.read(60).given->left_x);
}

}  // namespace
}  // namespace corrsel::core
