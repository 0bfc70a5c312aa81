#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <fstream>

#include "base/temporary_folder.h"
#include "corrsel/database/colmap_store.h"
#include "database/sqlite.h"
#include "test_support.h"

using namespace corrsel::core;
using namespace corrsel::core::testing;

namespace {

using Access = ColmapStore::Access;
using Mode = SqliteDatabase::Mode;
namespace fs = std::filesystem;

constexpr std::int64_t kFactor = 2147483647;  // of the first image in a pair_id

StoredImage imageOf(const std::string& name) {
  StoredImage image;
  image.name = name;
  image.size = {640, 480};
  return image;
}

StoredKeypoints fourPoints() { return {{{0, 0}, {10.5F, 20.25F}, {639, 479}, {-0.5F, 479.5F}}, {}}; }

StoredMatches matchesOf(std::vector<KeypointPair> rows) {
  StoredMatches matches;
  matches.rows = std::move(rows);
  return matches;
}

/// A pair with everything that can be stored of it.
VerifiedPair verifiedPair(const ImagePairKey& key) {
  VerifiedPair pair;
  pair.pair = key;
  pair.putative = 3;
  pair.geometry.config = TwoViewConfig::kCalibrated;
  pair.geometry.inliers = {{0, 1}, {2, 3}};
  pair.geometry.fundamental = cv::Matx33d(1, 2, 3, 4, 5, 6, 7, 8, 9.5);
  pair.geometry.essential = cv::Matx33d(0, -1, 2, 1, 0, -3, -2, 3, 0);
  pair.geometry.homography = cv::Matx33d(1, 0.1, 20, -0.1, 1.1, 30, 1e-4, 2e-4, 1);
  const double c = std::cos(0.3), s = std::sin(0.3);
  pair.geometry.pose = Pose{{c, -s, 0, s, c, 0, 0, 0, 1}, {0.6, 0, 0.8}};
  pair.scene = SceneKind::kRigid;
  pair.confidence = 12.5;
  pair.ambiguity = std::numeric_limits<double>::quiet_NaN();
  return pair;
}

/// A folder that is removed at the end, with a database of three images and two pairs.
class ColmapStoreTest : public ::testing::Test {
 protected:
  ColmapStoreTest() {
    path = folder / "house.db";
    ColmapStore::create(path);
    ColmapStore store(path, Access::kWrite);
    for (const char* image : {"a.jpg", "b.jpg", "c.jpg"}) {
      store.addImage(imageOf(image), fourPoints(), cv::Mat());
    }
    store.writeMatches({{first, matchesOf({{0, 1}, {1, 2}, {2, 3}})}, {second, matchesOf({{3, 0}})}});
  }

  /// Changes the database as another program.
  void change(const std::string& sql) const { SqliteDatabase(path, Mode::kWrite, 1).execute(sql); }

  std::int64_t number(const std::string& sql) const {
    const SqliteDatabase database(path, Mode::kRead, 1);
    SqliteQuery query = database.query(sql);
    return query.next() ? query.integer(0) : -1;
  }

  /// The error of an action on the database.
  template <typename Action>
  std::string errorWith(const Action& action, StoreError::Kind kind = StoreError::Kind::kContent) const {
    try {
      action();
    } catch (const StoreError& error) {
      EXPECT_EQ(error.kind(), kind) << error.what();
      return error.what();
    }
    return "";
  }

  std::string keypointError() const {
    return errorWith([&] { ColmapStore(path).keypoints(1); });
  }

  std::string matchError() const {
    return errorWith([&] { ColmapStore(path).matches(first); });
  }

  std::string openError() const {
    return errorWith([&] { ColmapStore(path, Access::kWrite); });
  }

  const ImagePairKey first{1, 2}, second{1, 3};
  const TemporaryFolder temporary{"corrsel_store"};
  const fs::path folder = temporary.path();
  fs::path path;
};

TEST_F(ColmapStoreTest, ReadsImagesKeypointsAndMatches) {
  const ColmapStore store(path);
  ASSERT_EQ(store.images().size(), 3U);
  EXPECT_EQ(store.images()[1].id, 2U);
  EXPECT_EQ(store.images()[1].name, "b.jpg");
  EXPECT_EQ(store.images()[1].size, cv::Size(640, 480));
  EXPECT_FALSE(store.images()[1].calibrated);
  ASSERT_TRUE(store.images()[1].camera);
  EXPECT_DOUBLE_EQ(store.images()[1].camera->matrix(0, 0), 1.2 * 640);
  EXPECT_EQ(store.pairs(), (std::vector<ImagePairKey>{first, second}));
  EXPECT_EQ(store.matches(first).rows, (std::vector<KeypointPair>{{0, 1}, {1, 2}, {2, 3}}));
  EXPECT_EQ(store.keypoints(3).positions, fourPoints().positions);
  EXPECT_TRUE(store.keypoints(3).frames.empty());
  EXPECT_TRUE(store.warnings().empty());
  EXPECT_EQ(number("SELECT pair_id FROM matches WHERE rows = 1"), kFactor + 3);
  EXPECT_EQ(number("PRAGMA user_version"), 3800);
}

TEST_F(ColmapStoreTest, ReadsKeypointsOfTwoFourAndSixColumns) {
  const float rows[2][6] = {{10.5F, 20.5F, 2, -1, 3, 4}, {30.5F, 40.5F, 5, 6, 7, 8}};
  const auto store = [&](int columns) {
    std::vector<float> values;
    for (const auto& row : rows) values.insert(values.end(), row, row + columns);
    const SqliteDatabase database(path, Mode::kWrite, 1);
    database.query("UPDATE keypoints SET rows = 2, cols = ?1, data = ?2 WHERE image_id = 1")
        .bind(1, std::int64_t{columns})
        .bind(2, SqliteBlob{reinterpret_cast<const unsigned char*>(values.data()), values.size() * 4})
        .run();
    return ColmapStore(path).keypoints(1);
  };
  for (const int columns : {2, 4, 6}) {
    const StoredKeypoints keypoints = store(columns);
    EXPECT_EQ(keypoints.positions, (std::vector<cv::Point2f>{{10, 20}, {30, 40}})) << columns;
    ASSERT_EQ(keypoints.frames.size(), columns == 2 ? 0U : 2U);
    if (columns == 6) {
      EXPECT_EQ(keypoints.frames[1], (AffineFrame{5, 6, 30, 7, 8, 40}));
    }
    if (columns != 4) continue;
    // A rotation by the angle -1 times the scale 2.
    const float c = 2 * std::cos(1.0F), s = 2 * std::sin(-1.0F);
    const AffineFrame expected = {c, -s, 10, s, c, 20};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(keypoints.frames[0][i], expected[i]) << i;
  }
}

TEST_F(ColmapStoreTest, FramesAndDescriptorsAreReadBack) {
  StoredKeypoints keypoints{{{1, 2}, {3, 4}}, {{1, 2, 1, 3, 4, 2}, {5, 6, 3, 7, 8, 4}}};
  cv::Mat descriptors(2, 256, CV_8U);
  for (int i = 0; i < 512; ++i) descriptors.data[i] = static_cast<unsigned char>(i);
  descriptors = descriptors.colRange(0, 128);  // rows that are not adjacent in memory
  ColmapStore store(path, Access::kWrite);
  const std::uint32_t id = store.addImage(imageOf("d.jpg"), keypoints, descriptors);
  EXPECT_EQ(id, 4U);
  EXPECT_EQ(store.images().back().name, "d.jpg");
  EXPECT_EQ(store.keypoints(id).frames, keypoints.frames);
  EXPECT_EQ(cv::norm(store.descriptors(id), descriptors, cv::NORM_INF), 0);
  EXPECT_TRUE(mentions(errorWith([&] { store.descriptors(1); }), {"descriptors", "image_id 1", "a.jpg"}));
  EXPECT_TRUE(mentions(errorWith([&] { store.addImage(imageOf("d.jpg"), keypoints, descriptors); }),
                       {"images", "d.jpg"}));
}

TEST_F(ColmapStoreTest, ReadsBackVerifications) {
  ColmapStore store(path, Access::kWrite);
  VerifiedPair rejected;
  rejected.pair = second;
  rejected.putative = 1;
  rejected.status = Status::kTooFew;
  VerifiedPair faulty;
  faulty.pair = {2, 3};
  faulty.faulty = true;
  const VerifiedPair pair = verifiedPair(first);
  store.write({pair, rejected, faulty}, "auto");
  EXPECT_EQ(store.verifiedPairs("auto"), (std::vector<ImagePairKey>{first, second}));
  EXPECT_TRUE(store.verifiedPairs("other").empty());
  const VerifiedPair back = ColmapStore(path).verified(first);
  EXPECT_EQ(back.geometry.config, TwoViewConfig::kCalibrated);
  EXPECT_EQ(back.geometry.inliers, pair.geometry.inliers);
  EXPECT_LE(cv::norm(*back.geometry.fundamental - *pair.geometry.fundamental), 1e-12);
  EXPECT_EQ(*back.geometry.essential, *pair.geometry.essential);
  EXPECT_LE(cv::norm(*back.geometry.homography - *pair.geometry.homography), 1e-12);
  EXPECT_LE(cv::norm(back.geometry.pose->rotation - pair.geometry.pose->rotation), 1e-14);
  EXPECT_EQ(back.geometry.pose->translation, pair.geometry.pose->translation);
  EXPECT_EQ(back.confidence, 12.5);
  EXPECT_TRUE(std::isnan(back.ambiguity));
  EXPECT_EQ(back.scene, SceneKind::kRigid);
  EXPECT_EQ(back.putative, 3U);
  const VerifiedPair none = store.verified(second);
  EXPECT_EQ(none.geometry.config, TwoViewConfig::kUndefined);
  EXPECT_EQ(none.status, Status::kTooFew);
  EXPECT_TRUE(none.geometry.inliers.empty());
  EXPECT_FALSE(none.geometry.fundamental || none.geometry.essential || none.geometry.homography ||
               none.geometry.pose);
  EXPECT_EQ(number("SELECT count(*) FROM two_view_geometries WHERE rows = 0 AND config = 0 AND F IS NULL"),
            1);
}

TEST_F(ColmapStoreTest, RowsOfOtherProgramsAreToldApart) {
  ColmapStore store(path, Access::kWrite);
  change("INSERT INTO two_view_geometries(pair_id, rows, cols, config) VALUES (2147483649, 0, 2, 0)");
  EXPECT_EQ(store.pairsOfOthers(), std::vector<ImagePairKey>{first});
  EXPECT_TRUE(std::isnan(store.verified(first).confidence));
  store.write({verifiedPair(first), verifiedPair(second)}, "auto");
  EXPECT_TRUE(store.pairsOfOthers().empty());
  change("UPDATE two_view_geometries SET config = 3 WHERE pair_id = 2147483649");
  EXPECT_EQ(store.pairsOfOthers(), std::vector<ImagePairKey>{first});
  EXPECT_EQ(store.verifiedPairs("auto"), std::vector<ImagePairKey>{second});
  change("DELETE FROM two_view_geometries");
  EXPECT_TRUE(store.verifiedPairs("auto").empty());
}

TEST_F(ColmapStoreTest, NewMatchesRemoveTheOldVerification) {
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair(first), verifiedPair(second)}, "auto");
  store.writeMatches({{first, matchesOf({{3, 3}})}});
  EXPECT_EQ(store.verifiedPairs("auto"), std::vector<ImagePairKey>{second});
  EXPECT_EQ(store.matches(first).rows, (std::vector<KeypointPair>{{3, 3}}));
  EXPECT_EQ(number("SELECT count(*) FROM two_view_geometries"), 1);
}

TEST_F(ColmapStoreTest, CamerasOfTheModels) {
  ColmapStore store(path, Access::kWrite);
  StoredImage image = imageOf("e.jpg");
  image.camera = Camera{};
  image.camera->matrix = {500, 0, 319, 0, 510, 239, 0, 0, 1};
  image.camera->distortion = {0.1, -0.05, 1e-3, 2e-3};
  image.camera->size = image.size;
  image.calibrated = true;
  store.addImage(image, fourPoints(), cv::Mat());
  image.name = "f.jpg";
  store.addImage(image, fourPoints(), cv::Mat());
  EXPECT_EQ(number("SELECT count(*) FROM cameras"), 4);  // one for a.jpg to c.jpg each
  EXPECT_EQ(number("SELECT model FROM cameras WHERE camera_id = 4"), 4);
  const ColmapStore reader(path);
  EXPECT_TRUE(reader.images()[4].calibrated);
  EXPECT_EQ(*reader.images()[4].camera, *image.camera);
}

TEST_F(ColmapStoreTest, CamerasThatAreMissingInCorrselAreSaidOnce) {
  change("UPDATE images SET camera_id = 1");
  change("UPDATE cameras SET model = 7, params = zeroblob(40), prior_focal_length = 1 WHERE camera_id = 1");
  const ColmapStore fov(path);
  ASSERT_EQ(fov.warnings().size(), 1U);
  EXPECT_TRUE(mentions(fov.warnings()[0], {"cameras", "camera_id 1", "FOV", "without calibration"}));
  EXPECT_FALSE(fov.images()[0].camera);
  EXPECT_FALSE(fov.images()[0].calibrated);
  EXPECT_EQ(fov.images()[0].size, cv::Size(640, 480));
  change("UPDATE cameras SET model = 99 WHERE camera_id = 1");
  EXPECT_TRUE(mentions(ColmapStore(path).warnings().at(0), {"camera_id 1", "number 99"}));
  change("UPDATE cameras SET model = 1, params = zeroblob(9) WHERE camera_id = 1");
  EXPECT_TRUE(mentions(ColmapStore(path).warnings().at(0), {"camera_id 1", "9 bytes"}));
  change("UPDATE cameras SET params = zeroblob(24) WHERE camera_id = 1");
  EXPECT_TRUE(mentions(ColmapStore(path).warnings().at(0), {"camera_id 1", "PINHOLE"}));
}

TEST_F(ColmapStoreTest, NewerSchemasWork) {
  change("PRAGMA user_version = 99999");
  change("ALTER TABLE two_view_geometries ADD COLUMN camera1 BLOB");
  change("ALTER TABLE two_view_geometries ADD COLUMN kind INTEGER NOT NULL DEFAULT 5");
  change("CREATE TABLE rigs (rig_id INTEGER PRIMARY KEY)");
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair(first)}, "auto");
  EXPECT_EQ(store.verified(first).geometry.inliers, verifiedPair(first).geometry.inliers);
  EXPECT_EQ(number("SELECT kind FROM two_view_geometries"), 5);
  EXPECT_EQ(number("PRAGMA user_version"), 99999);
}

TEST_F(ColmapStoreTest, ColumnsThatMustBeFilledAreRefused) {
  change("ALTER TABLE two_view_geometries RENAME TO old");
  change(
      "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows, cols, data, config, F, E, H, "
      "colour INTEGER NOT NULL)");
  EXPECT_TRUE(mentions(openError(), {"house.db", "two_view_geometries", "colour"}));
  EXPECT_NO_THROW(ColmapStore{path});
}

TEST_F(ColmapStoreTest, SchemasWithoutPosesWork) {
  change("ALTER TABLE two_view_geometries RENAME TO old");
  change("CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows, cols, data, config, F, E, H)");
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair(first)}, "auto");
  EXPECT_FALSE(store.verified(first).geometry.pose);
  EXPECT_TRUE(store.verified(first).geometry.essential);
}

TEST_F(ColmapStoreTest, MissingTablesAndColumnsAreNamed) {
  change("ALTER TABLE two_view_geometries RENAME COLUMN F TO G");
  EXPECT_TRUE(mentions(openError(), {"house.db", "two_view_geometries", "no column F", "3.4"}));
  change("DROP TABLE matches");
  EXPECT_TRUE(mentions(openError(), {"house.db", "no table matches", "COLMAP"}));
}

TEST_F(ColmapStoreTest, ImagesWithoutCamera) {
  change("PRAGMA foreign_keys = OFF; UPDATE images SET camera_id = 77 WHERE image_id = 1");
  EXPECT_EQ(ColmapStore(path).images()[0].size, cv::Size(0, 0));
  EXPECT_TRUE(mentions(keypointError(), {"images", "image_id 1", "a.jpg", "camera_id 77", "cameras"}));
  change("UPDATE images SET camera_id = 1; UPDATE cameras SET height = 0 WHERE camera_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"image_id 1", "a.jpg", "640x0", "cameras"}));
}

TEST_F(ColmapStoreTest, DamagedKeypoints) {
  change("UPDATE keypoints SET data = zeroblob(31) WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "image_id 1", "31 bytes", "4 x 2 x 4", "damaged"}));
  change("UPDATE keypoints SET data = zeroblob(48), cols = 3 WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "image_id 1", "3 columns", "2, 4 or 6"}));
  change("UPDATE keypoints SET cols = -2 WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "48 bytes", "4 x -2 x 4"}));
  change("UPDATE keypoints SET rows = 'many' WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "rows", "'many'"}));
  change("UPDATE keypoints SET rows = 4, cols = 2, data = 'text' WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "image_id 1", "no BLOB"}));
  change("DELETE FROM keypoints WHERE image_id = 1");
  EXPECT_TRUE(mentions(keypointError(), {"keypoints", "image_id 1 (a.jpg)", "missing"}));
  change("INSERT INTO keypoints VALUES (1, 0, 2, NULL)");
  EXPECT_TRUE(ColmapStore(path).keypoints(1).positions.empty());
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore(path).keypoints(9); }), {"image_id 9", "images"}));
}

TEST_F(ColmapStoreTest, PositionsOutsideAndNotFinite) {
  StoredKeypoints keypoints = fourPoints();
  keypoints.positions[0] = {-1.4F, 480.4F};  // a pixel outside is allowed
  keypoints.positions[1].x = std::numeric_limits<float>::quiet_NaN();
  keypoints.positions[2].y = std::numeric_limits<float>::infinity();
  ColmapStore store(path, Access::kWrite);
  const std::uint32_t d = store.addImage(imageOf("d.jpg"), keypoints, cv::Mat());
  EXPECT_EQ(store.keypoints(d).positions[0], keypoints.positions[0]);
  store.keypoints(d);
  ASSERT_EQ(store.warnings().size(), 1U);
  EXPECT_TRUE(mentions(store.warnings()[0], {"keypoints", "image_id 4 (d.jpg)", "2 of 4", "not finite"}));
  keypoints.positions[0] = {640.75F, 20};
  const std::uint32_t e = store.addImage(imageOf("e.jpg"), keypoints, cv::Mat());
  EXPECT_TRUE(mentions(errorWith([&] { store.keypoints(e); }),
                       {"keypoints", "image_id 5 (e.jpg)", "keypoint 0", "641.25", "640x480", "reduced"}));
}

TEST_F(ColmapStoreTest, DamagedMatches) {
  change("UPDATE matches SET data = zeroblob(23) WHERE pair_id = 2147483649");
  EXPECT_TRUE(mentions(matchError(), {"matches", "pair_id 2147483649", "23 bytes", "3 x 2 x 4"}));
  change("UPDATE matches SET cols = 3, data = zeroblob(36) WHERE pair_id = 2147483649");
  EXPECT_TRUE(mentions(matchError(), {"matches", "pair_id 2147483649", "3 columns", "expected 2"}));
  change("UPDATE matches SET rows = 0, cols = 2, data = NULL WHERE pair_id = 2147483649");
  EXPECT_TRUE(ColmapStore(path).matches(first).rows.empty());
  const std::string beyond = errorWith([&] {
    ColmapStore(path, Access::kWrite).writeMatches({{first, matchesOf({{0, 0}, {3, 4}})}});
  });
  EXPECT_TRUE(mentions(beyond, {"pair_id 2147483649", "match 1", "keypoint 4", "image_id 2 (b.jpg)"}));
  change("UPDATE matches SET rows = 1, data = x'0000000004000000' WHERE pair_id = 2147483649");
  EXPECT_TRUE(mentions(
      matchError(), {"matches", "pair_id 2147483649", "match 0", "keypoint 4 of image_id 2", "which has 4"}));
  EXPECT_TRUE(mentions(errorWith([&] {
                         ColmapStore(path).matches({1, 9});
                       }),
                       {"matches", "is missing", "match 'a.jpg' and image_id 9 first"}));
  change("DELETE FROM images WHERE image_id = 2");
  EXPECT_TRUE(mentions(matchError(), {"matches", "pair_id 2147483649", "no image_id 2", "images"}));
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore(path).matches({2, 3}); }), {"matches", "is missing"}));
}

TEST_F(ColmapStoreTest, RowsThatAreNoPairAreSkippedAndCounted) {
  change("INSERT INTO matches VALUES (4294967296, 0, 2, NULL), (6442450942, 0, 2, NULL)");  // (2, 2), (3, 1)
  const ColmapStore store(path);
  EXPECT_EQ(store.pairs().size(), 2U);
  store.pairs();
  ASSERT_EQ(store.warnings().size(), 1U);
  EXPECT_TRUE(mentions(store.warnings()[0], {"matches", "2 rows", "4294967296", "itself"}));
}

TEST_F(ColmapStoreTest, PairsThatStandThereTwice) {
  change(
      "ALTER TABLE matches RENAME TO old; CREATE TABLE matches (pair_id INTEGER, rows, cols, data); "
      "INSERT INTO matches SELECT * FROM old; INSERT INTO matches SELECT * FROM old WHERE rows = 1");
  const ColmapStore store(path);
  EXPECT_EQ(store.pairs(), (std::vector<ImagePairKey>{first, second}));
  ASSERT_EQ(store.warnings().size(), 1U);
  EXPECT_TRUE(mentions(store.warnings()[0], {"matches", "1 row", "pair_id"}));
  change("DELETE FROM matches");
  const ColmapStore empty(path);
  EXPECT_TRUE(empty.pairs().empty());
  EXPECT_TRUE(mentions(empty.warnings().at(0), {"matches is empty", "matchers"}));
}

TEST_F(ColmapStoreTest, DamagedGeometries) {
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair(first)}, "auto");
  const auto error = [&] { return errorWith([&] { store.verified(first); }); };
  change("UPDATE two_view_geometries SET F = zeroblob(71)");
  EXPECT_TRUE(mentions(error(), {"two_view_geometries", "pair_id 2147483649", "72"}));
  change("UPDATE two_view_geometries SET F = NULL, qvec = zeroblob(32)");
  EXPECT_TRUE(mentions(error(), {"two_view_geometries", "pair_id 2147483649", "qvec"}));
  change("UPDATE two_view_geometries SET config = 9");
  EXPECT_TRUE(mentions(error(), {"two_view_geometries", "config is 9"}));
  EXPECT_TRUE(mentions(errorWith([&] { store.verified(second); }), {"two_view_geometries", "is missing"}));
}

TEST_F(ColmapStoreTest, FilesThatAreNoDatabase) {
  std::ofstream(folder / "text.db") << std::string(4096, 'x');
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore(folder / "text.db"); }), {"text.db", "no database"}));
  std::ofstream(folder / "empty.db") << "";
  EXPECT_TRUE(
      mentions(errorWith([&] { ColmapStore(folder / "empty.db"); }), {"empty.db", "no table cameras"}));
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore(folder / "none.db"); }, StoreError::Kind::kStorage),
                       {"none.db", "does not exist"}));
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore::create(path); }, StoreError::Kind::kStorage),
                       {"house.db", "exists already"}));
}

TEST_F(ColmapStoreTest, CutFilesAreNamed) {
  change("PRAGMA wal_checkpoint(TRUNCATE)");
  fs::resize_file(path, fs::file_size(path) / 2);
  const std::string error = errorWith([&] {
    const ColmapStore store(path);
    store.pairs();
    for (const ImagePairKey& pair : {first, second}) store.matches(pair);
    for (const std::uint32_t image : {1, 2, 3}) store.keypoints(image);
  });
  EXPECT_TRUE(mentions(error, {"house.db", "damaged"}));
}

TEST_F(ColmapStoreTest, OtherProgramsThatWrite) {
  for (const char* mode : {"WAL", "DELETE"}) {
    change(std::string("PRAGMA journal_mode = ") + mode);
    ColmapStore store(path, Access::kWrite, 0.2);
    const SqliteDatabase other(path, Mode::kWrite, 1);
    const SqliteTransaction transaction(other);
    const auto busy = StoreError::Kind::kBusy;
    const std::string text = "house.db is being written by another program; nothing was changed";
    EXPECT_TRUE(mentions(errorWith([&] { ColmapStore(path, Access::kWrite, 0.2); }, busy), {text, "0.2 s"}));
    EXPECT_TRUE(mentions(errorWith([&] { store.write({verifiedPair(first)}, "auto"); }, busy), {text}));
    EXPECT_EQ(ColmapStore(path).matches(first).rows.size(), 3U) << mode << ": reading is not blocked";
  }
}

TEST_F(ColmapStoreTest, AWriteIsDoneOrNot) {
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair({2, 3})}, "auto");
  change(
      "CREATE TRIGGER refuse BEFORE INSERT ON corrsel_verify WHEN NEW.pair_id = 2147483650 BEGIN "
      "SELECT RAISE(ABORT, 'not this pair'); END");
  const std::string error = errorWith([&] {
    store.write({verifiedPair(first), verifiedPair(second)}, "auto");
  });
  EXPECT_TRUE(mentions(error, {"house.db", "not this pair", "1 verified pairs are stored"}));
  EXPECT_EQ(store.verifiedPairs("auto"), (std::vector<ImagePairKey>{{2, 3}}));
  EXPECT_EQ(number("SELECT count(*) FROM two_view_geometries"), 1);
  EXPECT_THROW(ColmapStore(path).write({}, "auto"), std::logic_error);
}

TEST_F(ColmapStoreTest, FullDisksAreNamed) {
  const SqliteDatabase database(path, Mode::kWrite, 1);
  database.query("PRAGMA max_page_count = 1").next();  // SQLite takes the number of pages that there are
  const std::string error = errorWith(
      [&] {
        const SqliteTransaction transaction(database);
        database.execute("CREATE TABLE large AS SELECT zeroblob(100000) AS data");
      },
      StoreError::Kind::kStorage);
  EXPECT_TRUE(mentions(error, {"house.db", "disk is full", "make room"}));
  EXPECT_EQ(number("SELECT count(*) FROM sqlite_master WHERE name = 'large'"), 0);
}

TEST_F(ColmapStoreTest, WritesThatFailLeaveTheRowsOfBefore) {
  ColmapStore store(path, Access::kWrite);
  store.write({verifiedPair(first)}, "auto");
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{fs::file_size(path), before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  VerifiedPair large = verifiedPair(second);
  large.geometry.inliers.resize(1000000);
  const std::string error = errorWith([&] { store.write({large}, "auto"); }, StoreError::Kind::kStorage);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(mentions(error, {"house.db", "disk", "1 verified pairs are stored"}));
  EXPECT_EQ(store.verifiedPairs("auto"), std::vector<ImagePairKey>{first});
  store.write({verifiedPair(second)}, "auto");
  EXPECT_EQ(store.verifiedPairs("auto").size(), 2U);
}

/// Runs an action in another process, as a user without the rights of root. @return the exit code, 0 to 9
template <typename Action>
int exitCodeOf(const Action& action, bool as_nobody = false) {
  const pid_t child = fork();
  if (child == 0) {
    if (as_nobody && geteuid() == 0 && seteuid(65534) != 0) _exit(9);
    try {
      _exit(action());
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
      _exit(8);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST_F(ColmapStoreTest, PlacesThatCannotBeWritten) {
  enum { kReads = 1, kRefuses = 2 };
  const auto attempt = [&] {
    int outcome = 0;
    if (ColmapStore(path).pairs().size() == 2) outcome |= kReads;
    try {
      ColmapStore store(path, Access::kWrite);
    } catch (const StoreError& error) {
      if (error.kind() == StoreError::Kind::kStorage && mentions(error.what(), {"house.db", "permi"})) {
        outcome |= kRefuses;
      } else if (mentions(error.what(), {"house.db", "allow writing"})) {
        outcome |= kRefuses;
      }
    }
    return outcome;
  };
  const fs::perms read = fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read;
  const fs::perms enter = fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
  for (const char* mode : {"WAL", "DELETE"}) {
    change(std::string("PRAGMA journal_mode = ") + mode);
    fs::permissions(path, read);
    fs::permissions(folder, fs::perms::all);
    EXPECT_EQ(exitCodeOf(attempt, true), kReads | kRefuses) << mode << ": a file that cannot be written";
    fs::permissions(path, fs::perms::all);
    fs::permissions(folder, read | enter);
    EXPECT_EQ(exitCodeOf(attempt, true), kReads | kRefuses) << mode << ": a folder that cannot be written";
    fs::permissions(folder, fs::perms::all);
  }
}

TEST_F(ColmapStoreTest, KilledWritersLeaveNoHalfTransaction) {
  for (const char* mode : {"WAL", "DELETE"}) {
    change(std::string("PRAGMA journal_mode = ") + mode);
    for (int attempt = 0; attempt < 2; ++attempt) {
      const auto killed = [&] {
        const SqliteDatabase database(path, Mode::kWrite, 1);
        database.execute("PRAGMA cache_size = 2");  // so that the transaction reaches the file before its end
        database.execute("BEGIN IMMEDIATE");
        database.execute("UPDATE matches SET rows = 77, data = zeroblob(100000)");
        database.execute("CREATE TABLE half AS SELECT zeroblob(1000000)");
        return raise(SIGKILL);
      };
      EXPECT_EQ(exitCodeOf(killed), -SIGKILL);
      const ColmapStore store(path, Access::kWrite);
      EXPECT_EQ(store.matches(first).rows.size(), 3U);
      EXPECT_EQ(number("SELECT count(*) FROM sqlite_master WHERE name = 'half'"), 0);
    }
  }
}

TEST_F(ColmapStoreTest, KilledRunsKeepWholeBatches) {
  for (int attempt = 0; attempt < 5; ++attempt) {
    const pid_t child = fork();
    if (child == 0) {
      ColmapStore store(path, Access::kWrite);
      for (;;) store.write({verifiedPair(first), verifiedPair(second)}, "run " + std::to_string(rand()));
    }
    usleep(30000U + 7000U * static_cast<unsigned>(attempt));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const ColmapStore store(path, Access::kWrite);
    if (number("SELECT count(*) FROM sqlite_master WHERE name = 'corrsel_verify'") == 0) continue;
    EXPECT_EQ(number("SELECT count(DISTINCT configuration) FROM corrsel_verify"), 1);
    EXPECT_EQ(number("SELECT count(*) FROM corrsel_verify JOIN two_view_geometries USING (pair_id)"), 2);
  }
  EXPECT_EQ(number("SELECT count(*) FROM two_view_geometries"), 2) << "no run has written";
}

TEST_F(ColmapStoreTest, CopiesHaveWhatIsInTheLog) {
  const SqliteDatabase other(path, Mode::kWrite, 1);
  other.execute("INSERT INTO matches VALUES (4294967297, 0, 2, NULL)");
  ASSERT_GT(fs::file_size(path.string() + "-wal"), 0U);
  const fs::path copy = folder / "copy.db";
  std::ofstream(copy.string() + ".part") << "of a run that was killed";
  std::ofstream(copy.string() + "-wal") << "of a database that is no more";
  ColmapStore::copy(path, copy);
  EXPECT_EQ(ColmapStore(copy).pairs().size(), 3U);
  EXPECT_FALSE(fs::exists(copy.string() + ".part"));
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore::copy(path, copy); }, StoreError::Kind::kStorage),
                       {"copy.db", "exists already"}));
  EXPECT_NE(
      errorWith([&] { ColmapStore::copy(path, folder / "none" / "copy.db"); }, StoreError::Kind::kStorage),
      "");
}

TEST_F(ColmapStoreTest, CopiesOfKilledRunsAreContinued) {
  const fs::path copy = folder / "copy.db.part";
  ColmapStore::continueCopy(path, copy);
  ColmapStore(copy, Access::kWrite).write({verifiedPair(first)}, "auto");
  ColmapStore::continueCopy(path, copy);
  EXPECT_EQ(ColmapStore(copy).verifiedPairs("auto").size(), 1U);
  ColmapStore(path, Access::kWrite).addImage(imageOf("other.jpg"), fourPoints(), cv::Mat());
  EXPECT_TRUE(mentions(errorWith([&] { ColmapStore::continueCopy(path, copy); }),
                       {"copy.db.part", "another database", "house.db", "remove it"}));
}

TEST_F(ColmapStoreTest, ReadingChangesNothing) {
  change("PRAGMA wal_checkpoint(TRUNCATE)");
  const auto bytes = [&] {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string before = bytes();
  {
    const ColmapStore store(path);
    for (const ImagePairKey& pair : store.pairs()) store.matches(pair);
  }
  { const ColmapStore store(path, Access::kWrite); }  // asks whether it may write
  EXPECT_EQ(bytes(), before);
}

}  // namespace
