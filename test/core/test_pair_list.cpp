#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "datasets/pair_list.h"
#include "posed_scene.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

class PairList : public PosedScene {
 protected:
  void SetUp() override {
    PosedScene::SetUp();
    writeView("scene/images/a.png", left_);
    writeView("scene/images/b.png", right_);
  }

  /// The camera matrix and the pose as a list has them.
  std::string truth() const {
    const RigidMotion motion = right_.inverse() * left_;
    std::string pose;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) pose += " " + std::to_string(motion.rotation(row, column));
      pose += " " + std::to_string(motion.translation[row]);
    }
    return text(camera()) + text(camera()) + pose + " 0 0 0 1";
  }

  std::string line(const std::string& turns = "0 0") const {
    return "scene/images/a.png scene/images/b.png " + turns + truth() + "\n";
  }

  PosedPairReader open() const { return PosedPairReader(readPairList("mine", path()), path()); }

  std::string errorOfLine(const std::string& text) const {
    write("pairs.txt", line() + text + "\n");
    const PosedPairReader reader = open();
    EXPECT_EQ(reader.size(), 2u);
    EXPECT_NO_THROW(reader.read(0));
    return errorOf<DatasetError>([&] { reader.check(1); });
  }

  RigidMotion left_ = pose({0.02, -0.05, 0.01}, {-0.3, 0.1, 0});
  RigidMotion right_ = pose({-0.03, 0.06, 0.1}, {0.4, -0.1, 0.2});
};

TEST_F(PairList, ReadsPairsWithPose) {
  write("pairs.txt", line());
  const PosedPairReader reader = open();
  ASSERT_EQ(reader.size(), 1u);
  EXPECT_EQ(reader.id(0).text(), "mine/scene_images/a-b");
  const ImagePair pair = reader.read(0);
  EXPECT_EQ(pair.truth.kind, TruthKind::kFundamental);
  EXPECT_EQ(pair.left_name, "scene/images/a.png");
  EXPECT_EQ(pair.right_name, "scene/images/b.png");
  expectTruth(pair, left_);
  EXPECT_EQ(reader.files(), (std::vector<std::string>{path("pairs.txt"), path("scene/images/a.png"),
                                                      path("scene/images/b.png")}));
}

// SuperGlue's rotate_intrinsics() and rotate_pose_inplane() for np.rot90.
TEST_F(PairList, TurnsImagesAndCamerasTogether) {
  std::string lines;
  for (const char* turns : {"1 0", "2 3", "3 1", "0 2"}) lines += line(turns);
  write("pairs.txt", lines);
  const PosedPairReader reader = open();
  const int left_turns[] = {1, 2, 3, 0}, right_turns[] = {0, 3, 1, 2};
  for (std::size_t i = 0; i < 4; ++i) {
    const ImagePair pair = reader.read(i);
    EXPECT_EQ(pair.left.cols, left_turns[i] % 2 ? kHeight : kWidth);
    EXPECT_EQ(pair.right.cols, right_turns[i] % 2 ? kHeight : kWidth);
    EXPECT_EQ(pair.left_name, left_turns[i] ? "" : "scene/images/a.png");
    EXPECT_EQ(pair.right_name, right_turns[i] ? "" : "scene/images/b.png");
    expectTruth(pair, left_, left_turns[i]);
  }
  EXPECT_EQ(reader.id(1).pair, "a-b#2");
  const cv::Matx33d k = reader.read(0).truth.pose->left_camera;  // fy cy, fx w - 1 - cx
  EXPECT_LT(cv::norm(k - cv::Matx33d(255, 0, 117, 0, 260, 320 - 1 - 163, 0, 0, 1)), 1e-9);
}

TEST_F(PairList, ACameraThatOnlyTurnedHasAHomography) {
  const std::string turn = " 0.8 0 0.6 0 0 1 0 0 -0.6 0 0.8 0 0 0 0 1";
  write("pairs.txt", "scene/images/a.png scene/images/b.png 0 0" + text(camera()) + text(camera()) + turn);
  const ImagePair pair = open().read(0);
  EXPECT_EQ(pair.truth.kind, TruthKind::kHomography);
  const cv::Matx33d expected = camera() * cv::Matx33d(0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8) * camera().inv();
  EXPECT_LT(cv::norm(pair.truth.matrix - expected), 1e-6);
}

TEST_F(PairList, AnyNameWillDoForTheOnlyList) {
  write("scannet_with_gt.txt", "# comment\n" + line());
  write("notes.txt", "some words");
  EXPECT_TRUE(hasPairList(path()));
  EXPECT_EQ(open().size(), 1u);
  write("other.txt", line());
  EXPECT_TRUE(contains(errorOf<DatasetError>([&] { open(); }),
                       "it has several lists of pairs, other.txt, scannet_with_gt.txt"));
  write("pairs.txt", line() + line());
  EXPECT_EQ(open().size(), 2u);  // it comes before all others
}

TEST_F(PairList, ImagesWithoutFolderAreASequenceOfTheListsName) {
  writeView("a.png", left_);
  write("scannet.txt", "a.png a.png 0 0" + truth());
  EXPECT_EQ(open().id(0).text(), "mine/scannet/a-a");
}

TEST_F(PairList, ListsWithoutPoseHaveNoTruth) {
  for (const char* turns : {"", " 0 0"}) {
    write("pairs.txt", std::string("scene/images/a.png scene/images/b.png") + turns + "\n");
    const std::string error = errorOf<DatasetError>([&] { open(); });
    EXPECT_TRUE(
        contains(error, "pairs.txt has no ground truth: its 1 lines name images, without calibration"))
        << error;
    EXPECT_TRUE(contains(error, "..._with_gt.txt")) << error;
  }
  EXPECT_TRUE(contains(errorOfLine("scene/images/a.png scene/images/b.png 0 0"),
                       path("pairs.txt") + ": line 2: has no ground truth"));
}

TEST_F(PairList, AFaultOfALineCostsItsPairOnly) {
  const std::string place = path("pairs.txt") + ": line 2: ";
  EXPECT_TRUE(contains(errorOfLine("scene/images/a.png scene/images/b.png 0 0 1 2 3"),
                       place + "has 7 entries where 38 are expected (image_a image_b turns_a"));
  EXPECT_EQ(errorOfLine(line("4 0")), place + "entry 3: '4' is not a number of quarter turns (0, 1, 2 or 3)");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = line();
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_TRUE(contains(errorOfLine(changed("260.000000", "wide")), place + "entry 5: 'wide'"));
  EXPECT_TRUE(contains(errorOfLine(changed("260.000000", "-260")), place + "K_a: matrix"));
  EXPECT_TRUE(contains(errorOfLine(changed(" 0.000000", " 5")), "K_a (entries 5 to 13) is not of the form"));
  EXPECT_TRUE(contains(errorOfLine(changed(" 0 0 0 1", " 0 0 0 2")),
                       "T_ab (entries 23 to 38) is not a rigid motion: its last row is not 0 0 0 1"));
  EXPECT_EQ(errorOfLine("scene/images/a.png scene/images/c.png 0 0" + truth()),
            path("scene/images/c.png") + ": the image is missing; the names in " + path("pairs.txt") +
                " are paths below " + path());
}

TEST_F(PairList, ACalibrationForAnotherSizeIsNoticed) {
  std::string text = line();
  for (std::size_t at = text.find("163.0"); at != std::string::npos; at = text.find("163.0", at + 1)) {
    text.replace(at, 5, "653.0");
  }
  write("pairs.txt", text);
  const std::string error = errorOf<DatasetError>([&] { open().read(0); });
  EXPECT_TRUE(contains(error, "a.png: the image has 320x240 px, and the principal point of K_a lies outside"))
      << error;
}

}  // namespace
}  // namespace corrsel::core
