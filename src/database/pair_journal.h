#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// Results of verification on their way to a file that can only be written as a whole. A journal survives the
/// death of its writer at any moment: the pairs of a write() are in it, or none of them is.
class PairJournal {
 public:
  /// Opens the journal of a run that was interrupted, or creates one.
  /// @param input  what the results depend on. Throws StoreError where the journal belongs to another one.
  PairJournal(const std::filesystem::path& path, const std::string& input);
  ~PairJournal();

  /// As the functions of PairStore that these names belong to.
  std::vector<ImagePairKey> verifiedPairs(const std::string& configuration) const;
  VerifiedPair verified(const ImagePairKey& pair) const;
  void write(const std::vector<VerifiedPair>& pairs, const std::string& configuration);

  /// Closes the journal and deletes its file.
  void remove();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel::core
