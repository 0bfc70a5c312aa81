#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset_folder.h"
#include "datasets/pair_folders.h"
#include "geometry/cross_matrix.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using namespace testing;

constexpr char kIdentity[] = "1 0 0 0 1 0 0 0 1";
constexpr char kRectified[] = "0 0 0\n0 0 -1\n0 1 0\n";
constexpr char kNames[] = "x_left,y_left,x_right,y_right";

/// F = [t]_x R between two cameras with a focal length of 900 px.
cv::Matx33d fundamental() {
  const cv::Matx33d k(900, 0, 512, 0, 900, 384, 0, 0, 1);
  const double a = 0.1;
  const cv::Matx33d r(std::cos(a), 0, std::sin(a), 0, 1, 0, -std::sin(a), 0, std::cos(a));
  const cv::Matx33d f = k.inv().t() * crossMatrix({1, 0.2, 0.3}) * r * k.inv();
  return f * (1 / cv::norm(f));
}

/// The numbers of a matrix with so many significant digits.
std::string textOf(const cv::Matx33d& matrix, int digits) {
  std::string text;
  for (const double value : matrix.val) {
    char number[40];
    std::snprintf(number, sizeof(number), "%.*e ", digits - 1, value);
    text += number;
  }
  return text;
}

class PairFolders : public DatasetFolder {
 protected:
  void writeImages(const fs::path& folder) const {
    writeImage(folder / "left.png", 10);
    writeImage(folder / "right.png", 20);
  }

  ImagePair readOnly() const {
    const PairFolderReader reader("pairs", path());
    EXPECT_EQ(reader.size(), 1u);
    return reader.read(0);
  }

  /// The error of the only pair, which must be the same from check().
  std::string error() const {
    const PairFolderReader reader("pairs", path());
    EXPECT_EQ(reader.size(), 1u);
    const std::string text = errorOf<DatasetError>([&] { reader.read(0); });
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(0); }), text);
    return text;
  }
};

TEST_F(PairFolders, KindsOfTruthLieSideBySide) {
  for (const char* folder : {"a", "b", "e"}) writeImages(folder);
  write("a/H.txt", "1 0 5\n0 1 0\n0 0 1\n");
  write("b/F.txt", kRectified);
  write("c/matches.csv", std::string(kNames) + ",label\n1,2,3,4,1\n5,6,7,8,0\n");
  write("d/matches.csv", std::string(kNames) + "\n1,2,3,4\n");
  write("d/F.txt", kRectified);
  write("d/size.txt", "640 480\n320 240\n");
  write("e/matches.csv", std::string(kNames) + "\n1,2,3,4\n");
  write("e/H.txt", kIdentity);
  const PairFolderReader reader("mine", path());
  ASSERT_EQ(reader.size(), 5u);
  for (std::size_t i = 0; i < reader.size(); ++i) EXPECT_NO_THROW(reader.check(i)) << i;

  const ImagePair a = reader.read(0);
  EXPECT_EQ(a.id.text(), "mine/a/1-2");
  EXPECT_EQ(a.truth.kind, TruthKind::kHomography);
  EXPECT_EQ(a.truth.matrix(0, 2), 5);
  EXPECT_EQ(a.left.data[0], 10);
  EXPECT_EQ(a.right.data[0], 20);
  EXPECT_EQ(a.left_name, "a/left.png");
  EXPECT_EQ(a.right_name, "a/right.png");
  EXPECT_FALSE(a.given);

  const ImagePair b = reader.read(1);
  EXPECT_EQ(b.truth.kind, TruthKind::kFundamental);
  EXPECT_EQ(b.truth.matrix, cv::Matx33d(0, 0, 0, 0, 0, -1, 0, 1, 0));
  EXPECT_FALSE(b.given);

  const ImagePair c = reader.read(2);
  EXPECT_EQ(c.truth.kind, TruthKind::kLabels);
  EXPECT_EQ(c.left_name, "");
  EXPECT_EQ(c.truth.labels, (std::vector<std::uint32_t>{1, 0}));
  ASSERT_TRUE(c.given);
  EXPECT_EQ(c.given->size(), 2u);
  EXPECT_TRUE(c.left.empty());
  EXPECT_TRUE(c.given->left_size.empty());

  const ImagePair d = reader.read(3);
  EXPECT_EQ(d.truth.kind, TruthKind::kFundamental);
  ASSERT_TRUE(d.given);
  EXPECT_EQ(d.given->left_size, cv::Size(640, 480));
  EXPECT_EQ(d.given->right_size, cv::Size(320, 240));

  const ImagePair e = reader.read(4);
  EXPECT_EQ(e.truth.kind, TruthKind::kHomography);
  ASSERT_TRUE(e.given);
  EXPECT_EQ(e.given->left_size, cv::Size(20, 12));
  EXPECT_FALSE(e.left.empty());
  EXPECT_EQ(reader.files().size(), 3u + 3 + 1 + 3 + 4);
}

TEST_F(PairFolders, FundamentalMatricesAreRefusedUnlessOfRankTwo) {
  writeImages("s");
  for (const int digits : {4, 6, 17}) {
    for (const double scale : {1.0, 1e6, -1e-6}) {
      write("s/F.txt", textOf(fundamental() * scale, digits));
      EXPECT_EQ(readOnly().truth.kind, TruthKind::kFundamental) << digits << " " << scale;
    }
  }
  // Zeros that a computation leaves as tiny numbers.
  write("s/F.txt", "1e-19 2e-18 3e-17 1e-18 1e-19 -1 1e-17 1 1e-16");
  EXPECT_EQ(readOnly().truth.kind, TruthKind::kFundamental);
  const struct {
    std::string text, expected;
  } cases[] = {
      {kIdentity,
       "F.txt: the fundamental matrix does not have rank 2: its third singular value is 1 of the second"},
      {"1.2 0 -30 0 1.2 12 0 0 1", "does not have rank 2"},
      {textOf(fundamental(), 1), "write all digits of the matrix"},
      {"0 0 0 0 0 0 0 0 0", "F.txt: the fundamental matrix has a rank below 2"},
      {"0 0 0 0 0 0 0 0 1", "F.txt: the fundamental matrix has a rank below 2"},
      {"0 0 0 0 0 -1 0 1", "F.txt: holds 8 numbers where a fundamental matrix has 9"},
      {"0 0 0 0 0 -1 0 1 0 7", "F.txt: holds more than the 9 numbers of a fundamental matrix"},
      {"0 0 0 0 0 -1 0 inf 0", "F.txt: the fundamental matrix has an entry that is not finite"},
      {"0 0 0 0 0 minus 0 1 0", "F.txt: entry 6: 'minus' is not a number"},
  };
  for (const auto& c : cases) {
    write("s/F.txt", c.text);
    EXPECT_TRUE(contains(error(), c.expected)) << error() << "\nexpected: " << c.expected;
  }
}

TEST_F(PairFolders, TruthMustBeOne) {
  writeImages("s");
  EXPECT_EQ(error(), path("s") +
                         ": H.txt or F.txt is missing; a pair's folder holds left and right (.png, .jpg, "
                         "...) and H.txt or F.txt, or matches.csv");
  write("s/matches.csv", std::string(kNames) + "\n1,2,3,4\n");
  EXPECT_EQ(error(), path("s") +
                         ": there is no ground truth; add H.txt, F.txt or the column 'label' (1 = inlier, 0 "
                         "= outlier) to matches.csv");
  write("s/H.txt", kIdentity);
  EXPECT_EQ(readOnly().truth.kind, TruthKind::kHomography);
  write("s/F.txt", kRectified);
  EXPECT_EQ(error(),
            path("s") + ": H.txt and F.txt are several ground truths for one pair; keep one of them");
  fs::remove(path("s/F.txt"));
  write("s/matches.csv", std::string(kNames) + ",label\n1,2,3,4,1\n");
  EXPECT_EQ(error(), path("s") +
                         ": H.txt and the column 'label' of matches.csv are several ground truths for one "
                         "pair; keep one of them");
}

TEST_F(PairFolders, MatchesMustFitTheirImages) {
  write("s/matches.csv", std::string(kNames) + ",label\n1,2,3,4,1\n-0.5,2,700,4,1\n");
  EXPECT_FALSE(readOnly().given->left_size.width);
  const struct {
    std::string sizes, expected;
  } cases[] = {
      {"640 480 640 480", "matches.csv: match 2 lies at (700, 4), outside the right image of 640x480 px"},
      {"640 480 640", "size.txt: holds 3 numbers, not 4; write width and height of the left image"},
      {"640 480 640 0", "size.txt: '0' is not a number of pixels from 1"},
      {"640 480 640 wide", "size.txt: entry 4: 'wide' is not a number"},
  };
  for (const auto& c : cases) {
    write("s/size.txt", c.sizes);
    EXPECT_TRUE(contains(error(), path("s") + "/" + c.expected)) << error();
  }
  write("s/size.txt", "640 480 800 480");
  EXPECT_EQ(readOnly().given->right_size, cv::Size(800, 480));
  writeImages("s");
  EXPECT_TRUE(contains(error(), "size.txt: the images state their sizes themselves")) << error();
  fs::remove(path("s/size.txt"));
  const PairFolderReader reader("pairs", path());
  EXPECT_TRUE(
      contains(errorOf<DatasetError>([&] { reader.read(0); }), "outside the right image of 20x12 px"));
  fs::remove(path("s/right.png"));
  EXPECT_TRUE(contains(error(), "s/right: the image is missing")) << error();
}

TEST_F(PairFolders, TwoFilesForOneImageAreRefused) {
  writeImages("s");
  writeImage("s/left.JPG");
  write("s/H.txt", kIdentity);
  EXPECT_EQ(error(), path("s/left") +
                         ": left.JPG and left.png are several files for one image; keep the one to "
                         "which the ground truth belongs");
}

TEST_F(PairFolders, ReadsPlainPairsInEveryFormat) {
  const char* const extensions[] = {".png", ".jpg", ".jpeg", ".ppm", ".pgm", ".bmp", ".tif", ".webp", ".JPG"};
  for (const char* extension : extensions) {
    const std::string name = std::string("pair") + extension;
    writeImage(name + "/left" + extension, 40);
    writeImage(name + "/right" + extension, 80);
    write(name + "/H.txt", "1 0 5\n0 1 0\n0 0 1\n");
  }
  const PairFolderReader reader("pairs", path());
  ASSERT_EQ(reader.size(), std::size(extensions));
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    EXPECT_NEAR(pair.left.data[0], 40, 1) << pair.id.text();
    EXPECT_NEAR(pair.right.data[0], 80, 1) << pair.id.text();
    EXPECT_EQ(pair.truth.matrix(0, 2), 5);
  }
}

TEST_F(PairFolders, TypesThatAreNotReadAreNamed) {
  writeImage("s/left.png");
  write("s/right.heic", "");
  write("s/H.txt", "1 0 0 0 1 0 0 0 1");
  const PairFolderReader reader("pairs", path());
  EXPECT_EQ(errorOf<DatasetError>([&] { reader.read(0); }),
            path("s/right.heic") +
                ": files of this type are not read as images; .ppm, .pgm, .png, .jpg, .jpeg, "
                ".bmp, .tif, .tiff, .webp are; convert the image to PNG");
}

TEST_F(PairFolders, BadHomographiesAreNamed) {
  const struct {
    const char* text;
    const char* expected;
  } cases[] = {
      {"1 0 0\n0 1 0\n0\n", "holds 7 numbers where a homography has 9"},
      {"1 0 0 0 one 0 0 0 1", "'one' is not a number"},
      {"1 2 300 2 4 600 0 0 1", "singular"},
      {"1,0,0,0,1,0,0,0,1", "'1,0,0,0,1,0,0,0,1' is not a number"},
  };
  writeImage("a/left.png");
  writeImage("a/right.png");
  for (const auto& c : cases) {
    write("a/H.txt", c.text);
    const PairFolderReader reader("pairs", path());
    const std::string error = errorOf<DatasetError>([&] { reader.read(0); });
    EXPECT_TRUE(contains(error, path("a/H.txt") + ": ")) << error;
    EXPECT_TRUE(contains(error, c.expected)) << error;
    EXPECT_EQ(errorOf<DatasetError>([&] { reader.check(0); }), error);
  }
}

TEST_F(PairFolders, FoldersOfOtherThingsAreTold) {
  writeImage("pair/left.png");
  write("notes/todo.txt", "");
  write(".git/config", "");
  const PairFolderReader reader("pairs", path());
  EXPECT_EQ(reader.size(), 1u);
  EXPECT_EQ(reader.ignored(), std::vector<std::string>{"notes"});
}

TEST_F(PairFolders, OddNamesOfScenesComeThroughUnharmed) {
  const std::vector<std::string> names = {"a b", "a,b", "\"a\"", "<b>a", "a\nb", "a\\b", "..a", "\xc3\xa4"};
  std::vector<std::string> seen, expected;
  for (const std::string& name : names) {
    if (name[0] != '.') expected.push_back(name);
    writeImage(name + "/left.png");
    writeImage(name + "/right.png");
    write(name + "/H.txt", "1 0 0 0 1 0 0 0 1");
  }
  const PairFolderReader reader("pairs", path());
  for (std::size_t i = 0; i < reader.size(); ++i) {
    EXPECT_NO_THROW(reader.read(i)) << reader.id(i).text();
    seen.push_back(reader.id(i).sequence);
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(seen, expected);
}

/// Values up to `largest`, in an image whose values rise from left to right.
cv::Mat ramp(int type, int largest) {
  cv::Mat image(4, 64, type);
  for (int x = 0; x < image.cols; ++x)
    image.col(x).setTo(cv::Scalar::all(double(largest) * x / (image.cols - 1)));
  return image;
}

TEST_F(PairFolders, ImagesThatUseFewerThanSixteenBitsAreStretchedAlike) {
  for (const int type : {CV_16U, CV_16UC3}) {
    fs::create_directories(root_ / "deep");
    cv::imwrite(path("deep/left.png"), ramp(type, 4095));
    cv::imwrite(path("deep/right.png"), ramp(type, 900));  // the same camera, in the dark
    write("deep/H.txt", "1 0 5\n0 1 0\n0 0 1\n");
    const ImagePair pair = PairFolderReader("pairs", path()).read(0);
    ASSERT_EQ(pair.left.depth(), CV_8U);
    EXPECT_EQ(pair.left.channels(), CV_MAT_CN(type));
    EXPECT_EQ(pair.left.ptr(0, 63)[0], 255);
    EXPECT_EQ(pair.right.ptr(0, 63)[0], std::lround(900 * 255 / 4095.0));
    ASSERT_TRUE(pair.stretched.has_value());
    EXPECT_EQ(pair.stretched->bits, 12);
    EXPECT_TRUE(contains(pair.stretched->text(), "values up to 4095 in " + path("deep/left.png")))
        << pair.stretched->text();
  }
}

TEST_F(PairFolders, ImagesThatUseAllBitsAreScaledByTheDecoder) {
  for (const char* extension : {".png", ".tif", ".pgm"}) {
    const std::string name = std::string("deep") + extension;
    fs::create_directories(root_ / name);
    for (const char* side : {"/left", "/right"})
      cv::imwrite(path(name + side + extension), ramp(CV_16U, 65000));
    write(name + "/H.txt", "1 0 5\n0 1 0\n0 0 1\n");
  }
  const PairFolderReader reader("pairs", path());
  ASSERT_EQ(reader.size(), 3U);
  for (std::size_t i = 0; i < reader.size(); ++i) {
    const ImagePair pair = reader.read(i);
    const std::string name = pair.id.sequence;
    EXPECT_FALSE(pair.stretched.has_value());
    const cv::Mat expected = cv::imread(path(name + "/left" + name.substr(4)),
                                        cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
    EXPECT_EQ(cv::norm(pair.left, expected, cv::NORM_INF), 0) << name;
  }
}

}  // namespace
}  // namespace corrsel::core
