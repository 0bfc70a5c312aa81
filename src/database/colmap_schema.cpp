#include "database/colmap_schema.h"

#include <utility>
#include <vector>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {
namespace {

// The columns that COLMAP has written from version 3.4 on. Newer versions add their own when they open it.
constexpr const char* kColmapTables = R"(
CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE,
  camera_id INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL,
  prior_ty REAL, prior_tz REAL, CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL,
  data BLOB);
CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB, config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
)";

// inliers and config repeat what two_view_geometries got, so that a row that another program replaced shows.
constexpr const char* kVerificationTables = R"(
CREATE TABLE IF NOT EXISTS corrsel_configurations (id INTEGER PRIMARY KEY NOT NULL, text TEXT NOT NULL UNIQUE);
CREATE TABLE IF NOT EXISTS corrsel_verify (pair_id INTEGER PRIMARY KEY NOT NULL,
  configuration INTEGER NOT NULL REFERENCES corrsel_configurations(id), status TEXT NOT NULL, confidence REAL,
  putative INTEGER NOT NULL, accepted INTEGER NOT NULL, inliers INTEGER NOT NULL, config INTEGER NOT NULL,
  scene TEXT NOT NULL, ambiguity REAL);
)";

struct Needed {
  const char* table;
  std::vector<const char*> columns;
};

const std::vector<Needed>& neededColumns() {
  static const std::vector<Needed> needed = {
      {"cameras", {"camera_id", "model", "width", "height", "params", "prior_focal_length"}},
      {"images", {"image_id", "name", "camera_id"}},
      {"keypoints", {"image_id", "rows", "cols", "data"}},
      {"matches", {"pair_id", "rows", "cols", "data"}},
      {"two_view_geometries", {"pair_id", "rows", "cols", "data", "config", "F", "E", "H"}},
  };
  return needed;
}

[[noreturn]] void refuse(const SqliteDatabase& database, const std::string& text) {
  throw StoreError(StoreError::Kind::kContent, database.path().string() + ": " + text);
}

}  // namespace

void createColmapTables(const SqliteDatabase& database) {
  // This mode is stored in the file, and COLMAP sets it, too. It cannot be changed in a transaction.
  database.execute("PRAGMA journal_mode = WAL");
  SqliteTransaction transaction(database);
  database.execute(kColmapTables);
  database.execute("PRAGMA user_version = " + std::to_string(kColmapUserVersion));
  transaction.commit();
}

void createVerificationTables(const SqliteDatabase& database) { database.execute(kVerificationTables); }

bool hasTable(const SqliteDatabase& database, const std::string& table) {
  SqliteQuery query = database.query("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?1");
  return query.bind(1, table).next();
}

std::set<std::string> columnsOf(const SqliteDatabase& database, const std::string& table) {
  SqliteQuery query = database.query("SELECT name FROM pragma_table_info(?1)");
  query.bind(1, table);
  std::set<std::string> names;
  while (query.next()) names.insert(query.text(0));
  return names;
}

void requireColmapTables(const SqliteDatabase& database) {
  for (const Needed& needed : neededColumns()) {
    const std::set<std::string> present = columnsOf(database, needed.table);
    const std::string table = needed.table;
    if (present.empty()) {
      refuse(database, "there is no table " + table +
                           "; give a database of COLMAP 3.4 or later, which its feature_extractor creates");
    }
    for (const char* column : needed.columns) {
      if (present.count(column)) continue;
      refuse(database, "the table " + table + " has no column " + column +
                           "; if the database is older than COLMAP 3.4, open it once with a newer COLMAP");
    }
  }
}

void requireWritableGeometries(const SqliteDatabase& database) {
  static const std::set<std::string> known = {"pair_id", "rows", "cols", "data", "config",
                                              "F",       "E",    "H",    "qvec", "tvec"};
  SqliteQuery query = database.query(
      "SELECT name FROM pragma_table_info('two_view_geometries') "
      "WHERE \"notnull\" = 1 AND dflt_value IS NULL AND pk = 0");
  while (query.next()) {
    if (known.count(query.text(0))) continue;
    refuse(database, "the table two_view_geometries has the column " + query.text(0) +
                         ", which must be filled and which this version of corrsel does not know; use a "
                         "database of an older COLMAP, or a newer corrsel");
  }
}

}  // namespace corrsel::core
