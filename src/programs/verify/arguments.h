#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/camera_formats.h"
#include "corrsel/database/extraction.h"
#include "corrsel/database/pair_matching.h"
#include "corrsel/database/pair_verifier.h"
#include "corrsel/database/verification.h"
#include "corrsel/shard.h"

namespace corrsel {

/// The command line of corrsel_verify.
struct VerifyArguments {
  std::string help;                          ///< text to print instead of doing anything; empty: none
  std::filesystem::path database;            ///< of COLMAP, or with `features` the file of matches of hloc
  std::filesystem::path features;            ///< of hloc; empty: `database` is one of COLMAP
  std::filesystem::path output;              ///< empty: the database itself changes
  std::filesystem::path pairs;               ///< list of pairs; empty: all
  std::filesystem::path images;              ///< folder with images whose features are searched; empty: none
  std::optional<core::ColmapCamera> camera;  ///< that took all images
  bool match = false;
  int sequential = 0;  ///< images that each image is matched with; 0: all
  core::Shard shard;
  std::vector<std::filesystem::path> merge;
  std::filesystem::path tracks;                ///< file of tracks to write; empty: none
  std::vector<std::filesystem::path> reports;  ///< each ends in .csv, .json or .html
  core::PairVerifierOptions verifier;
  core::PairMatchingOptions matching;
  core::ExtractionOptions extraction;
  core::VerificationOptions run;
};

/// Throws UsageError, or std::invalid_argument for options of algorithms.
VerifyArguments parseVerifyArguments(const std::vector<std::string>& words);

}  // namespace corrsel
