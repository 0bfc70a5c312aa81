#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/database/colmap_store.h"
#include "corrsel/database/pair_store.h"
#include "programs/verify/arguments.h"

namespace corrsel {

/// The files of a run: what is read, and what takes the results. Members throw StoreError.
class Session {
 public:
  virtual ~Session() = default;

  virtual core::PairStore& store() = 0;

  /// The database of COLMAP that takes images, matches and merged parts; null for other files.
  virtual core::ColmapStore* database() { return nullptr; }

  /// Pairs whose stored verification is not to be replaced unless it is asked for, in ascending order.
  virtual std::vector<core::ImagePairKey> pairsOfOthers() const { return {}; }

  /// The file of SQLite with the results so far; empty where there is none.
  virtual std::filesystem::path results() const { return {}; }

  /// Ends a complete run: a file that was called ".part" gets its name. The stores must not be used any more.
  virtual void complete(const std::string& configuration) { static_cast<void>(configuration); }

  virtual std::vector<std::string> warnings() const = 0;
};

/// Opens what the arguments name, and makes the copy that they ask for. Throws UsageError where a complete
/// output exists, and StoreError.
std::unique_ptr<Session> openSession(const VerifyArguments& arguments);

}  // namespace corrsel
