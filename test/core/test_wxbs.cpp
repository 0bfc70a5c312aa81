#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/datasets/scene.h"
#include "dataset_folder.h"
#include "datasets/wxbs.h"
#include "geometry/fundamental.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class Wxbs : public DatasetFolder {
 protected:
  void SetUp() override {
    DatasetFolder::SetUp();
    SceneSpec spec;
    spec.kind = MatchSceneKind::kSpace;
    spec.n = 20;
    spec.inlier_ratio = 1;
    spec.noise = 0.5;
    points_ = makeScene(spec).matches;
    writePair("WGABS/kremlin", ".png");
  }

  std::string pointsText(std::size_t count) const {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
      for (const float value :
           {points_.left_x[i], points_.left_y[i], points_.right_x[i], points_.right_y[i]}) {
        text += formatNumber(value) + " ";
      }
      text += "\n";
    }
    return text;
  }

  void writePair(const std::string& folder, const std::string& extension) const {
    writeImage(folder + "/01" + extension, 3);
    writeImage(folder + "/02" + extension, 7);
    write(folder + "/corrs.txt", pointsText(20));
  }

  Correspondences points_;
};

TEST_F(Wxbs, FitsTheTruthToTheMarkedPoints) {
  writePair("WLABS/ministry", ".bmp");
  write("WLABS/ministry/crossval_errors.txt", "1 2 3 4 5 6 7 8 9 10\n1 2 3 4 5 6 7 8 9 10\n");
  write("notes/readme.txt", "");
  EXPECT_TRUE(WxbsReader::fits(path()));
  const WxbsReader reader("wxbs", path());
  ASSERT_EQ(reader.size(), 2u);
  EXPECT_EQ(reader.id(0).text(), "wxbs/kremlin/WGABS");
  EXPECT_EQ(reader.id(1).text(), "wxbs/ministry/WLABS");
  EXPECT_EQ(reader.ignored(), (std::vector<std::string>{"notes"}));
  EXPECT_EQ(reader.files().size(), 7u);
  const ImagePair pair = reader.read(0);
  EXPECT_EQ(pair.left_name, "WGABS/kremlin/01.png");
  EXPECT_EQ(pair.right_name, "WGABS/kremlin/02.png");
  EXPECT_EQ(pair.left.data[0], 3);
  EXPECT_EQ(pair.truth.kind, TruthKind::kFundamental);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    EXPECT_LT(epipolarLineDistance(pair.truth.matrix, points_.left_x[i], points_.left_y[i],
                                   points_.right_x[i], points_.right_y[i]),
              3);
  }
  ASSERT_EQ(reader.remarks().size(), 1u);
  EXPECT_TRUE(contains(reader.remarks()[0],
                       "fundamental matrices fitted to 40 correspondences that people marked in 2 pairs; the "
                       "points lie 0."))
      << reader.remarks()[0];
}

TEST_F(Wxbs, FaultsNameFileAndRemedy) {
  const auto errorFor = [&](const std::string& points) {
    write("WGABS/kremlin/corrs.txt", points);
    const WxbsReader reader("wxbs", path());
    EXPECT_EQ(reader.size(), 1u);
    const std::string error = errorOf<DatasetError>([&] { reader.check(0); });
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.read(0); }), error);
    return error;
  };
  const std::string file = path("WGABS/kremlin/corrs.txt") + ": ";
  EXPECT_EQ(errorFor(pointsText(7)).find(file + "has 7 correspondences, at least 8 are needed"), 0u);
  EXPECT_EQ(errorFor(pointsText(8) + "1 2 3\n"),
            file + "line 9: has 3 entries where 4 are expected (x1 y1 x2 y2)");
  EXPECT_TRUE(contains(errorFor(pointsText(8) + "1 2 x 3\n"), file + "line 9: entry 3: 'x'"));
  std::string same;
  for (int i = 0; i < 9; ++i) same += "1 2 3 4\n";
  EXPECT_TRUE(contains(errorFor(same), "the 9 correspondences do not determine a fundamental matrix"));
  write("WGABS/kremlin/crossval_errors.txt", "1\n2\n");
  EXPECT_TRUE(contains(errorFor(pointsText(20)), "has 2 errors for the 20 correspondences in corrs.txt"));
  std::filesystem::remove(path("WGABS/kremlin/crossval_errors.txt"));
  std::filesystem::remove(path("WGABS/kremlin/02.png"));
  EXPECT_EQ(errorFor(pointsText(20)).find(path("WGABS/kremlin/02") + ": the image is missing"), 0u);
  std::filesystem::remove(path("WGABS/kremlin/corrs.txt"));
  const WxbsReader reader("wxbs", path());
  EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(0); }).find(file + "the file is missing"), 0u);
}

}  // namespace
}  // namespace corrsel::core
