#include "programs/verify/session.h"

#include <optional>
#include <system_error>

#include "corrsel/database/hloc_store.h"
#include "database/sqlite.h"
#include "programs/command_line.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;
using core::ColmapStore;
using core::StoreError;

constexpr double kBusySeconds = 10;

fs::path partOf(const fs::path& path) { return path.string() + ".part"; }

/// A database of COLMAP that changes itself, or is only read.
class DatabaseSession : public Session {
 public:
  DatabaseSession(const fs::path& path, bool write)
      : path_(path), store_(path, write ? ColmapStore::Access::kWrite : ColmapStore::Access::kRead) {}

  core::PairStore& store() override { return store_; }
  ColmapStore* database() override { return &store_; }
  std::vector<core::ImagePairKey> pairsOfOthers() const override { return store_.pairsOfOthers(); }
  fs::path results() const override { return path_; }
  std::vector<std::string> warnings() const override { return store_.warnings(); }

 private:
  fs::path path_;
  ColmapStore store_;
};

/// Takes the write-ahead log into a file that is going to be renamed. Where another program has the file
/// open, closing it does not do that. Throws StoreError where that program is reading.
void makeWhole(const fs::path& path) {
  {
    const core::SqliteDatabase database(path, core::SqliteDatabase::Mode::kWrite, kBusySeconds);
    database.execute("PRAGMA wal_checkpoint(TRUNCATE)");
  }
  std::error_code none;
  const fs::path log = path.string() + "-wal";
  if (fs::exists(log) && fs::file_size(log, none) > 0) {
    throw StoreError(StoreError::Kind::kBusy,
                     path.string() +
                         " is complete, but another program is reading it; close that program and "
                         "give the same command again");
  }
  fs::remove(log, none);
  fs::remove(path.string() + "-shm", none);
}

/// A copy of a database of COLMAP.
class CopySession : public Session {
 public:
  CopySession(const fs::path& database, const fs::path& output) : output_(output) {
    if (fs::exists(output)) {
      throw UsageError("--output: " + output.string() +
                       " exists; remove it or choose another name, or give it as DATABASE to continue it");
    }
    const fs::path part = partOf(output);
    ColmapStore::continueCopy(database, part);
    store_.emplace(part, ColmapStore::Access::kWrite);
  }

  core::PairStore& store() override { return *store_; }
  ColmapStore* database() override { return &*store_; }
  fs::path results() const override { return completed_ ? output_ : partOf(output_); }
  std::vector<std::string> warnings() const override { return store_ ? store_->warnings() : warnings_; }

  void complete(const std::string&) override {
    warnings_ = store_->warnings();
    store_.reset();
    makeWhole(partOf(output_));
    std::error_code error;
    fs::rename(partOf(output_), output_, error);
    if (error) {
      throw StoreError(StoreError::Kind::kStorage, partOf(output_).string() +
                                                       " is complete, but cannot be renamed to " +
                                                       output_.string() + ": " + error.message());
    }
    completed_ = true;
  }

 private:
  fs::path output_;
  std::optional<ColmapStore> store_;
  std::vector<std::string> warnings_;
  bool completed_ = false;
};

/// Reads from one store, and keeps the results in another one.
class PartStore : public core::PairStore {
 public:
  PartStore(const core::PairStore& source, core::PairStore& results) : source_(source), results_(results) {}

  const std::vector<core::StoredImage>& images() const override { return source_.images(); }
  std::vector<core::ImagePairKey> pairs() const override { return source_.pairs(); }
  core::StoredKeypoints keypoints(std::uint32_t image) const override { return source_.keypoints(image); }
  core::StoredMatches matches(const core::ImagePairKey& pair) const override { return source_.matches(pair); }
  std::vector<core::ImagePairKey> verifiedPairs(const std::string& configuration) const override {
    return results_.verifiedPairs(configuration);
  }
  core::VerifiedPair verified(const core::ImagePairKey& pair) const override {
    return results_.verified(pair);
  }
  void write(const std::vector<core::VerifiedPair>& pairs, const std::string& configuration) override {
    results_.write(pairs, configuration);
  }

 private:
  const core::PairStore& source_;
  core::PairStore& results_;
};

/// A part of a divided run: the database is read only, and the results have a file of their own.
class PartSession : public Session {
 public:
  PartSession(const fs::path& database, const fs::path& output)
      : output_(output),
        source_(database),
        results_(created(output), ColmapStore::Access::kWrite),
        store_(source_, results_) {
    if (!results_.images().empty()) {
      throw StoreError(
          StoreError::Kind::kContent,
          output.string() + " is a database with images, and no part of a run; choose another --output");
    }
  }

  core::PairStore& store() override { return store_; }
  fs::path results() const override { return output_; }
  std::vector<std::string> warnings() const override { return source_.warnings(); }

 private:
  static const fs::path& created(const fs::path& output) {
    if (fs::exists(output)) return output;
    const fs::path part = partOf(output);
    fs::remove(part);
    ColmapStore::create(part);
    fs::rename(part, output);
    return output;
  }

  fs::path output_;
  ColmapStore source_, results_;
  PartStore store_;
};

/// Files of hloc.
class HlocSession : public Session {
 public:
  explicit HlocSession(const VerifyArguments& arguments)
      : store_(arguments.features, arguments.database,
               arguments.run.dry_run ? fs::path() : arguments.output) {}

  core::PairStore& store() override { return store_; }
  std::vector<std::string> warnings() const override { return store_.warnings(); }
  void complete(const std::string& configuration) override { store_.complete(configuration); }

 private:
  core::HlocStore store_;
};

}  // namespace

std::unique_ptr<Session> openSession(const VerifyArguments& arguments) {
  if (!arguments.features.empty()) return std::make_unique<HlocSession>(arguments);
  if (arguments.run.dry_run) return std::make_unique<DatabaseSession>(arguments.database, false);
  if (arguments.shard.count > 1) {
    return std::make_unique<PartSession>(arguments.database, arguments.output);
  }
  if (!arguments.output.empty()) {
    return std::make_unique<CopySession>(arguments.database, arguments.output);
  }
  if (!arguments.images.empty() && !fs::exists(arguments.database)) ColmapStore::create(arguments.database);
  return std::make_unique<DatabaseSession>(arguments.database, true);
}

}  // namespace corrsel
