#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>

#include "base/temporary_folder.h"
#include "corrsel/database/colmap_store.h"
#include "corrsel/random.h"
#include "database/colmap_conventions.h"
#include "database/sqlite.h"
#include "geometry/rigid_motion.h"
#include "test_support.h"

using namespace corrsel::core;
using namespace corrsel::core::testing;

namespace {

namespace fs = std::filesystem;

TEST(ColmapConventions, NumbersOfPairs) {
  EXPECT_EQ(colmapPairNumber({1, 2}), 2147483649);
  EXPECT_EQ(colmapPairNumber({2147483645, 2147483646}), 4611686011984936961);
  EXPECT_EQ(colmapPairImages(4611686011984936961), (ImagePairKey{2147483645, 2147483646}));
}

TEST(ColmapConventions, MatricesHoldForPositionsFromTheCorner) {
  const cv::Matx33d f(1e-6, 2e-5, -0.01, -3e-5, 4e-6, 0.02, 0.03, -0.04, 1);
  const cv::Matx33d h(1, 0.1, 20, -0.1, 1.1, 30, 1e-4, 2e-4, 1);
  const cv::Matx33d f_colmap(colmapFundamental(f).data()), h_colmap(colmapHomography(h).data());
  const cv::Vec3d x(100, 200, 1), y(150, 80, 1), half(0.5, 0.5, 0);
  EXPECT_NEAR((y + half).dot(f_colmap * (x + half)), y.dot(f * x), 1e-12);
  const cv::Vec3d mapped = h * x, mapped_colmap = h_colmap * (x + half);
  EXPECT_NEAR(mapped_colmap[0] / mapped_colmap[2], mapped[0] / mapped[2] + 0.5, 1e-10);
  EXPECT_NEAR(mapped_colmap[1] / mapped_colmap[2], mapped[1] / mapped[2] + 0.5, 1e-10);
  EXPECT_LE(cv::norm(fundamentalFromColmap(colmapFundamental(f)) - f), 1e-15);
  EXPECT_LE(cv::norm(homographyFromColmap(colmapHomography(h)) - h), 1e-12);
}

TEST(ColmapConventions, QuaternionsOfRotations) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    cv::Vec4d q(random.normal(), random.normal(), random.normal(), random.normal());
    q *= (q[0] < 0 ? -1 : 1) / cv::norm(q);
    const auto back = colmapQuaternion(motionOf(q[0], q[1], q[2], q[3], {}).rotation);
    EXPECT_LE(cv::norm(cv::Vec4d(back.data()) - q), 1e-14);
  }
}

/// Two views of points, and what relates them.
struct Views {
  std::vector<cv::Point2f> first, second;  ///< px, from the centre of the first pixel
  TwoViewGeometry truth;
};

const cv::Matx33d kCamera = {700, 0, 310, 0, 710, 250, 0, 0, 1};
const cv::Size kSize = {640, 480};

/// @param planar  whether all points lie on one plane
Views makeViews(bool planar) {
  Random random(3);
  const double angle = 0.2;
  const cv::Matx33d r = {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
  cv::Vec3d t(-0.9, 0.3, 0.2);
  t /= cv::norm(t);
  const cv::Vec3d normal = cv::Vec3d(0.2, -0.1, 1);
  const double distance = 5;
  Views views;
  while (views.first.size() < 200) {
    const cv::Vec3d ray = kCamera.inv() * cv::Vec3d(640 * random.uniform(), 480 * random.uniform(), 1);
    const cv::Vec3d point = ray * (planar ? distance / normal.dot(ray) : 4 + 4 * random.uniform());
    const cv::Vec3d a = kCamera * point, b = kCamera * (r * point + t);
    const cv::Point2d second(b[0] / b[2], b[1] / b[2]);
    if (second.x < 0 || second.y < 0 || second.x > 639 || second.y > 479) continue;
    views.first.emplace_back(static_cast<float>(a[0] / a[2]), static_cast<float>(a[1] / a[2]));
    views.second.emplace_back(second);
  }
  const cv::Matx33d cross = {0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0};
  views.truth.essential = cross * r;
  views.truth.fundamental = kCamera.inv().t() * *views.truth.essential * kCamera.inv();
  views.truth.homography = kCamera * (r + t * normal.t() * (1 / distance)) * kCamera.inv();
  views.truth.pose = Pose{r, t};
  views.truth.config = TwoViewConfig::kCalibrated;
  for (std::uint32_t i = 0; i < views.first.size(); ++i) views.truth.inliers.push_back({i, i});
  return views;
}

/// Databases that Debian's COLMAP verifies, too.
class ColmapProgramTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v colmap > /dev/null") != 0) GTEST_SKIP() << "the program colmap is missing";
  }

  void runColmap(const std::string& arguments) const {
    const std::string command =
        "QT_QPA_PLATFORM=offscreen colmap " + arguments + " > '" + (folder / "log").string() + "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << readLog();
  }

  /// The option that makes COLMAP store poses. Its name depends on the version, and COLMAP 3.6 has none.
  std::string poseOption() const {
    runColmap("exhaustive_matcher --help");
    const std::string help = readLog();
    for (const char* option :
         {"TwoViewGeometry.compute_relative_pose", "SiftMatching.compute_relative_pose"}) {
      if (help.find(option) != std::string::npos) return std::string("--") + option + " 1 ";
    }
    return "";
  }

  std::string readLog() const {
    std::ifstream file(folder / "log");
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// Stores views with COLMAP's tables.
  /// @param exchange  whether the second view is the first image
  void store(const fs::path& path, const Views& views, bool exchange) const {
    ColmapStore::create(path);
    ColmapStore store(path, ColmapStore::Access::kWrite);
    cv::Mat descriptors(static_cast<int>(views.first.size()), 128, CV_8U);
    cv::randu(descriptors, 0, 90);
    for (const bool second : {exchange, !exchange}) {
      StoredImage image;
      image.name = second ? "second.jpg" : "first.jpg";
      image.size = kSize;
      image.camera = Camera{};
      image.camera->matrix = kCamera;
      image.camera->size = kSize;
      image.calibrated = true;
      store.addImage(image, {second ? views.second : views.first, {}}, descriptors);
    }
    StoredMatches matches;
    matches.rows = views.truth.inliers;
    store.writeMatches({{{1, 2}, matches}});
  }

  const TemporaryFolder temporary{"corrsel_colmap"};
  const fs::path folder = temporary.path();
};

/// The numbers of a column of the table two_view_geometries.
std::vector<double> numbersOf(const fs::path& path, const std::string& column) {
  const SqliteDatabase database(path, SqliteDatabase::Mode::kRead, 1);
  SqliteQuery query = database.query("SELECT " + column + " FROM two_view_geometries");
  if (!query.next()) return {};
  std::vector<double> numbers(query.blob(0).size / sizeof(double));
  std::memcpy(numbers.data(), query.blob(0).data, numbers.size() * sizeof(double));
  return numbers;
}

/// The difference of two columns that are equal up to scale and sign, after both got the length 1. Pixels of
/// F and H become parts of the image, so that all of their elements count.
double difference(const std::string& column, std::vector<double> a, std::vector<double> b) {
  if (a.empty() || a.size() != b.size()) return 1;
  const std::array<double, 3> width = {500, 500, 1};
  for (std::size_t i = 0; i < a.size(); ++i) {
    double factor = 1;
    if (column == "F") factor = width[i / 3] * width[i % 3];
    if (column == "H") factor = width[i % 3] / width[i / 3];
    a[i] *= factor;
    b[i] *= factor;
  }
  const cv::Mat first = cv::Mat(a) / cv::norm(a), second = cv::Mat(b) / cv::norm(b);
  return std::min(cv::norm(first - second), cv::norm(first + second));
}

constexpr double kTolerance = 2e-5;  // positions are floats

TEST_F(ColmapProgramTest, RowsOfExactPairsAgree) {
  const std::string pose_option = poseOption();
  const std::vector<std::string> matrices = {"F", "E"}, poses_too = {"F", "E", "qvec", "tvec"};
  const std::vector<std::string>& of_scene = pose_option.empty() ? matrices : poses_too;
  for (const bool planar : {false, true}) {
    const Views views = makeViews(planar);
    for (const bool exchange : {false, true}) {
      SCOPED_TRACE(std::string(planar ? "plane" : "scene") + (exchange ? ", exchanged" : ""));
      const std::string name = std::to_string(planar) + std::to_string(exchange);
      const fs::path theirs = folder / (name + "theirs.db"), ours = folder / (name + "ours.db");
      store(theirs, views, exchange);
      ColmapStore::copy(theirs, ours);
      VerifiedPair pair;
      pair.pair = {1, 2};
      pair.geometry = exchange ? exchanged(views.truth) : views.truth;
      ColmapStore(ours, ColmapStore::Access::kWrite).write({pair}, "truth");
      runColmap("exhaustive_matcher --SiftMatching.use_gpu 0 " + pose_option + "--database_path '" +
                theirs.string() + "'");
      const auto differs = [&](const std::string& column) {
        return difference(column, numbersOf(ours, column), numbersOf(theirs, column));
      };
      for (const std::string& column : planar ? std::vector<std::string>{"H"} : of_scene) {
        EXPECT_LE(differs(column), kTolerance) << column;
      }
      // The half pixel shows: without it, the matrices differ by more.
      const cv::Matx33d shifted = planar ? *pair.geometry.homography : *pair.geometry.fundamental;
      const std::string column = planar ? "H" : "F";
      EXPECT_GE(difference(column, {shifted.val, shifted.val + 9}, numbersOf(theirs, column)),
                4 * kTolerance);
      if (planar) continue;
      const VerifiedPair read = ColmapStore(theirs).verified({1, 2});
      EXPECT_EQ(read.geometry.inliers.size(), views.first.size());
      EXPECT_EQ(read.geometry.config, TwoViewConfig::kCalibrated);
      ASSERT_EQ(read.geometry.pose.has_value(), !pose_option.empty());
      if (!read.geometry.pose) continue;
      EXPECT_GT(read.geometry.pose->translation.dot(pair.geometry.pose->translation), 0);
    }
  }
}

TEST_F(ColmapProgramTest, ColmapLeavesVerifiedPairsAlone) {
  const fs::path path = folder / "house.db";
  const Views views = makeViews(false);
  store(path, views, false);
  VerifiedPair pair;
  pair.pair = {1, 2};
  pair.geometry = views.truth;
  pair.geometry.inliers.resize(100);
  ColmapStore(path, ColmapStore::Access::kWrite).write({pair}, "truth");
  std::ofstream(folder / "pairs.txt") << "first.jpg second.jpg\n";
  const std::string database = " --SiftMatching.use_gpu 0 --database_path '" + path.string() + "'";
  runColmap("exhaustive_matcher" + database);
  runColmap("matches_importer --match_list_path '" + (folder / "pairs.txt").string() + "'" + database);
  const ColmapStore store(path);
  EXPECT_EQ(store.verifiedPairs("truth").size(), 1U);
  EXPECT_EQ(store.verified({1, 2}).geometry.inliers, pair.geometry.inliers);
  EXPECT_EQ(store.matches({1, 2}).rows.size(), views.first.size());
}

TEST_F(ColmapProgramTest, DatabasesOfColmapAreRead) {
  const fs::path path = folder / "house.db";
  runColmap("database_creator --database_path '" + path.string() + "'");
  ColmapStore store(path, ColmapStore::Access::kWrite);
  EXPECT_TRUE(store.images().empty());
  StoredImage image;
  image.name = "a.jpg";
  image.size = kSize;
  store.addImage(image, {{{1, 2}}, {}}, cv::Mat());
  EXPECT_EQ(ColmapStore(path).keypoints(1).positions, (std::vector<cv::Point2f>{{1, 2}}));
}

}  // namespace
