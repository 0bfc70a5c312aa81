#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/database/cycles.h"
#include "corrsel/database/pair_store.h"
#include "corrsel/database/tracks.h"
#include "corrsel/database/verification.h"

namespace corrsel {

/// What a report says about a pair: 48 bytes, since there may be millions of them.
struct ReportPair {
  core::ImagePairKey pair;
  std::uint32_t raw = 0, kept = 0;  ///< matches before and after the verification
  core::Status status = core::Status::kOk;
  core::TwoViewConfig config = core::TwoViewConfig::kUndefined;
  double confidence = 0, ambiguity = 0;

  bool accepted() const { return config != core::TwoViewConfig::kUndefined; }
};

ReportPair reportPair(const core::VerifiedPair& pair);

/// What a run of corrsel_verify did and found.
struct VerifyReport {
  std::string database, result;  ///< files
  std::string configuration;
  std::string shard;                                               ///< "1/3"; empty: none
  std::string checksum;                                            ///< of the rows; empty: none
  std::vector<core::StoredImage> images;                           ///< all of the store
  std::vector<ReportPair> pairs;                                   ///< with a verification, ascending
  std::vector<std::pair<core::ImagePairKey, std::string>> faulty;  ///< why pairs could not be verified
  std::optional<core::TrackStatistics> tracks;                     ///< of runs that write tracks, as `cycles`
  std::optional<core::CycleReport> cycles;
  std::vector<std::string> warnings;
  core::VerificationSummary summary;
  std::size_t of_others = 0;  ///< pairs that are left as another program has verified them
  int threads = 1;
  double processor_seconds = 0;
  double peak_memory_mib = 0;
  bool dry_run = false;
};

/// The report as text for a terminal.
std::string reportText(const VerifyReport& report);

/// Writes the files, each in the form that its ending names. Throws StoreError.
void writeReports(const VerifyReport& report, const std::vector<std::filesystem::path>& files);

}  // namespace corrsel
