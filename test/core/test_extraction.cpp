#include <atomic>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "base/temporary_folder.h"
#include "corrsel/database/extraction.h"
#include "corrsel/database/pair_matching.h"
#include "corrsel/features/extractor.h"
#include "database/exif.h"
#include "database/sqlite.h"
#include "test_support.h"

using namespace corrsel::core;
using namespace corrsel::core::testing;

namespace {

using Access = ColmapStore::Access;
namespace fs = std::filesystem;

/// Blurred noise, in which there are many features.
cv::Mat textured(const cv::Size& size, std::uint64_t seed) {
  Random random(seed);
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) image.at<std::uint8_t>(y, x) = std::uint8_t(random.index(256));
  }
  cv::GaussianBlur(image, image, {}, 2);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

/// A folder with the images b.png and z/a.png, and an empty database beside it.
class ExtractionTest : public ::testing::Test {
 protected:
  ExtractionTest() {
    fs::create_directories(images / "z");
    cv::imwrite((images / "b.png").string(), textured({200, 150}, 1));
    cv::imwrite((images / "z" / "a.png").string(), textured({200, 150}, 2));
    std::ofstream(images / "notes.txt") << "no image";
    ColmapStore::create(path);
  }

  ExtractionSummary extract(const ExtractionOptions& options = {}, int threads = 1,
                            const std::optional<ColmapCamera>& camera = {}) const {
    ColmapStore store(path, Access::kWrite);
    return extractFeatures({images, camera}, options, threads, store);
  }

  std::string cell(const std::string& sql) const {
    const SqliteDatabase database(path, SqliteDatabase::Mode::kRead, 1);
    SqliteQuery query = database.query(sql);
    return query.next() ? query.text(0) : "none";
  }

  std::vector<double> parameters(const std::string& where) const {
    const SqliteDatabase database(path, SqliteDatabase::Mode::kRead, 1);
    SqliteQuery query = database.query("SELECT params FROM cameras WHERE " + where);
    if (!query.next()) return {};
    std::vector<double> values(query.blob(0).size / sizeof(double));
    std::memcpy(values.data(), query.blob(0).data, query.blob(0).size);
    return values;
  }

  const TemporaryFolder temporary{"corrsel_extraction"};
  const fs::path folder = temporary.path(), images = folder / "images", path = folder / "house.db";
};

TEST_F(ExtractionTest, ImagesAreAddedInTheOrderOfTheirNames) {
  const ExtractionSummary summary = extract();
  EXPECT_EQ(summary.images, 2U);
  EXPECT_EQ(summary.added, 2U);
  EXPECT_TRUE(summary.refused.empty());
  const ColmapStore store(path);
  ASSERT_EQ(store.images().size(), 2U);
  EXPECT_EQ(store.images()[0].name, "b.png");
  EXPECT_EQ(store.images()[1].name, "z/a.png");
  EXPECT_EQ(store.images()[1].size, cv::Size(200, 150));
  EXPECT_EQ(summary.features, store.keypoints(1).positions.size() + store.keypoints(2).positions.size());
}

TEST_F(ExtractionTest, StoresTheFeaturesOfTheExtractor) {
  extract();
  const auto extractor =
      createExtractor("sift+sift", {{"sift", {{"contrast_threshold", "0.02"}, {"root", "true"}}}});
  const Features expected = extractor->extract(textured({200, 150}, 1));
  ASSERT_GT(expected.keypoints.size(), 100U);
  const ColmapStore store(path);
  const StoredKeypoints keypoints = store.keypoints(1);
  ASSERT_EQ(keypoints.positions.size(), expected.keypoints.size());
  ASSERT_EQ(keypoints.frames.size(), expected.frames.size());
  for (std::size_t i = 0; i < keypoints.positions.size(); ++i) {
    EXPECT_NEAR(cv::norm(keypoints.positions[i] - expected.keypoints[i].pt), 0, 1e-4);
    for (const std::size_t k : {0, 1, 3, 4}) EXPECT_EQ(keypoints.frames[i][k], expected.frames[i][k]);
  }
  // Half a pixel to COLMAP's origin.
  const SqliteDatabase database(path, SqliteDatabase::Mode::kRead, 1);
  SqliteQuery query = database.query("SELECT data FROM keypoints WHERE image_id = 1 AND cols = 6");
  ASSERT_TRUE(query.next());
  float x = 0;
  std::memcpy(&x, query.blob(0).data, sizeof x);
  EXPECT_NEAR(x, expected.keypoints[0].pt.x + 0.5, 1e-4);
  cv::Mat descriptors;
  store.descriptors(1).convertTo(descriptors, CV_32F);
  EXPECT_EQ(cv::norm(descriptors, expected.descriptors, cv::NORM_INF), 0);
  for (int i = 0; i < descriptors.rows; ++i) EXPECT_NEAR(cv::norm(descriptors.row(i)), 512, 8);
}

TEST_F(ExtractionTest, OptionsReachTheExtractor) {
  ExtractionOptions options;
  options.max_features = 30;
  options.root = false;
  extract(options);
  const auto extractor =
      createExtractor("sift+sift", {{"sift", {{"contrast_threshold", "0.02"}, {"max_features", "30"}}}});
  cv::Mat descriptors;
  ColmapStore(path).descriptors(1).convertTo(descriptors, CV_32F);
  EXPECT_EQ(cv::norm(descriptors, extractor->extract(textured({200, 150}, 1)).descriptors, cv::NORM_INF), 0);
  EXPECT_EQ(descriptors.rows, 30);
}

TEST_F(ExtractionTest, ThreadsDoNotChangeTheDatabase) {
  for (int i = 0; i < 9; ++i) {
    cv::imwrite((images / ("c" + std::to_string(i) + ".png")).string(),
                textured({90, 80}, 10U + unsigned(i)));
  }
  extract({}, 1);
  const fs::path other = folder / "other.db";
  ColmapStore::create(other);
  ColmapStore threaded(other, Access::kWrite);
  std::size_t last = 0;
  extractFeatures({images, {}}, {}, 2, threaded, [&](std::size_t done, std::size_t) { last = done; });
  EXPECT_EQ(last, 11U);
  const ColmapStore single(path);
  ASSERT_EQ(single.images().size(), threaded.images().size());
  for (const StoredImage& image : single.images()) {
    EXPECT_EQ(threaded.images()[image.id - 1].name, image.name);
    EXPECT_EQ(threaded.keypoints(image.id).positions, single.keypoints(image.id).positions);
    EXPECT_EQ(cv::norm(threaded.descriptors(image.id), single.descriptors(image.id), cv::NORM_INF), 0);
  }
}

TEST_F(ExtractionTest, ImagesOfTheDatabaseAreSkipped) {
  extract();
  cv::imwrite((images / "a.png").string(), textured({100, 80}, 3));
  const ExtractionSummary summary = extract();
  EXPECT_EQ(summary.skipped, 2U);
  EXPECT_EQ(summary.added, 1U);
  EXPECT_EQ(ColmapStore(path).images()[2].name, "a.png");
}

TEST_F(ExtractionTest, UnreadableImagesAreNamedAndOthersAreAdded) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", textured({100, 80}, 3), bytes);
  std::ofstream(images / "a.png", std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), 500);
  std::ofstream(images / "c.JPG") << "<html>not found</html>";
  std::ofstream(images / "d.jpg");
  const ExtractionSummary summary = extract({}, 2);
  EXPECT_EQ(summary.images, 5U);
  EXPECT_EQ(summary.added, 2U);
  ASSERT_EQ(summary.refused.size(), 3U);
  EXPECT_TRUE(mentions(summary.refused[0], {"a.png", "cut off"}));
  EXPECT_TRUE(mentions(summary.refused[1], {"c.JPG", "web page"}));
  EXPECT_TRUE(mentions(summary.refused[2], {"d.jpg", "empty"}));
}

TEST_F(ExtractionTest, AnImageWithoutFeaturesHasEmptyRows) {
  cv::imwrite((images / "a.png").string(), cv::Mat::zeros(40, 60, CV_8U));
  EXPECT_EQ(extract().added, 3U);
  const ColmapStore store(path);
  EXPECT_TRUE(store.keypoints(1).positions.empty());
  EXPECT_EQ(store.descriptors(1).rows, 0);
}

TEST_F(ExtractionTest, WithoutACameraTheFocalLengthIsGuessedAsInColmap) {
  extract();
  EXPECT_EQ(cell("SELECT count(*) FROM cameras WHERE model = 2 AND prior_focal_length = 0 AND width = 200"),
            "2");
  EXPECT_EQ(parameters("camera_id = 1"), (std::vector<double>{240, 100, 75, 0}));
}

/// A JPEG file with Exif data that give a focal length on film, mm.
std::vector<std::uint8_t> jpegWithFocalLength(const cv::Mat& image, std::uint8_t millimetres,
                                              bool big_endian) {
  std::vector<std::uint8_t> exif = {'E', 'x', 'i', 'f', 0, 0};
  const auto add = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
      exif.push_back(std::uint8_t(value >> 8 * (big_endian ? bytes - 1 - i : i)));
  };
  exif.insert(exif.end(), 2, big_endian ? 'M' : 'I');
  add(42, 2);
  add(8, 4);
  // A directory with the tags Orientation and Exif, and the directory that the latter names.
  add(2, 2);
  for (const std::uint32_t word : {0x0112U, 3U}) add(word, 2);
  for (const std::uint32_t value : {1U, 0U}) add(value, 4);
  for (const std::uint32_t word : {0x8769U, 4U}) add(word, 2);
  for (const std::uint32_t value : {1U, 38U, 0U}) add(value, 4);
  add(1, 2);
  for (const std::uint32_t word : {0xA405U, 3U}) add(word, 2);
  add(1, 4);
  add(millimetres, 2);
  add(0, 2);
  add(0, 4);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes);
  const auto length = std::uint8_t(exif.size() + 2);
  exif.insert(exif.begin(), {0xFF, 0xE1, 0, length});
  bytes.insert(bytes.begin() + 2, exif.begin(), exif.end());
  return bytes;
}

TEST_F(ExtractionTest, ExifDataOfFilesGiveTheFocalLength) {
  for (const bool big_endian : {true, false}) {
    const fs::path file = images / (big_endian ? "c.jpg" : "d.jpg");
    const std::vector<std::uint8_t> bytes = jpegWithFocalLength(textured({200, 150}, 3), 28, big_endian);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  }
  EXPECT_EQ(extract().added, 4U);
  const double expected = 28 / std::hypot(36, 24) * 250;
  EXPECT_EQ(cell("SELECT count(*) FROM cameras WHERE prior_focal_length = 1"), "1");
  const std::vector<double> found = parameters("prior_focal_length = 1");
  ASSERT_EQ(found.size(), 4U);
  EXPECT_NEAR(found[0], expected, 1e-3);
  EXPECT_EQ((std::vector<double>{found.begin() + 1, found.end()}), (std::vector<double>{100, 75, 0}));
}

TEST(Exif, DamagedDataGiveNoFocalLength) {
  const std::vector<std::uint8_t> bytes = jpegWithFocalLength(textured({60, 40}, 3), 28, true);
  EXPECT_EQ(focalLengthOnFilm(bytes), 28);
  for (std::size_t size = 0; size < 80; ++size) {
    std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
    EXPECT_EQ(focalLengthOnFilm(cut), size < 62 ? 0 : 28) << size;
  }
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> changed = bytes;
    changed[random.index(100)] = std::uint8_t(random.index(256));
    EXPECT_GE(focalLengthOnFilm(changed), 0);
  }
}

TEST_F(ExtractionTest, AGivenCameraIsStoredAsItIsAndTrusted) {
  cv::imwrite((images / "a.png").string(), textured({100, 80}, 3));
  const ColmapCamera camera{"SIMPLE_RADIAL", {200, 150}, {180, 99, 74, 0.1}};
  const ExtractionSummary summary = extract({}, 1, camera);
  EXPECT_EQ(cell("SELECT count(*) FROM cameras WHERE model = 2 AND prior_focal_length = 1"), "1");
  EXPECT_EQ(parameters("camera_id = 1"), camera.parameters);
  ASSERT_EQ(summary.refused.size(), 1U);
  EXPECT_TRUE(mentions(summary.refused[0], {"a.png", "100x80 px", "200x150 px"}));
  const ColmapStore store(path);
  EXPECT_TRUE(store.images()[0].calibrated);
  EXPECT_EQ(*store.images()[0].camera, cameraFromColmap(camera));
}

TEST_F(ExtractionTest, OneCameraForAllImages) {
  ExtractionOptions options;
  options.single_camera = true;
  extract(options);
  EXPECT_EQ(cell("SELECT count(*) FROM cameras"), "1");
  // Also in a later call, which refuses images of another size.
  cv::imwrite((images / "c.png").string(), textured({200, 150}, 4));
  cv::imwrite((images / "d.png").string(), textured({150, 200}, 5));
  const ExtractionSummary summary = extract(options);
  EXPECT_EQ(summary.added, 1U);
  ASSERT_EQ(summary.refused.size(), 1U);
  EXPECT_TRUE(mentions(summary.refused[0], {"d.png", "150x200 px", "200x150 px"}));
  EXPECT_EQ(cell("SELECT count(*) FROM cameras"), "1");
}

TEST_F(ExtractionTest, WrongInputIsRefused) {
  ExtractionOptions options;
  options.contrast_threshold = -1;
  EXPECT_TRUE(mentions(errorOf([&] { extract(options); }), {"contrast_threshold", "-1", "[0, 1]"}));
  const ColmapCamera camera{"PINHOLE", {200, 150}, {180, 99}};
  EXPECT_TRUE(mentions(errorOf([&] { extract({}, 1, camera); }), {"PINHOLE", "2"}));
  ColmapStore store(path, Access::kWrite);
  fs::create_directories(folder / "none");
  const auto errorFor = [&](const fs::path& place) {
    return errorOf<StoreError>([&] { extractFeatures({place, {}}, {}, 1, store); });
  };
  EXPECT_TRUE(mentions(errorFor(folder / "none"), {"none", "no images", ".png"}));
  EXPECT_TRUE(mentions(errorFor(folder / "missing"), {"missing", "cannot be listed"}));
}

TEST_F(ExtractionTest, AnInterruptedCallReturns) {
  ColmapStore store(path, Access::kWrite);
  const std::atomic<bool> interrupt{true};
  const ExtractionSummary summary = extractFeatures({images, {}}, {}, 1, store, {}, &interrupt);
  EXPECT_TRUE(summary.interrupted);
  EXPECT_EQ(summary.added, 0U);
}

TEST_F(ExtractionTest, ColmapMatchesTheFeatures) {
  if (std::system("command -v colmap >/dev/null") != 0) GTEST_SKIP() << "colmap is not installed";
  // The same texture, shifted by 7 and 3 px.
  const cv::Mat texture = textured({207, 153}, 7);
  cv::imwrite((images / "b.png").string(), texture(cv::Rect(0, 0, 200, 150)));
  cv::imwrite((images / "z" / "a.png").string(), texture(cv::Rect(7, 3, 200, 150)));
  extract();
  const std::string command = "QT_QPA_PLATFORM=offscreen colmap exhaustive_matcher --database_path " +
                              path.string() + " --SiftMatching.use_gpu 0 >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const ColmapStore store(path);
  const std::vector<KeypointPair> colmap = store.matches({1, 2}).rows;
  std::vector<KeypointPair> own = matchDescriptors(store.descriptors(1), store.descriptors(2));
  EXPECT_GT(own.size(), 50U);
  std::vector<KeypointPair> common;
  std::set<KeypointPair> of_colmap(colmap.begin(), colmap.end());
  for (const KeypointPair& match : own) {
    if (of_colmap.count(match) != 0) common.push_back(match);
  }
  // COLMAP searches approximately.
  EXPECT_GT(double(common.size()), 0.9 * double(own.size()));
  const StoredKeypoints first = store.keypoints(1), second = store.keypoints(2);
  std::size_t right = 0;
  for (const KeypointPair& match : own) {
    const cv::Point2f shift = first.positions[match[0]] - second.positions[match[1]];
    right += cv::norm(shift - cv::Point2f(7, 3)) < 0.5;
  }
  EXPECT_GT(double(right), 0.9 * double(own.size()));
}

}  // namespace
