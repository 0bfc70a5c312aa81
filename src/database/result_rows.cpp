#include "database/result_rows.h"

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "base/checksum.h"
#include "base/text.h"
#include "corrsel/database/pair_store.h"
#include "database/colmap_schema.h"
#include "database/sqlite.h"

namespace corrsel::core {
namespace {

void addNumber(Checksum& checksum, std::int64_t value) {
  std::array<std::uint8_t, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
  checksum.add(bytes.data(), bytes.size());
}

/// The columns of two_view_geometries that the database has.
std::vector<std::string> geometryColumns(const SqliteDatabase& database) {
  const std::set<std::string> present = columnsOf(database, "two_view_geometries");
  std::vector<std::string> columns = {"pair_id", "rows", "cols", "config", "data", "F", "E", "H"};
  for (const char* name : {"qvec", "tvec"}) {
    if (present.count(name) > 0) columns.emplace_back(name);
  }
  return columns;
}

/// The number that a query of one row and column gives.
std::int64_t count(const SqliteDatabase& database, const std::string& sql, const std::string& parameter) {
  SqliteQuery query = database.query(sql);
  if (!parameter.empty()) query.bind(1, parameter);
  query.next();
  return query.integer(0);
}

/// A second database of a connection, called "part".
class Attached {
 public:
  Attached(const SqliteDatabase& database, const std::filesystem::path& part) : database_(database) {
    database_.query("ATTACH ?1 AS part").bind(1, part.string()).run();
  }
  ~Attached() {
    try {
      database_.execute("DETACH part");
    } catch (const StoreError&) {  // The connection ends soon.
    }
  }
  Attached(const Attached&) = delete;
  Attached& operator=(const Attached&) = delete;

 private:
  const SqliteDatabase& database_;
};

void requirePart(const std::filesystem::path& part) {
  const auto refuse = [&](const std::string& text) {
    throw StoreError(StoreError::Kind::kContent, part.string() + ": " + text);
  };
  if (!std::filesystem::exists(part)) refuse("there is no such file; verify this part first");
  const SqliteDatabase database(part, SqliteDatabase::Mode::kRead);
  for (const char* table : {"corrsel_verify", "corrsel_configurations", "two_view_geometries"}) {
    if (!hasTable(database, table)) {
      refuse(std::string("there is no table ") + table + "; give files that were written with --shard");
    }
  }
}

/// Throws StoreError unless the attached part fits the database.
void requireFitting(const SqliteDatabase& database, const std::filesystem::path& part,
                    const std::string& configuration) {
  const auto refuse = [&](const std::string& text) {
    throw StoreError(StoreError::Kind::kContent, part.string() + ": " + text);
  };
  const std::int64_t others = count(database,
                                    "SELECT count(*) FROM part.corrsel_verify WHERE configuration NOT IN "
                                    "(SELECT id FROM part.corrsel_configurations WHERE text = ?1)",
                                    configuration);
  if (others > 0) {
    refuse(std::to_string(others) + " pairs were verified with other settings than '" + configuration +
           "'; verify the part again with the arguments of this run");
  }
  const std::int64_t strange =
      count(database,
            "SELECT count(*) FROM part.corrsel_verify v LEFT JOIN main.matches m "
            "ON m.pair_id = v.pair_id WHERE m.pair_id IS NULL OR m.rows <> v.putative",
            "");
  if (strange > 0) {
    refuse(std::to_string(strange) + " pairs have other matches in " + database.path().string() +
           "; the part belongs to another database, or the pairs were matched again");
  }
}

}  // namespace

std::string checksumOfGeometries(const std::filesystem::path& path) {
  const SqliteDatabase database(path, SqliteDatabase::Mode::kRead);
  const std::vector<std::string> columns = geometryColumns(database);
  constexpr int kNumbers = 4, kBlobs = 6;
  Checksum checksum;
  SqliteQuery query =
      database.query("SELECT " + joinList(columns) + " FROM two_view_geometries ORDER BY pair_id");
  while (query.next()) {
    for (int k = 0; k < kNumbers; ++k) addNumber(checksum, query.integer(k));
    for (int k = kNumbers; k < kNumbers + kBlobs; ++k) {
      const SqliteBlob bytes = k < static_cast<int>(columns.size()) ? query.blob(k) : SqliteBlob();
      addNumber(checksum, static_cast<std::int64_t>(bytes.size));
      if (bytes.size > 0) checksum.add(bytes.data, bytes.size);
    }
  }
  return checksum.text();
}

std::size_t mergeVerifications(const std::filesystem::path& path, const std::filesystem::path& part,
                               const std::string& configuration) {
  requirePart(part);
  const SqliteDatabase database(path, SqliteDatabase::Mode::kWrite);
  const Attached attached(database, part);
  requireFitting(database, part, configuration);
  SqliteTransaction transaction(database);
  createVerificationTables(database);
  database.query("INSERT OR IGNORE INTO main.corrsel_configurations(text) VALUES (?1)")
      .bind(1, configuration)
      .run();
  const std::string columns = joinList(geometryColumns(database));
  const std::string rest = "status, confidence, putative, accepted, inliers, config, scene, ambiguity";
  database.execute("INSERT OR REPLACE INTO main.two_view_geometries(" + columns + ") SELECT " + columns +
                   " FROM part.two_view_geometries ORDER BY pair_id");
  database
      .query("INSERT OR REPLACE INTO main.corrsel_verify(pair_id, configuration, " + rest +
             ") SELECT pair_id, (SELECT id FROM main.corrsel_configurations WHERE text = ?1), " + rest +
             " FROM part.corrsel_verify ORDER BY pair_id")
      .bind(1, configuration)
      .run();
  transaction.commit();
  return static_cast<std::size_t>(count(database, "SELECT count(*) FROM part.corrsel_verify", ""));
}

}  // namespace corrsel::core
