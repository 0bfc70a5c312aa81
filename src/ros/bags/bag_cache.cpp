#include "ros/bags/bag_cache.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/checksum.h"
#include "base/text.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

// Must be raised whenever the content of the bags changes.
constexpr char kFormat[] = "8";

constexpr std::chrono::hours kKept{48};

// Endings of the files beside a bag.
constexpr char kIncomplete[] = ".incomplete", kRemarks[] = ".remarks";

/// Whether a file name is prefix + fingerprint + ".bag", with or without a further ending. The bags of
/// "set-2" must not be taken for those of "set".
bool isBagOf(const std::string& prefix, const std::string& name) {
  constexpr std::size_t kDigits = 16;
  const std::size_t end = prefix.size() + kDigits;
  return name.compare(0, prefix.size(), prefix) == 0 &&
         name.compare(end < name.size() ? end : 0, 4, ".bag") == 0 &&
         name.find_first_not_of("0123456789abcdef", prefix.size()) == end;
}

/// Beginning of the names of a dataset's bags.
std::string beginningOfName(const std::string& dataset) { return core::safeFileName(dataset) + "-"; }

std::string nameOfBag(const std::string& dataset, const core::DatasetReader& reader, int seed) {
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
  return beginningOfName(dataset) + fingerprint.text() + ".bag";
}

/// Whether a bag is there and lacks no pair.
bool isComplete(const std::string& bag) { return fs::exists(bag) && !fs::exists(bag + kIncomplete); }

/// An ending that no other process writes, on any machine that shares the folder.
std::string ownEnding() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return "-" + core::safeFileName(host.data()) + "-" + std::to_string(::getpid());
}

/// Writes a text file that other processes see either whole or not at all.
void writeAtOnce(const fs::path& path, const std::string& text) {
  const fs::path written = path.string() + ownEnding();
  std::ofstream(written) << text;
  std::error_code error;
  fs::rename(written, path, error);
}

/// Removes what no process has used for kKept: bags of the dataset with another fingerprint than that of
/// `own`, and files that were being written when their process was killed. Runs with other seeds may use the
/// younger ones now.
void removeUnused(const fs::path& folder, const std::string& prefix, const std::string& own) {
  const auto limit = fs::file_time_type::clock::now() - kKept;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!isBagOf(prefix, name)) continue;
    const std::string bag = name.substr(0, own.size());
    const bool complete = name == bag || name == bag + kIncomplete || name == bag + kRemarks;
    if (complete && bag == own) continue;
    std::error_code error;
    auto used = entry.last_write_time(error);
    if (complete && fs::exists(folder / bag)) used = fs::last_write_time(folder / bag, error);
    if (!error && used < limit) fs::remove(entry.path(), error);
  }
}

}  // namespace

std::string cacheFolder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return (fs::path(cache) / "corrsel").string();
  const char* const home = std::getenv("HOME");
  return (fs::path(home && *home ? home : ".") / ".cache" / "corrsel").string();
}

bool hasCachedBag(const std::string& folder, const std::string& dataset, const core::DatasetReader& reader,
                  int seed) {
  return isComplete((fs::path(folder) / nameOfBag(dataset, reader, seed)).string());
}

CachedBag cachedDatasetBag(const std::string& folder, const std::string& dataset,
                           const core::DatasetReader& reader, int seed, const BagProgress& progress) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw core::DatasetError("cannot create the cache folder " + folder + ": " + error.message());
  const std::string name = nameOfBag(dataset, reader, seed);
  CachedBag bag;
  bag.path = (fs::path(folder) / name).string();
  const fs::path incomplete = bag.path + kIncomplete, remarks = bag.path + kRemarks;
  removeUnused(folder, beginningOfName(dataset), name);
  if (isComplete(bag.path)) {
    bag.reused = true;
    fs::last_write_time(bag.path, fs::file_time_type::clock::now(), error);
    std::ifstream lines(remarks);
    for (std::string line; std::getline(lines, line);) bag.remarks.push_back(line);
    return bag;
  }
  // Other processes may make the same bag now: each writes a file of its own, and the last one's stays. What
  // belongs to the bag is there before the bag is.
  const std::string written = bag.path + ownEnding();
  const bool any = writeDatasetBag(reader, written, {}, progress, &bag.problems, &bag.remarks) > 0;
  if (bag.remarks.empty()) {
    fs::remove(remarks, error);
  } else {
    writeAtOnce(remarks, core::joinList(bag.remarks, "\n") + "\n");
  }
  if (!bag.problems.empty()) {
    std::string list;
    for (const UnreadablePair& problem : bag.problems) list += problem.text() + "\n";
    writeAtOnce(incomplete, list);
  }
  if (any) fs::rename(written, bag.path);
  if (bag.problems.empty()) fs::remove(incomplete, error);
  return bag;
}

}  // namespace corrsel
