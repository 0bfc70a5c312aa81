#include "ros/bags/bag_cache.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/checksum.h"
#include "base/text.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

// Must be raised whenever the content of the bags changes.
constexpr char kFormat[] = "6";

/// Whether a file name is prefix + fingerprint + ".bag", with or without a further ending. The bags of
/// "set-2" must not be taken for those of "set".
bool isBagOf(const std::string& prefix, const std::string& name) {
  constexpr std::size_t kDigits = 16;
  const std::size_t end = prefix.size() + kDigits;
  return name.compare(0, prefix.size(), prefix) == 0 &&
         name.compare(end < name.size() ? end : 0, 4, ".bag") == 0 &&
         name.find_first_not_of("0123456789abcdef", prefix.size()) == end;
}

}  // namespace

std::string cacheFolder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return (fs::path(cache) / "corrsel").string();
  const char* const home = std::getenv("HOME");
  return (fs::path(home && *home ? home : ".") / ".cache" / "corrsel").string();
}

CachedBag cachedDatasetBag(const std::string& folder, const std::string& dataset,
                           const core::DatasetReader& reader, int seed, const BagProgress& progress) {
  core::Checksum fingerprint;
  const auto addLine = [&fingerprint](const std::string& text) { fingerprint.add(text + '\n'); };
  addLine(kFormat);
  addLine(dataset);
  addLine(std::to_string(seed));
  for (const std::string& file : reader.files()) {
    std::error_code error;
    addLine(fs::absolute(file).string());
    addLine(std::to_string(fs::file_size(file, error)));
    addLine(std::to_string(fs::last_write_time(file, error).time_since_epoch().count()));
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw core::DatasetError("cannot create the cache folder " + folder + ": " + error.message());
  const std::string prefix = core::safeFileName(dataset) + "-";
  CachedBag bag;
  bag.path = (fs::path(folder) / (prefix + fingerprint.text() + ".bag")).string();
  const fs::path incomplete = bag.path + ".incomplete", remarks = bag.path + ".remarks";
  if (fs::exists(bag.path) && !fs::exists(incomplete)) {
    bag.reused = true;
    std::ifstream lines(remarks);
    for (std::string line; std::getline(lines, line);) bag.remarks.push_back(line);
    return bag;
  }
  const std::string own = fs::path(bag.path).filename().string();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    // Another process may be writing the very same bag.
    if (isBagOf(prefix, name) && name.compare(0, own.size(), own) != 0) fs::remove(entry.path(), error);
  }
  // Other processes may make the same bag now: each writes a file of its own, and the last one's stays.
  const std::string written = bag.path + "-" + std::to_string(::getpid());
  const bool any = writeDatasetBag(reader, written, {}, progress, &bag.problems, &bag.remarks) > 0;
  fs::remove(remarks, error);
  if (!bag.remarks.empty()) std::ofstream(remarks) << core::joinList(bag.remarks, "\n") << "\n";
  if (any) fs::rename(written, bag.path);
  fs::remove(incomplete, error);
  if (bag.problems.empty()) return bag;
  std::ofstream list(incomplete);
  for (const UnreadablePair& problem : bag.problems) list << problem.text() << "\n";
  return bag;
}

}  // namespace corrsel
