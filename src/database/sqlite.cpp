#include "database/sqlite.h"

#include <sqlite3.h>

#include <cmath>
#include <limits>
#include <system_error>

#include "base/text.h"
#include "corrsel/database/pair_store.h"

namespace corrsel::core {
namespace {

constexpr int kMillisecondsPerSecond = 1000;
constexpr const char* kFirstRead = "SELECT count(*) FROM sqlite_master";

/// A name of a file as SQLite's URIs write it.
std::string uriOf(const std::filesystem::path& path, const std::string& parameters) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char letter : std::filesystem::absolute(path).string()) {
    const auto byte = static_cast<unsigned char>(letter);
    if (letter == '%' || letter == '?' || letter == '#') {
      uri += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    } else {
      uri += letter;
    }
  }
  return uri + '?' + parameters;
}

bool hasWriteAheadLog(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path.string() + "-wal", error);
  return !error && size > 0;
}

StoreError::Kind kindOf(int code) {
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return StoreError::Kind::kBusy;
    case SQLITE_PERM:
    case SQLITE_READONLY:
    case SQLITE_IOERR:
    case SQLITE_FULL:
    case SQLITE_CANTOPEN:
    case SQLITE_NOMEM:
    case SQLITE_NOLFS:
    case SQLITE_AUTH:
      return StoreError::Kind::kStorage;
    default:
      return StoreError::Kind::kContent;
  }
}

/// What happened, and what its user can do about it.
std::string explanation(int code, const std::string& message, double busy_seconds) {
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return " is being written by another program; nothing was changed (waited " +
             formatNumber(busy_seconds) + " s); close the other program, or start again when it has ended";
    case SQLITE_FULL:
      return " cannot be written: the disk is full; make room and start again";
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return " cannot be written (" + message +
             "); allow writing to the file and to its folder, or write a copy";
    case SQLITE_CANTOPEN:
      return " cannot be opened (" + message + "); check the permissions of the file and of its folder";
    case SQLITE_IOERR:
      return " cannot be read or written (" + message + "); check the disk and the room on it";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return " is damaged or no database of COLMAP (" + message + "); take another copy of it";
    default:
      return ": SQLite says: " + message;
  }
}

}  // namespace

SqliteQuery::~SqliteQuery() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

SqliteQuery& SqliteQuery::bind(int parameter, std::int64_t value) {
  if (const int code = sqlite3_bind_int64(statement_, parameter, value)) database_.fail(code);
  return *this;
}

SqliteQuery& SqliteQuery::bind(int parameter, double value) {
  if (const int code = sqlite3_bind_double(statement_, parameter, value)) database_.fail(code);
  return *this;
}

SqliteQuery& SqliteQuery::bind(int parameter, const std::string& text) {
  const int code =
      sqlite3_bind_text64(statement_, parameter, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  if (code) database_.fail(code);
  return *this;
}

SqliteQuery& SqliteQuery::bind(int parameter, SqliteBlob bytes) {
  const void* data = bytes.size ? static_cast<const void*>(bytes.data) : "";
  const int code = sqlite3_bind_blob64(statement_, parameter, data, bytes.size, SQLITE_STATIC);
  if (code) database_.fail(code);
  return *this;
}

SqliteQuery& SqliteQuery::bindNull(int parameter) {
  if (const int code = sqlite3_bind_null(statement_, parameter)) database_.fail(code);
  return *this;
}

bool SqliteQuery::next() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_.fail(code);
  return false;
}

void SqliteQuery::run() {
  next();
  sqlite3_reset(statement_);
}

bool SqliteQuery::isNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

bool SqliteQuery::isInteger(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_INTEGER;
}

bool SqliteQuery::isBlob(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_BLOB; }

bool SqliteQuery::isText(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_TEXT; }

std::int64_t SqliteQuery::integer(int column) const { return sqlite3_column_int64(statement_, column); }

double SqliteQuery::real(int column) const {
  return isNull(column) ? std::numeric_limits<double>::quiet_NaN()
                        : sqlite3_column_double(statement_, column);
}

std::string SqliteQuery::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (!text) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

SqliteBlob SqliteQuery::blob(int column) const {
  const auto* data = static_cast<const unsigned char*>(sqlite3_column_blob(statement_, column));
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

SqliteDatabase::SqliteDatabase(const std::filesystem::path& path, Mode mode, double busy_seconds)
    : path_(path), busy_seconds_(busy_seconds) {
  try {
    switch (mode) {
      case Mode::kRead:
        openForReading();
        break;
      case Mode::kWrite:
        open(uriOf(path, "mode=rw"), SQLITE_OPEN_READWRITE);
        query(kFirstRead).next();
        break;
      case Mode::kCreate:
        open(uriOf(path, "mode=rwc"), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
        break;
    }
  } catch (...) {
    // The destructor does not run for an object whose constructor throws.
    close();
    throw;
  }
}

SqliteDatabase::~SqliteDatabase() { close(); }

void SqliteDatabase::close() {
  for (const auto& [sql, statement] : statements_) sqlite3_finalize(statement);
  statements_.clear();
  sqlite3_close(connection_);
  connection_ = nullptr;
}

void SqliteDatabase::open(const std::string& name, int flags) {
  const int code = sqlite3_open_v2(name.c_str(), &connection_, flags | SQLITE_OPEN_URI, nullptr);
  if (code) fail(code);
  sqlite3_extended_result_codes(connection_, 1);
  sqlite3_busy_timeout(connection_, static_cast<int>(busy_seconds_ * kMillisecondsPerSecond));
}

void SqliteDatabase::openForReading() {
  try {
    open(uriOf(path_, "mode=ro"), SQLITE_OPEN_READONLY);
    query(kFirstRead).next();
  } catch (const StoreError& error) {
    // A database whose journal is a write-ahead log needs files beside it even for reading. In a folder that
    // cannot be written nobody else writes either, so that it can be read without them.
    if (error.kind() != StoreError::Kind::kStorage || hasWriteAheadLog(path_)) throw;
    close();
    open(uriOf(path_, "mode=ro&immutable=1"), SQLITE_OPEN_READONLY);
    query(kFirstRead).next();
  }
}

SqliteQuery SqliteDatabase::query(const std::string& sql) const {
  sqlite3_stmt*& statement = statements_[sql];
  if (!statement) {
    const int code = sqlite3_prepare_v3(connection_, sql.c_str(), static_cast<int>(sql.size() + 1),
                                        SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    if (code) fail(code);
  }
  return {*this, statement};
}

void SqliteDatabase::execute(const std::string& sql) const {
  if (const int code = sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr)) fail(code);
}

void SqliteDatabase::copyTo(const SqliteDatabase& target) const {
  sqlite3_backup* backup = sqlite3_backup_init(target.connection_, "main", connection_, "main");
  if (!backup) target.fail(sqlite3_errcode(target.connection_));
  const int code = sqlite3_backup_step(backup, -1);
  const int end = sqlite3_backup_finish(backup);
  if (end != SQLITE_OK) target.fail(end);
  if (code != SQLITE_DONE) fail(code);
}

std::int64_t SqliteDatabase::lastRow() const { return sqlite3_last_insert_rowid(connection_); }

void SqliteDatabase::fail(int code) const {
  // The connection's own message is more exact, but may belong to another error.
  const bool own = connection_ && (sqlite3_errcode(connection_) & 0xff) == (code & 0xff);
  const std::string message = own ? sqlite3_errmsg(connection_) : sqlite3_errstr(code);
  throw StoreError(kindOf(code), path_.string() + explanation(code, message, busy_seconds_));
}

SqliteTransaction::SqliteTransaction(const SqliteDatabase& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

SqliteTransaction::~SqliteTransaction() {
  if (!open_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const StoreError&) {
    // SQLite has rolled back by itself, as it does where the disk is full.
  }
}

void SqliteTransaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace corrsel::core
