#include "database/pair_journal.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "database/colmap_rows.h"
#include "database/colmap_schema.h"
#include "database/sqlite.h"

namespace corrsel::core {
namespace {

constexpr const char* kTables = R"(
CREATE TABLE input (text TEXT NOT NULL);
CREATE TABLE configurations (id INTEGER PRIMARY KEY NOT NULL, text TEXT NOT NULL UNIQUE);
CREATE TABLE results (first INTEGER NOT NULL, second INTEGER NOT NULL,
  configuration INTEGER NOT NULL REFERENCES configurations(id), status TEXT NOT NULL, scene TEXT NOT NULL,
  putative INTEGER NOT NULL, confidence REAL, ambiguity REAL, config INTEGER NOT NULL, inliers BLOB NOT NULL,
  fundamental BLOB, essential BLOB, homography BLOB, rotation BLOB, translation BLOB,
  PRIMARY KEY (first, second)) WITHOUT ROWID;
)";

using Numbers = std::array<double, 9>;

Numbers numbersOf(const cv::Matx33d& matrix) {
  Numbers numbers;
  std::copy(std::begin(matrix.val), std::end(matrix.val), numbers.begin());
  return numbers;
}

/// @return absent where the column is NULL
std::optional<cv::Matx33d> matrixOf(const SqliteQuery& query, int column) {
  std::optional<Numbers> numbers;
  readNumbers(query.blob(column), numbers);
  return numbers ? std::optional<cv::Matx33d>(cv::Matx33d(numbers->data())) : std::nullopt;
}

TwoViewGeometry geometryOf(const SqliteQuery& query) {
  TwoViewGeometry geometry;
  geometry.config = static_cast<TwoViewConfig>(query.integer(5));
  const SqliteBlob inliers = query.blob(6);
  geometry.inliers.resize(inliers.size / sizeof(KeypointPair));
  if (inliers.size > 0) std::memcpy(geometry.inliers.data(), inliers.data, inliers.size);
  geometry.fundamental = matrixOf(query, 7);
  geometry.essential = matrixOf(query, 8);
  geometry.homography = matrixOf(query, 9);
  std::optional<std::array<double, 3>> translation;
  readNumbers(query.blob(11), translation);
  if (const std::optional<cv::Matx33d> rotation = matrixOf(query, 10); rotation && translation) {
    geometry.pose = Pose{*rotation, cv::Vec3d(translation->data())};
  }
  return geometry;
}

}  // namespace

struct PairJournal::Impl {
  explicit Impl(const std::filesystem::path& path) : database(path, SqliteDatabase::Mode::kCreate) {}

  void begin(const std::string& input) const;
  void write(const VerifiedPair& pair, std::int64_t configuration) const;
  std::int64_t configurationNumber(const std::string& configuration) const;

  SqliteDatabase database;
};

void PairJournal::Impl::begin(const std::string& input) const {
  SqliteTransaction transaction(database);
  if (!hasTable(database, "input")) {
    database.execute(kTables);
    database.query("INSERT INTO input(text) VALUES (?1)").bind(1, input).run();
  }
  {
    SqliteQuery query = database.query("SELECT text FROM input");
    if (!query.next() || query.text(0) != input) {
      throw StoreError(
          StoreError::Kind::kContent,
          database.path().string() +
              " has results of other files, or of files that have changed since; delete it, or give "
              "another name for the output");
    }
  }
  transaction.commit();
}

std::int64_t PairJournal::Impl::configurationNumber(const std::string& configuration) const {
  database.query("INSERT OR IGNORE INTO configurations(text) VALUES (?1)").bind(1, configuration).run();
  SqliteQuery query = database.query("SELECT id FROM configurations WHERE text = ?1");
  query.bind(1, configuration).next();
  return query.integer(0);
}

void PairJournal::Impl::write(const VerifiedPair& pair, std::int64_t configuration) const {
  const TwoViewGeometry& geometry = pair.geometry;
  SqliteQuery query = database.query(
      "INSERT OR REPLACE INTO results VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, "
      "?15)");
  query.bind(1, std::int64_t{pair.pair.first}).bind(2, std::int64_t{pair.pair.second});
  query.bind(3, configuration).bind(4, toString(pair.status)).bind(5, toString(pair.scene));
  query.bind(6, static_cast<std::int64_t>(pair.putative));
  query.bind(7, pair.confidence).bind(8, pair.ambiguity);
  query.bind(9, static_cast<std::int64_t>(geometry.config)).bind(10, bytesOf(geometry.inliers));
  // They live until the statement has run.
  std::array<Numbers, 4> matrices;
  std::array<double, 3> translation;
  if (geometry.fundamental) query.bind(11, bytesOf(matrices[0] = numbersOf(*geometry.fundamental)));
  if (geometry.essential) query.bind(12, bytesOf(matrices[1] = numbersOf(*geometry.essential)));
  if (geometry.homography) query.bind(13, bytesOf(matrices[2] = numbersOf(*geometry.homography)));
  if (geometry.pose) {
    const cv::Vec3d& t = geometry.pose->translation;
    query.bind(14, bytesOf(matrices[3] = numbersOf(geometry.pose->rotation)));
    query.bind(15, bytesOf(translation = {t[0], t[1], t[2]}));
  }
  query.run();
}

PairJournal::PairJournal(const std::filesystem::path& path, const std::string& input)
    : impl_(std::make_unique<Impl>(path)) {
  impl_->begin(input);
}

PairJournal::~PairJournal() = default;

std::vector<ImagePairKey> PairJournal::verifiedPairs(const std::string& configuration) const {
  SqliteQuery query = impl_->database.query(
      "SELECT first, second FROM results JOIN configurations ON configuration = id WHERE text = ?1 "
      "ORDER BY first, second");
  query.bind(1, configuration);
  std::vector<ImagePairKey> pairs;
  while (query.next()) {
    pairs.push_back(
        {static_cast<std::uint32_t>(query.integer(0)), static_cast<std::uint32_t>(query.integer(1))});
  }
  return pairs;
}

VerifiedPair PairJournal::verified(const ImagePairKey& pair) const {
  SqliteQuery query = impl_->database.query(
      "SELECT status, scene, putative, confidence, ambiguity, config, inliers, fundamental, essential, "
      "homography, "
      "rotation, translation FROM results WHERE first = ?1 AND second = ?2");
  query.bind(1, std::int64_t{pair.first}).bind(2, std::int64_t{pair.second});
  if (!query.next()) {
    throw StoreError(StoreError::Kind::kContent, impl_->database.path().string() + ": images " +
                                                     std::to_string(pair.first) + " and " +
                                                     std::to_string(pair.second) + " are not verified");
  }
  VerifiedPair result;
  result.pair = pair;
  result.status = statusFromString(query.text(0));
  result.scene = sceneFromString(query.text(1));
  result.putative = static_cast<std::size_t>(query.integer(2));
  result.confidence = query.real(3);
  result.ambiguity = query.real(4);
  result.geometry = geometryOf(query);
  return result;
}

void PairJournal::write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) {
  SqliteTransaction transaction(impl_->database);
  const std::int64_t number = impl_->configurationNumber(configuration);
  for (const VerifiedPair& pair : pairs) {
    if (!pair.faulty) impl_->write(pair, number);
  }
  transaction.commit();
}

void PairJournal::remove() {
  const std::filesystem::path path = impl_->database.path();
  impl_.reset();
  std::filesystem::remove(path);
}

}  // namespace corrsel::core
