#include "corrsel/database/colmap_store.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "database/colmap_conventions.h"
#include "database/colmap_rows.h"
#include "database/colmap_schema.h"
#include "database/sqlite.h"
#include "geometry/rigid_motion.h"

namespace corrsel::core {
namespace {

constexpr std::int64_t kLargestSide = 1 << 20;  // px
constexpr float kOutside = 1;                   // px, how far beyond its image a keypoint may lie
constexpr std::size_t kDescriptorBytes = 128;

std::string partOf(const std::filesystem::path& path) { return path.string() + ".part"; }

/// Rows that name no pair of two different images.
struct SkippedRows {
  std::size_t wrong = 0, repeated = 0;
  std::string first_wrong;
};

/// The table and the row that a message is about.
std::string placeOf(const std::string& table, const std::string& key, std::int64_t number) {
  return "table " + table + ", " + key + " " + std::to_string(number);
}

}  // namespace

struct ColmapStore::Impl {
  Impl(const std::filesystem::path& path, Access access, double busy_seconds)
      : database(path, access == Access::kWrite ? SqliteDatabase::Mode::kWrite : SqliteDatabase::Mode::kRead,
                 busy_seconds),
        writable(access == Access::kWrite) {}

  [[noreturn]] void refuse(const std::string& text) const;
  void probeWriting() const;
  void requireWritable() const;
  void readImages();
  void readCamera(const SqliteQuery& query, StoredImage& image);
  const StoredImage& image(std::uint32_t id) const;
  std::string placeOfImage(const std::string& table, const StoredImage& image) const;
  void checkPositions(const StoredImage& image, const StoredKeypoints& keypoints) const;
  std::int64_t keypointCount(std::uint32_t image) const;
  void checkMatches(const ImagePairKey& pair, const StoredMatches& matches) const;
  std::vector<ImagePairKey> readPairs(SqliteQuery& query, SkippedRows& skipped) const;
  std::vector<ImagePairKey> matchedPairs(SkippedRows& skipped) const;
  void warnOfMatches(bool empty, const SkippedRows& skipped) const;
  TwoViewGeometry geometryOf(const SqliteQuery& query, const std::string& place) const;
  std::int64_t configurationNumber(const std::string& configuration) const;
  void writeGeometry(const VerifiedPair& pair) const;
  void writeVerification(const VerifiedPair& pair, std::int64_t configuration) const;
  std::int64_t cameraNumber(const ColmapCamera& camera, bool trusted) const;
  std::int64_t firstCamera(StoredImage& image) const;
  std::string storedPairs() const;

  SqliteDatabase database;
  bool writable;
  bool has_poses = false;         // whether two_view_geometries has the columns qvec and tvec
  bool has_verification = false;  // whether the tables of corrsel are there
  std::vector<StoredImage> images;
  std::unordered_map<std::uint32_t, std::size_t> rows;            // of `images`, by the number of the image
  std::unordered_map<std::uint32_t, std::string> without_camera;  // why an image has no size
  mutable std::unordered_map<std::uint32_t, std::int64_t> keypoint_counts;
  mutable std::vector<std::string> warnings;
  mutable std::set<std::uint32_t> warned;  // images whose positions are not finite
  mutable bool warned_of_matches = false;
};

void ColmapStore::Impl::refuse(const std::string& text) const {
  throw StoreError(StoreError::Kind::kContent, database.path().string() + ": " + text);
}

/// Finds out before hours of work whether there is a lock, or no permission to write. Nothing is changed.
void ColmapStore::Impl::probeWriting() const {
  SqliteTransaction transaction(database);
  std::int64_t version = 0;
  {
    SqliteQuery query = database.query("PRAGMA user_version");
    if (query.next()) version = query.integer(0);
  }
  database.execute("PRAGMA user_version = " + std::to_string(version));
}

void ColmapStore::Impl::requireWritable() const {
  if (!writable) throw std::logic_error(database.path().string() + " was opened for reading only");
}

void ColmapStore::Impl::readImages() {
  SqliteQuery query = database.query(
      "SELECT images.image_id, images.name, images.camera_id, cameras.camera_id, cameras.width, "
      "cameras.height, cameras.model, cameras.params, cameras.prior_focal_length "
      "FROM images LEFT JOIN cameras ON images.camera_id = cameras.camera_id ORDER BY images.image_id");
  while (query.next()) {
    const std::int64_t id = query.integer(0);
    if (!query.isInteger(0) || id < 0 || id >= kColmapImageLimit) {
      refuse("table images has the image_id '" + query.text(0) + "', expected 0 to " +
             std::to_string(kColmapImageLimit - 1));
    }
    if (!query.isText(1) || query.text(1).empty()) {
      refuse(placeOf("images", "image_id", id) + " has the name '" + query.text(1) + "', expected a text");
    }
    StoredImage image;
    image.id = static_cast<std::uint32_t>(id);
    image.name = query.text(1);
    readCamera(query, image);
    if (!rows.emplace(image.id, images.size()).second) {
      refuse(placeOf("images", "image_id", id) + " stands there twice; remove one of the rows");
    }
    images.push_back(std::move(image));
  }
}

/// Reads the columns from camera_id on of readImages().
void ColmapStore::Impl::readCamera(const SqliteQuery& query, StoredImage& image) {
  const std::string place = placeOfImage("images", image);
  if (query.isNull(3)) {
    without_camera[image.id] = place + " has the camera_id " + query.text(2) +
                               ", which the table cameras lacks; extract its features again with COLMAP";
    return;
  }
  const std::int64_t width = query.integer(4), height = query.integer(5);
  if (width <= 0 || height <= 0 || width >= kLargestSide || height >= kLargestSide) {
    without_camera[image.id] = place + ": its camera " + query.text(2) + " has the size " + query.text(4) +
                               "x" + query.text(5) + ", expected px; correct it in the table cameras";
    return;
  }
  image.size = {static_cast<int>(width), static_cast<int>(height)};
  const SqliteBlob bytes = query.blob(7);
  std::vector<double> parameters(bytes.size / sizeof(double));
  std::memcpy(parameters.data(), bytes.data, parameters.size() * sizeof(double));
  try {
    if (bytes.size % sizeof(double)) {
      throw std::invalid_argument("params has " + std::to_string(bytes.size) + " bytes, expected 8 a number");
    }
    image.camera = cameraFromColmap({colmapModelName(query.integer(6)), image.size, std::move(parameters)});
    image.calibrated = query.integer(8) == 1;
  } catch (const std::invalid_argument& error) {
    const std::string text = placeOf("cameras", "camera_id", query.integer(3)) + ": " + error.what() +
                             "; its images are verified without calibration";
    if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) warnings.push_back(text);
  }
}

const StoredImage& ColmapStore::Impl::image(std::uint32_t id) const {
  const auto found = rows.find(id);
  if (found == rows.end()) {
    refuse("there is no image_id " + std::to_string(id) + " in the table images; remove what belongs to it");
  }
  return images[found->second];
}

std::string ColmapStore::Impl::placeOfImage(const std::string& table, const StoredImage& image) const {
  return placeOf(table, "image_id", image.id) + " (" + image.name + ")";
}

void ColmapStore::Impl::checkPositions(const StoredImage& image, const StoredKeypoints& keypoints) const {
  const float least = -kColmapPixelCentre - kOutside;
  const float right = static_cast<float>(image.size.width) + least + 2 * kOutside;
  const float bottom = static_cast<float>(image.size.height) + least + 2 * kOutside;
  std::size_t not_finite = 0;
  for (std::size_t i = 0; i < keypoints.positions.size(); ++i) {
    const cv::Point2f& p = keypoints.positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) {
      ++not_finite;
    } else if (p.x < least || p.y < least || p.x > right || p.y > bottom) {
      refuse(placeOfImage("keypoints", image) + ": keypoint " + std::to_string(i) + " is at (" +
             formatNumber(p.x + kColmapPixelCentre) + ", " + formatNumber(p.y + kColmapPixelCentre) +
             ") px, but the camera of the image has " + sizeText(image.size) +
             " px; features and camera are of images of different sizes, one of them reduced: extract them "
             "again");
    }
  }
  if (not_finite && warned.insert(image.id).second) {
    warnings.push_back(placeOfImage("keypoints", image) + ": " + std::to_string(not_finite) + " of " +
                       std::to_string(keypoints.positions.size()) +
                       " positions are not finite; their matches are rejected");
  }
}

/// The number of keypoints of an image; -1 where the table has no row of it.
std::int64_t ColmapStore::Impl::keypointCount(std::uint32_t image) const {
  const auto [entry, fresh] = keypoint_counts.emplace(image, -1);
  if (fresh) {
    SqliteQuery query = database.query("SELECT rows FROM keypoints WHERE image_id = ?1");
    if (query.bind(1, std::int64_t{image}).next()) entry->second = query.integer(0);
  }
  return entry->second;
}

void ColmapStore::Impl::checkMatches(const ImagePairKey& pair, const StoredMatches& matches) const {
  const std::int64_t number = colmapPairNumber(pair);
  const std::array<std::uint32_t, 2> ids = {pair.first, pair.second};
  for (std::size_t side = 0; side < ids.size(); ++side) {
    if (!rows.count(ids[side])) {
      refuse(placeOf("matches", "pair_id", number) + ": there is no image_id " + std::to_string(ids[side]) +
             " in the table images; remove the row");
    }
    const std::int64_t count = keypointCount(ids[side]);
    for (std::size_t i = 0; count >= 0 && i < matches.rows.size(); ++i) {
      if (std::int64_t{matches.rows[i][side]} < count) continue;
      refuse(placeOf("matches", "pair_id", number) + ", match " + std::to_string(i) + " names the keypoint " +
             std::to_string(matches.rows[i][side]) + " of image_id " + std::to_string(ids[side]) + " (" +
             image(ids[side]).name + "), which has " + std::to_string(count) + "; match the images again");
    }
  }
}

/// The pairs of a query whose first column is pair_id, in ascending order. Rows that are no pair are left
/// out.
std::vector<ImagePairKey> ColmapStore::Impl::readPairs(SqliteQuery& query, SkippedRows& skipped) const {
  std::vector<ImagePairKey> pairs;
  while (query.next()) {
    const std::int64_t number = query.integer(0);
    const ImagePairKey pair = colmapPairImages(number);
    if (!query.isInteger(0) || number < 0 || number / kColmapImageLimit >= kColmapImageLimit ||
        pair.first >= pair.second) {
      if (skipped.wrong++ == 0) skipped.first_wrong = query.text(0);
    } else if (!pairs.empty() && pairs.back() == pair) {
      ++skipped.repeated;
    } else {
      pairs.push_back(pair);
    }
  }
  return pairs;
}

std::vector<ImagePairKey> ColmapStore::Impl::matchedPairs(SkippedRows& skipped) const {
  SqliteQuery query = database.query("SELECT pair_id FROM matches ORDER BY pair_id");
  return readPairs(query, skipped);
}

/// Says once what is odd in the table matches.
void ColmapStore::Impl::warnOfMatches(bool empty, const SkippedRows& skipped) const {
  if (std::exchange(warned_of_matches, true)) return;
  if (empty) warnings.push_back("the table matches is empty; run one of COLMAP's matchers first");
  if (skipped.wrong) {
    warnings.push_back(
        "table matches: " + std::to_string(skipped.wrong) + " rows are skipped, the first has the pair_id " +
        skipped.first_wrong +
        ": they are of an image with itself, or of two images whose larger number stands first");
  }
  if (skipped.repeated) {
    warnings.push_back("table matches: " + std::to_string(skipped.repeated) +
                       " rows are skipped because their pair_id stands there before");
  }
}

TwoViewGeometry ColmapStore::Impl::geometryOf(const SqliteQuery& query, const std::string& place) const {
  TwoViewGeometry geometry;
  const std::int64_t config = query.integer(3);
  if (config < 0 || config > static_cast<std::int64_t>(TwoViewConfig::kMultiple)) {
    refuse(place + ": config is " + query.text(3) + ", expected 0 to 8; verify the pair again");
  }
  geometry.config = static_cast<TwoViewConfig>(config);
  geometry.inliers = readColmapPairs(query, database, place);
  std::optional<ColmapMatrix> f, e, h;
  std::optional<std::array<double, 4>> q;
  std::optional<std::array<double, 3>> t;
  if (!readNumbers(query.blob(4), f) || !readNumbers(query.blob(5), e) || !readNumbers(query.blob(6), h) ||
      (has_poses && (!readNumbers(query.blob(7), q) || !readNumbers(query.blob(8), t)))) {
    refuse(place +
           ": F, E, H, qvec or tvec is neither empty nor of 72, 72, 72, 32 and 24 bytes; the "
           "database is damaged");
  }
  if (f) geometry.fundamental = fundamentalFromColmap(*f);
  if (e) geometry.essential = essentialFromColmap(*e);
  if (h) geometry.homography = homographyFromColmap(*h);
  if (q && t) {
    try {
      const RigidMotion motion = motionOf((*q)[0], (*q)[1], (*q)[2], (*q)[3], cv::Vec3d(t->data()));
      geometry.pose = Pose{motion.rotation, motion.translation};
    } catch (const std::invalid_argument& error) {
      refuse(place + ": qvec and tvec are no pose (" + error.what() + "); verify the pair again");
    }
  }
  return geometry;
}

std::int64_t ColmapStore::Impl::configurationNumber(const std::string& configuration) const {
  database.query("INSERT OR IGNORE INTO corrsel_configurations(text) VALUES (?1)")
      .bind(1, configuration)
      .run();
  SqliteQuery query = database.query("SELECT id FROM corrsel_configurations WHERE text = ?1");
  query.bind(1, configuration).next();
  return query.integer(0);
}

void ColmapStore::Impl::writeGeometry(const VerifiedPair& pair) const {
  const TwoViewGeometry& geometry = pair.geometry;
  // The columns are named, because newer versions of COLMAP have more of them.
  SqliteQuery query = database.query(
      has_poses
          ? "INSERT OR REPLACE INTO two_view_geometries(pair_id, rows, cols, data, config, F, E, H, qvec, "
            "tvec) VALUES (?1, ?2, 2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)"
          : "INSERT OR REPLACE INTO two_view_geometries(pair_id, rows, cols, data, config, F, E, H) "
            "VALUES (?1, ?2, 2, ?3, ?4, ?5, ?6, ?7)");
  query.bind(1, colmapPairNumber(pair.pair));
  query.bind(2, static_cast<std::int64_t>(geometry.inliers.size()));
  query.bind(3, bytesOf(geometry.inliers));
  query.bind(4, static_cast<std::int64_t>(geometry.config));
  ColmapMatrix f, e, h;
  std::array<double, 4> q;
  if (geometry.fundamental) query.bind(5, bytesOf(f = colmapFundamental(*geometry.fundamental)));
  if (geometry.essential) query.bind(6, bytesOf(e = colmapEssential(*geometry.essential)));
  if (geometry.homography) query.bind(7, bytesOf(h = colmapHomography(*geometry.homography)));
  if (geometry.pose && has_poses) {
    query.bind(8, bytesOf(q = colmapQuaternion(geometry.pose->rotation)));
    const auto* t = reinterpret_cast<const unsigned char*>(geometry.pose->translation.val);
    query.bind(9, SqliteBlob{t, sizeof(geometry.pose->translation.val)});
  }
  query.run();
}

void ColmapStore::Impl::writeVerification(const VerifiedPair& pair, std::int64_t configuration) const {
  const TwoViewConfig config = pair.geometry.config;
  SqliteQuery query = database.query(
      "INSERT OR REPLACE INTO corrsel_verify(pair_id, configuration, status, confidence, putative, accepted, "
      "inliers, config, scene, ambiguity) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)");
  query.bind(1, colmapPairNumber(pair.pair)).bind(2, configuration).bind(3, toString(pair.status));
  query.bind(4, pair.confidence).bind(5, static_cast<std::int64_t>(pair.putative));
  query.bind(6, std::int64_t{config != TwoViewConfig::kUndefined});
  query.bind(7, static_cast<std::int64_t>(pair.geometry.inliers.size()));
  query.bind(8, static_cast<std::int64_t>(config)).bind(9, toString(pair.scene)).bind(10, pair.ambiguity);
  query.run();
}

/// Adds a camera. Images with the same trusted calibration share one, as those of one camera do.
std::int64_t ColmapStore::Impl::cameraNumber(const ColmapCamera& camera, bool trusted) const {
  const std::int64_t model = colmapModelNumber(camera.model);
  const auto bind = [&](SqliteQuery& query) {
    query.bind(1, model).bind(2, std::int64_t{camera.size.width});
    query.bind(3, std::int64_t{camera.size.height}).bind(4, bytesOf(camera.parameters));
    query.bind(5, std::int64_t{trusted});
  };
  if (trusted) {
    SqliteQuery same = database.query(
        "SELECT camera_id FROM cameras WHERE model = ?1 AND width = ?2 AND height = ?3 AND params = ?4 AND "
        "prior_focal_length = ?5");
    bind(same);
    if (same.next()) return same.integer(0);
  }
  SqliteQuery query = database.query(
      "INSERT INTO cameras(model, width, height, params, prior_focal_length) VALUES (?1, ?2, ?3, ?4, ?5)");
  bind(query);
  query.run();
  return database.lastRow();
}

/// Gives an image the camera of the first image. @return its number
std::int64_t ColmapStore::Impl::firstCamera(StoredImage& image) const {
  image.camera = images.front().camera;
  image.calibrated = images.front().calibrated;
  SqliteQuery query = database.query("SELECT camera_id FROM images WHERE image_id = ?1");
  query.bind(1, std::int64_t{images.front().id}).next();
  return query.integer(0);
}

/// The end of a message about a write that failed.
std::string ColmapStore::Impl::storedPairs() const {
  if (!has_verification) return "; no pair is stored";
  try {
    SqliteQuery query = database.query("SELECT count(*) FROM corrsel_verify");
    query.next();
    return "; " + query.text(0) + " verified pairs are stored";
  } catch (const StoreError&) {
    return "";  // The disk does not answer; the first message says why.
  }
}

ColmapStore::ColmapStore(const std::filesystem::path& path, Access access, double busy_seconds) {
  if (!std::filesystem::exists(path)) {
    throw StoreError(StoreError::Kind::kStorage,
                     path.string() + " does not exist; give the file that COLMAP calls the database");
  }
  impl_ = std::make_unique<Impl>(path, access, busy_seconds);
  requireColmapTables(impl_->database);
  const std::set<std::string> columns = columnsOf(impl_->database, "two_view_geometries");
  impl_->has_poses = columns.count("qvec") && columns.count("tvec");
  impl_->has_verification = hasTable(impl_->database, "corrsel_verify");
  if (access == Access::kWrite) {
    requireWritableGeometries(impl_->database);
    impl_->probeWriting();
  }
  impl_->readImages();
}

ColmapStore::~ColmapStore() = default;

void ColmapStore::copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::filesystem::exists(to)) {
    throw StoreError(StoreError::Kind::kStorage,
                     to.string() + " exists already; remove it or choose another name");
  }
  const std::filesystem::path part = partOf(to);
  const ColmapStore source(from);
  try {
    // Logs that outlived their database would be taken for those of the new one.
    for (const std::filesystem::path& path : {part, to}) {
      for (const char* ending : {"", "-wal", "-shm", "-journal"})
        std::filesystem::remove(path.string() + ending);
    }
    source.impl_->database.copyTo(
        SqliteDatabase(part, SqliteDatabase::Mode::kCreate, source.impl_->database.busySeconds()));
    std::filesystem::rename(part, to);
  } catch (const std::filesystem::filesystem_error& error) {
    throw StoreError(StoreError::Kind::kStorage, std::string("cannot write ") + to.string() + ": " +
                                                     error.code().message() + "; choose another folder");
  }
}

void ColmapStore::continueCopy(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!std::filesystem::exists(to)) return copy(from, to);
  const ColmapStore source(from), left(to);
  const auto same = [](const StoredImage& a, const StoredImage& b) {
    return a.id == b.id && a.name == b.name;
  };
  if (!std::equal(source.images().begin(), source.images().end(), left.images().begin(), left.images().end(),
                  same)) {
    left.impl_->refuse("it is left from a run with another database than " + from.string() + "; remove it");
  }
}

void ColmapStore::create(const std::filesystem::path& path) {
  if (std::filesystem::exists(path)) {
    throw StoreError(StoreError::Kind::kStorage,
                     path.string() + " exists already; remove it or choose another name");
  }
  createColmapTables(SqliteDatabase(path, SqliteDatabase::Mode::kCreate, 0));
}

const std::vector<StoredImage>& ColmapStore::images() const { return impl_->images; }

std::vector<ImagePairKey> ColmapStore::pairs() const {
  SkippedRows skipped;
  std::vector<ImagePairKey> pairs = impl_->matchedPairs(skipped);
  impl_->warnOfMatches(pairs.empty(), skipped);
  return pairs;
}

std::vector<ImagePairKey> ColmapStore::matchedPairs() const {
  SkippedRows skipped;
  return impl_->matchedPairs(skipped);
}

StoredKeypoints ColmapStore::keypoints(std::uint32_t id) const {
  const StoredImage& image = impl_->image(id);
  const auto without_camera = impl_->without_camera.find(id);
  if (without_camera != impl_->without_camera.end()) impl_->refuse(without_camera->second);
  const std::string place = impl_->placeOfImage("keypoints", image);
  SqliteQuery query = impl_->database.query("SELECT rows, cols, data FROM keypoints WHERE image_id = ?1");
  if (!query.bind(1, std::int64_t{id}).next()) {
    impl_->refuse(place + " is missing, but the image has matches; extract its features again with COLMAP");
  }
  const ColmapTable table = readColmapTable(query, sizeof(float), impl_->database, place);
  if (table.rows && table.columns != 2 && table.columns != 4 && table.columns != 6) {
    impl_->refuse(place + " has " + std::to_string(table.columns) + " columns, expected 2, 4 or 6");
  }
  StoredKeypoints keypoints = keypointsOf(table);
  impl_->checkPositions(image, keypoints);
  return keypoints;
}

StoredMatches ColmapStore::matches(const ImagePairKey& pair) const {
  const std::int64_t number = colmapPairNumber(pair);
  const std::string place = placeOf("matches", "pair_id", number);
  SqliteQuery query = impl_->database.query("SELECT rows, cols, data FROM matches WHERE pair_id = ?1");
  if (!query.bind(1, number).next()) {
    const auto name = [this](std::uint32_t id) {
      const auto found = impl_->rows.find(id);
      return found == impl_->rows.end() ? "image_id " + std::to_string(id)
                                        : "'" + impl_->images[found->second].name + "'";
    };
    impl_->refuse(place + " is missing; match " + name(pair.first) + " and " + name(pair.second) + " first");
  }
  StoredMatches matches;
  matches.rows = readColmapPairs(query, impl_->database, place);
  impl_->checkMatches(pair, matches);
  return matches;
}

std::vector<ImagePairKey> ColmapStore::verifiedPairs(const std::string& configuration) const {
  if (!impl_->has_verification) return {};
  SqliteQuery query = impl_->database.query(
      "SELECT v.pair_id FROM corrsel_verify v "
      "JOIN corrsel_configurations c ON c.id = v.configuration "
      "JOIN two_view_geometries g ON g.pair_id = v.pair_id "
      "WHERE c.text = ?1 AND g.rows = v.inliers AND g.config = v.config ORDER BY v.pair_id");
  query.bind(1, configuration);
  SkippedRows skipped;
  return impl_->readPairs(query, skipped);
}

std::vector<ImagePairKey> ColmapStore::pairsOfOthers() const {
  SqliteQuery query = impl_->database.query(
      impl_->has_verification
          ? "SELECT g.pair_id FROM two_view_geometries g LEFT JOIN corrsel_verify v ON g.pair_id = v.pair_id "
            "WHERE v.pair_id IS NULL OR g.rows <> v.inliers OR g.config <> v.config ORDER BY g.pair_id"
          : "SELECT pair_id FROM two_view_geometries ORDER BY pair_id");
  SkippedRows skipped;
  return impl_->readPairs(query, skipped);
}

VerifiedPair ColmapStore::verified(const ImagePairKey& pair) const {
  const std::int64_t number = colmapPairNumber(pair);
  VerifiedPair result;
  result.pair = pair;
  {
    const std::string place = placeOf("two_view_geometries", "pair_id", number);
    SqliteQuery query = impl_->database.query(
        impl_->has_poses
            ? "SELECT rows, cols, data, config, F, E, H, qvec, tvec FROM two_view_geometries "
              "WHERE pair_id = ?1"
            : "SELECT rows, cols, data, config, F, E, H FROM two_view_geometries WHERE pair_id = ?1");
    if (!query.bind(1, number).next()) impl_->refuse(place + " is missing; verify the pair");
    result.geometry = impl_->geometryOf(query, place);
  }
  result.confidence = result.ambiguity = std::numeric_limits<double>::quiet_NaN();
  if (!impl_->has_verification) return result;
  SqliteQuery query = impl_->database.query(
      "SELECT status, scene, putative, confidence, ambiguity FROM corrsel_verify WHERE pair_id = ?1");
  if (!query.bind(1, number).next()) return result;
  result.status = statusFromString(query.text(0));
  result.scene = sceneFromString(query.text(1));
  result.putative = static_cast<std::size_t>(query.integer(2));
  result.confidence = query.real(3);
  result.ambiguity = query.real(4);
  return result;
}

void ColmapStore::write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) {
  impl_->requireWritable();
  try {
    SqliteTransaction transaction(impl_->database);
    createVerificationTables(impl_->database);
    const std::int64_t number = impl_->configurationNumber(configuration);
    for (const VerifiedPair& pair : pairs) {
      if (pair.faulty) continue;
      impl_->writeGeometry(pair);
      impl_->writeVerification(pair, number);
    }
    transaction.commit();
  } catch (const StoreError& error) {
    throw StoreError(error.kind(), error.what() + impl_->storedPairs());
  }
  impl_->has_verification = true;
}

cv::Mat ColmapStore::descriptors(std::uint32_t id) const {
  const std::string place = impl_->placeOfImage("descriptors", impl_->image(id));
  if (!hasTable(impl_->database, "descriptors")) impl_->refuse("there is no table descriptors");
  SqliteQuery query = impl_->database.query("SELECT rows, cols, data FROM descriptors WHERE image_id = ?1");
  if (!query.bind(1, std::int64_t{id}).next()) {
    impl_->refuse(place + " is missing; extract the features of the image again with COLMAP");
  }
  const ColmapTable table = readColmapTable(query, 1, impl_->database, place);
  if (table.rows && table.columns != kDescriptorBytes) {
    impl_->refuse(place + " has " + std::to_string(table.columns) + " columns, expected 128");
  }
  cv::Mat descriptors(static_cast<int>(table.rows), static_cast<int>(kDescriptorBytes), CV_8U);
  if (table.rows) std::memcpy(descriptors.data, table.data, table.rows * kDescriptorBytes);
  return descriptors;
}

std::uint32_t ColmapStore::addImage(const StoredImage& image, const StoredKeypoints& keypoints,
                                    const cv::Mat& descriptors, const std::optional<ColmapCamera>& given,
                                    bool one_camera) {
  impl_->requireWritable();
  SqliteTransaction transaction(impl_->database);
  StoredImage added = image;
  const auto lookup = [&] {
    SqliteQuery query = impl_->database.query("SELECT image_id FROM images WHERE name = ?1");
    return query.bind(1, image.name).next();
  };
  if (lookup()) impl_->refuse("table images: there is an image '" + image.name + "' already");
  const std::int64_t camera =
      one_camera && !impl_->images.empty()
          ? impl_->firstCamera(added)
          : impl_->cameraNumber(given ? *given : colmapCameraOf(image), image.camera && image.calibrated);
  impl_->database.query("INSERT INTO images(name, camera_id) VALUES (?1, ?2)")
      .bind(1, image.name)
      .bind(2, camera)
      .run();
  const std::int64_t id = impl_->database.lastRow();
  const std::vector<float> values = keypointValues(keypoints);
  impl_->database.query("INSERT INTO keypoints(image_id, rows, cols, data) VALUES (?1, ?2, ?3, ?4)")
      .bind(1, id)
      .bind(2, static_cast<std::int64_t>(keypoints.positions.size()))
      .bind(3, std::int64_t{keypoints.frames.empty() ? 2 : 6})
      .bind(4, bytesOf(values))
      .run();
  if (descriptors.cols > 0) {
    const cv::Mat bytes = descriptors.isContinuous() ? descriptors : descriptors.clone();
    impl_->database.query("INSERT INTO descriptors(image_id, rows, cols, data) VALUES (?1, ?2, ?3, ?4)")
        .bind(1, id)
        .bind(2, std::int64_t{bytes.rows})
        .bind(3, std::int64_t{bytes.cols})
        .bind(4, SqliteBlob{bytes.data, bytes.total()})
        .run();
  }
  transaction.commit();
  added.id = static_cast<std::uint32_t>(id);
  impl_->rows.emplace(added.id, impl_->images.size());
  impl_->keypoint_counts[added.id] = static_cast<std::int64_t>(keypoints.positions.size());
  impl_->images.push_back(std::move(added));
  return static_cast<std::uint32_t>(id);
}

void ColmapStore::writeMatches(const std::vector<std::pair<ImagePairKey, StoredMatches>>& matches) {
  impl_->requireWritable();
  SqliteTransaction transaction(impl_->database);
  for (const auto& [pair, putative] : matches) {
    const std::int64_t number = colmapPairNumber(pair);
    impl_->checkMatches(pair, putative);
    impl_->database.query("INSERT OR REPLACE INTO matches(pair_id, rows, cols, data) VALUES (?1, ?2, 2, ?3)")
        .bind(1, number)
        .bind(2, static_cast<std::int64_t>(putative.rows.size()))
        .bind(3, bytesOf(putative.rows))
        .run();
    // What was verified belongs to the matches that are replaced.
    impl_->database.query("DELETE FROM two_view_geometries WHERE pair_id = ?1").bind(1, number).run();
    if (!impl_->has_verification) continue;
    impl_->database.query("DELETE FROM corrsel_verify WHERE pair_id = ?1").bind(1, number).run();
  }
  transaction.commit();
}

const std::vector<std::string>& ColmapStore::warnings() const { return impl_->warnings; }

}  // namespace corrsel::core
