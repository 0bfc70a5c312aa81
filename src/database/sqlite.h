#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <unordered_map>

struct sqlite3;
struct sqlite3_stmt;

namespace corrsel::core {

/// Bytes that SQLite owns, valid until the query that gave them goes on or ends.
struct SqliteBlob {
  const unsigned char* data = nullptr;
  std::size_t size = 0;
};

class SqliteDatabase;

/// One use of a statement that the database keeps prepared. Its locks end with this object.
///
/// Columns and parameters count from 0 and 1, as SQLite's do. Members that reach the file throw StoreError.
class SqliteQuery {
 public:
  ~SqliteQuery();
  SqliteQuery(const SqliteQuery&) = delete;
  SqliteQuery& operator=(const SqliteQuery&) = delete;

  SqliteQuery& bind(int parameter, std::int64_t value);
  SqliteQuery& bind(int parameter, double value);  ///< NaN is stored as NULL
  SqliteQuery& bind(int parameter, const std::string& text);
  /// The bytes are not copied: they must live as long as the query. No data is stored as an empty BLOB.
  SqliteQuery& bind(int parameter, SqliteBlob bytes);
  SqliteQuery& bindNull(int parameter);

  /// Goes to the next row. @return false where there is none
  bool next();

  /// Runs a statement that has no rows, and makes it ready for new values.
  void run();

  bool isNull(int column) const;
  bool isInteger(int column) const;
  bool isBlob(int column) const;
  bool isText(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;  ///< NaN for NULL
  std::string text(int column) const;
  SqliteBlob blob(int column) const;

 private:
  friend class SqliteDatabase;
  SqliteQuery(const SqliteDatabase& database, sqlite3_stmt* statement)
      : database_(database), statement_(statement) {}

  const SqliteDatabase& database_;
  sqlite3_stmt* statement_;
};

/// A connection to a file of SQLite. Errors are StoreErrors with the name of the file and a remedy.
class SqliteDatabase {
 public:
  enum class Mode { kRead, kWrite, kCreate };

  /// How long another program's lock is waited for where the caller does not choose, s.
  static constexpr double kBusySeconds = 10;

  /// Opens a file.
  /// @param busy_seconds  how long to wait for another program's lock
  SqliteDatabase(const std::filesystem::path& path, Mode mode, double busy_seconds = kBusySeconds);
  ~SqliteDatabase();
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  /// A statement, which is prepared at its first use. At most one query of the same text at a time.
  SqliteQuery query(const std::string& sql) const;

  /// Runs statements without parameters and rows.
  void execute(const std::string& sql) const;

  /// Copies everything, also what is in the write-ahead log, into an empty database.
  void copyTo(const SqliteDatabase& target) const;

  std::int64_t lastRow() const;

  /// Throws the StoreError that belongs to a code of SQLite.
  [[noreturn]] void fail(int code) const;

  const std::filesystem::path& path() const { return path_; }
  double busySeconds() const { return busy_seconds_; }

 private:
  void open(const std::string& name, int flags);
  void openForReading();
  void close();

  std::filesystem::path path_;
  double busy_seconds_;
  sqlite3* connection_ = nullptr;
  mutable std::unordered_map<std::string, sqlite3_stmt*> statements_;
};

/// Changes that are stored together, or, where commit() was not reached, not at all.
class SqliteTransaction {
 public:
  /// Begins, and keeps other programs from writing.
  explicit SqliteTransaction(const SqliteDatabase& database);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  void commit();

 private:
  const SqliteDatabase& database_;
  bool open_ = true;
};

}  // namespace corrsel::core
