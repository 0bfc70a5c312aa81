#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "datasets/tum_rgbd.h"
#include "posed_scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

class TumRgbd : public PosedScene {
 protected:
  /// A camera that moves steadily.
  static RigidMotion poseAt(double time) {
    return pose({0, 0.1 * time, 0.2 * time}, {0.5 * time - 0.2, 0.1 * time, -0.2 * time});
  }

  static std::string stamp(double time) {
    std::string fraction = std::to_string(static_cast<int>(std::lround(time * 1e6)) + 1000000).substr(1);
    return "1305031102." + fraction;
  }

  /// Poses every 10 ms, images every 100 ms, 3 ms after a pose. The calibration is camera().
  void writeSequence(const std::string& folder, const std::vector<double>& distortion = {}) const {
    std::string poses = "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n",
                images = "# color images\n# timestamp filename\n";
    for (int i = 0; i < 60; ++i) {
      const RigidMotion at = poseAt(0.01 * i);
      const cv::Vec4d q = quaternion(at.rotation);
      poses += stamp(0.01 * i);
      for (int k = 0; k < 3; ++k) poses += " " + std::to_string(at.translation[k]);
      for (const int k : {1, 2, 3, 0}) poses += " " + std::to_string(q[k]);
      poses += "\n";
    }
    for (int i = 0; i < 6; ++i) {
      const double time = 0.1 * i + 0.003;
      const std::string name = "rgb/" + stamp(time) + ".png";
      images += stamp(time) + " " + name + "\n";
      writeView(folder + "/" + name, poseAt(time), distortion);
    }
    write(folder + "/groundtruth.txt", poses);
    write(folder + "/rgb.txt", images);
    write(folder + "/calibration.txt", "260 255 163 117\n");
  }

  PosedPairReader open() const { return PosedPairReader(readTumRgbd("mine", path()), path()); }
};

TEST_F(TumRgbd, PairsAreStepsApartWithInterpolatedPoses) {
  writeSequence("walk");
  write("notes/readme", "");
  write("corrsel.yaml", "step: 2\n");
  EXPECT_TRUE(hasTumRgbd(path()));
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 4u);
  EXPECT_EQ(reader.id(0).text(), "mine/walk/1305031102.003000-1305031102.203000");
  for (std::size_t i = 0; i < 4; ++i) {
    const double time = 0.1 * static_cast<double>(i) + 0.003;
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.truth.kind, TruthKind::kFundamental);
    EXPECT_EQ(pair.left_name, "walk/rgb/" + stamp(time) + ".png");
    EXPECT_EQ(pair.right_name, "walk/rgb/" + stamp(time + 0.2) + ".png");
    expectTruth(pair, poseAt(time));
    const RigidMotion motion = poseAt(time + 0.2).inverse() * poseAt(time);
    EXPECT_LT(cv::norm(pair.truth.pose->translation - motion.translation), 1e-4);
    EXPECT_LT(cv::norm(pair.truth.pose->rotation - motion.rotation), 1e-4);
  }
  EXPECT_EQ(reader.ignored(), (std::vector<std::string>{"notes"}));
  EXPECT_EQ(
      reader.remarks()[0],
      "walk: of the 4 pairs of its 6 images that are 2 frames apart, 4 are used (step, max_pairs, max_gap, "
      "min_baseline in corrsel.yaml)");
  EXPECT_EQ(reader.files().size(), 1u + 3u + 6u);
}

TEST_F(TumRgbd, ImagesWithoutPoseAndShortBaselinesAreCounted) {
  writeSequence("walk");
  write("corrsel.yaml", "step: 1\nmax_gap: 0.005\n");
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { open(); }),
                       "gives no pair: walk: of the 5 pairs of its 6 images that are 1 frames apart, 0 are "
                       "used, 5 are left out "
                       "because an image has no pose within 0.005 s before and after it"))
      << errorOf<DatasetError>([&] { open(); });
  write("corrsel.yaml", "step: 1\nmin_baseline: 0.08\n");  // they are 0.055 m apart
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { open(); }),
                       "5 are left out because their baseline is below 0.08 m"));
  write("corrsel.yaml", "step: 1\nmax_pairs: 3\n");
  EXPECT_EQ(open().size(), 3u);
  write("corrsel.yaml", "step: 6\n");
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { open(); }),
                       "of the 0 pairs of its 6 images that are 6 frames apart"));
}

TEST_F(TumRgbd, TheFoldersNameTellsTheCamera) {
  writeSequence("rgbd_dataset_freiburg3_desk");
  writeSequence("fr1_xyz");
  writeSequence("rgbd_dataset_freiburg9_desk");
  for (const std::string folder : {"rgbd_dataset_freiburg3_desk", "fr1_xyz", "rgbd_dataset_freiburg9_desk"}) {
    std::filesystem::remove(path(folder + "/calibration.txt"));
  }
  write("corrsel.yaml", "step: 5\n");
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 3u);
  for (const std::size_t i : {0, 1}) {  // the published cameras have 640x480 px
    EXPECT_TRUE(contains(errorOf<DatasetError>([&] { reader.read(i); }),
                         std::string("the image has 320x240 px, the camera of freiburg") +
                             (i == 0 ? "1" : "3") + " is for 640x480 px"));
  }
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { reader.check(2); }),
                       "freiburg9_desk: the camera is not known: the folder's name has none of freiburg1,"));
  EXPECT_TRUE(
      contains(reader.remarks()[1], "fr1_xyz: images of the camera of freiburg1 (640x480 px) are undis"));
  // Images of freiburg3 are published without distortion.
  for (const std::string& remark : reader.remarks()) EXPECT_FALSE(contains(remark, "camera of freiburg3"));
}

TEST_F(TumRgbd, FaultsNameFileAndLine) {
  writeSequence("walk");
  const auto faultOf = [&](const std::string& file, const std::string& text) {
    writeSequence("walk");
    write("walk/" + file, text);
    const PosedPairReader reader = open();
    EXPECT_EQ(reader.id(0).text(), "mine/walk/all");
    return errorOf<DatasetError>([&] { reader.read(0); });
  };
  EXPECT_EQ(faultOf("groundtruth.txt", "# head\n1305031102.1 1 2 3 0 0 0\n"),
            path("walk/groundtruth.txt") +
                ": line 2: has 7 entries where 8 are expected (timestamp tx ty tz qx qy qz qw)");
  EXPECT_TRUE(contains(faultOf("groundtruth.txt", "now 1 2 3 0 0 0 1\n"),
                       "line 1: entry 1: 'now' is not a time; write it in seconds"));
  EXPECT_TRUE(contains(faultOf("groundtruth.txt", "1 1 2 3 0 0 0 0\n"), "line 1: the quaternion is 0 0 0 0"));
  EXPECT_TRUE(contains(faultOf("groundtruth.txt", "# nothing\n"), "groundtruth.txt: holds no pose"));
  EXPECT_TRUE(contains(faultOf("rgb.txt", "1305031102.1\n"),
                       path("walk/rgb.txt") + ": line 1: has 1 entries where 2 are expected"));
  EXPECT_TRUE(contains(faultOf("calibration.txt", "1 2 3\n"), "has 3 entries where 4, 8 or 9 are expected"));
  EXPECT_TRUE(mentions(faultOf("calibration.txt", "-1 2 3 4\n"), {"calibration.txt: ", "matrix", "-1"}));
  EXPECT_TRUE(
      contains(faultOf("calibration.txt", "1 2 3 4\n1 2 3 4\n"), "has 2 lines where one is expected"));
  writeSequence("walk");
  std::filesystem::remove(path("walk/groundtruth.txt"));
  const PosedPairReader reader = open();
  EXPECT_EQ(errorOf<DatasetError>([&] {
              reader.read(0);
            }).find(path("walk/groundtruth.txt") + ": the file is missing; a sequence of TUM RGB-D holds"),
            0u);
}

TEST_F(TumRgbd, AMissingImageCostsItsPairsOnly) {
  writeSequence("walk");
  write("corrsel.yaml", "step: 1\n");
  std::filesystem::remove(path("walk/rgb/" + stamp(0.003) + ".png"));
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 5u);
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { reader.check(0); }), ".png: the image is missing"));
  EXPECT_NO_THROW(reader.check(1));
}

}  // namespace
}  // namespace corrsel::core
