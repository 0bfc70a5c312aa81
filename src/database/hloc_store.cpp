#include "corrsel/database/hloc_store.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "base/text.h"
#include "database/hdf5_file.h"
#include "database/pair_journal.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKeypoints = "keypoints";
constexpr const char* kMatches = "matches0";
constexpr const char* kScores = "matching_scores0";
// As many keypoints can be numbered by 16 bits with a sign.
constexpr std::size_t kMaxShortRows = 32768;
constexpr float kMaxSide = 1 << 20;

/// The groups in which a pair can be, in the order in which they count.
struct Layout {
  bool reverse;    ///< whether the second image comes first
  char separator;  ///< between the names
};
constexpr std::array<Layout, 4> kLayouts = {{{false, '/'}, {true, '/'}, {false, '_'}, {true, '_'}}};

/// A pair, and for each of kLayouts one bit that says whether the file has the group.
struct ListedPair {
  ImagePairKey key;
  unsigned layouts = 0;
};

[[noreturn]] void fail(const fs::path& file, const std::string& path, const std::string& fault) {
  throw StoreError(StoreError::Kind::kContent, file.string() + ", " + path + ": " + fault);
}

/// Paths of the groups that have keypoints, at any depth below `group`.
void findImages(const Hdf5File& file, const std::string& group, std::vector<std::string>& names) {
  for (const std::string& member : file.members(group.empty() ? "/" : group)) {
    const std::string path = group.empty() ? member : group + "/" + member;
    if (!file.isGroup(path)) continue;
    if (file.exists(path + "/" + kKeypoints)) {
      names.push_back(path);
    } else {
      findImages(file, path, names);
    }
  }
}

std::string encoded(std::string name) {
  std::replace(name.begin(), name.end(), '/', '-');
  return name;
}

/// What the results of a file of matches depend on.
std::string fingerprint(const fs::path& features, const fs::path& matches) {
  std::string text;
  for (const fs::path& path : {features, matches}) {
    text += fs::absolute(path).lexically_normal().string() + " " + std::to_string(fs::file_size(path)) + " " +
            std::to_string(fs::last_write_time(path).time_since_epoch().count()) + "\n";
  }
  return text;
}

/// Appends to the name of a file.
fs::path extended(fs::path path, const char* ending) { return path += ending; }

}  // namespace

struct HlocStore::Impl {
  Impl(const fs::path& features, const fs::path& matches, const fs::path& output)
      : features_path(features), matches_path(matches), output(output), features(features), matches(matches) {
    readImages();
    readPairs();
    if (!output.empty()) openOutput();
  }

  void readImages();
  cv::Size readSize(const std::string& name) const;
  void readPairs();
  void addPair(const std::string& first, const std::string& second, char separator, const std::string& group);
  void addOldPair(const std::string& group);
  std::uint32_t imageOf(const std::string& code, const std::string& group) const;
  void openOutput();

  const StoredImage& image(std::uint32_t number) const;
  const ListedPair& listed(const ImagePairKey& pair) const;
  std::string group(const ImagePairKey& pair, const Layout& layout) const;
  std::size_t keypointCount(std::uint32_t number) const;
  std::vector<float> scores(const std::string& group, std::size_t rows) const;
  void writeGroup(Hdf5File& file, const std::string& group, bool reverse, const VerifiedPair* result) const;
  void writeOutput(const fs::path& path, const std::string& configuration) const;

  fs::path features_path, matches_path, output;
  Hdf5File features, matches;
  std::vector<StoredImage> images;
  std::map<std::string, std::vector<std::uint32_t>> by_code;  ///< numbers of images
  std::vector<ListedPair> pairs;                              ///< ascending
  std::unique_ptr<PairJournal> journal;
  std::vector<std::string> warnings;
};

void HlocStore::Impl::readImages() {
  std::vector<std::string> names;
  findImages(features, "", names);
  if (names.empty()) {
    fail(features_path, "/", "no group has keypoints; is it the file of the features?");
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    StoredImage image;
    image.id = static_cast<std::uint32_t>(images.size() + 1);
    image.name = name;
    image.size = readSize(name);
    by_code[encoded(name)].push_back(image.id);
    images.push_back(image);
  }
}

cv::Size HlocStore::Impl::readSize(const std::string& name) const {
  const std::string path = name + "/image_size";
  if (!features.exists(path)) return {};
  const std::vector<float> values = features.floats(path);
  const auto valid = [](float side) { return side >= 1 && side <= kMaxSide && side == std::floor(side); };
  if (values.size() != 2 || !valid(values[0]) || !valid(values[1])) {
    std::vector<std::string> texts;
    for (const float value : values) texts.push_back(formatNumber(value));
    fail(features_path, path,
         "is '" + joinList(texts) + "'; expected width and height, px. Extract the features again");
  }
  return {static_cast<int>(values[0]), static_cast<int>(values[1])};
}

void HlocStore::Impl::readPairs() {
  for (const std::string& first : matches.members("/")) {
    if (!matches.isGroup(first)) continue;
    if (matches.exists(first + "/" + kMatches)) {
      addOldPair(first);
      continue;
    }
    for (const std::string& second : matches.members(first)) {
      const std::string path = first + "/" + second;
      if (matches.exists(path + "/" + kMatches)) addPair(first, second, '/', path);
    }
  }
  if (pairs.empty()) fail(matches_path, "/", "no group has matches0; is it the file of the matches?");
  std::sort(pairs.begin(), pairs.end(),
            [](const ListedPair& a, const ListedPair& b) { return a.key < b.key; });
  std::size_t kept = 0;
  for (const ListedPair& pair : pairs) {
    if (kept > 0 && pairs[kept - 1].key == pair.key) {
      pairs[kept - 1].layouts |= pair.layouts;
    } else {
      pairs[kept++] = pair;
    }
  }
  if (kept < pairs.size()) {
    warnings.push_back(matches_path.string() + " has " + std::to_string(pairs.size() - kept) +
                       " pairs twice; the first group of each was verified");
  }
  pairs.resize(kept);
}

void HlocStore::Impl::addPair(const std::string& first, const std::string& second, char separator,
                              const std::string& group) {
  const std::uint32_t a = imageOf(first, group), b = imageOf(second, group);
  if (a == b) {
    warnings.push_back(matches_path.string() + ", " + group + ": an image with itself, skipped");
    return;
  }
  ListedPair pair;
  pair.key = {std::min(a, b), std::max(a, b)};
  for (std::size_t i = 0; i < kLayouts.size(); ++i) {
    if (kLayouts[i].reverse == (a > b) && kLayouts[i].separator == separator) pair.layouts = 1U << i;
  }
  pairs.push_back(pair);
}

void HlocStore::Impl::addOldPair(const std::string& group) {
  std::vector<std::size_t> cuts;
  for (std::size_t i = group.find('_'); i != std::string::npos; i = group.find('_', i + 1)) {
    if (by_code.count(group.substr(0, i)) != 0 && by_code.count(group.substr(i + 1)) != 0) cuts.push_back(i);
  }
  if (cuts.size() != 1) {
    fail(matches_path, group,
         std::string(cuts.empty() ? "none" : "more than one") + " of its splits at '_' names two images of " +
             features_path.string() +
             "; match the images again with hloc 1.3 or newer, which has a group for each");
  }
  addPair(group.substr(0, cuts[0]), group.substr(cuts[0] + 1), '_', group);
}

std::uint32_t HlocStore::Impl::imageOf(const std::string& code, const std::string& group) const {
  const auto found = by_code.find(code);
  if (found == by_code.end()) {
    fail(matches_path, group,
         "'" + code + "' is no image of " + features_path.string() + "; do the two files belong together?");
  }
  if (found->second.size() > 1) {
    fail(matches_path, group,
         "'" + code + "' stands for " + images[found->second[0] - 1].name + " and for " +
             images[found->second[1] - 1].name + "; rename one of the images, extract and match again");
  }
  return found->second[0];
}

void HlocStore::Impl::openOutput() {
  std::error_code ignored;
  if (fs::exists(output, ignored)) {
    throw StoreError(StoreError::Kind::kStorage,
                     output.string() + " exists; delete it, or give another name for the output");
  }
  journal =
      std::make_unique<PairJournal>(extended(output, ".part"), fingerprint(features_path, matches_path));
}

const StoredImage& HlocStore::Impl::image(std::uint32_t number) const {
  if (number == 0 || number > images.size()) {
    throw StoreError(StoreError::Kind::kContent, features_path.string() + ": there is no image " +
                                                     std::to_string(number) + ", only 1 to " +
                                                     std::to_string(images.size()));
  }
  return images[number - 1];
}

const ListedPair& HlocStore::Impl::listed(const ImagePairKey& pair) const {
  const auto place =
      std::lower_bound(pairs.begin(), pairs.end(), pair,
                       [](const ListedPair& listed, const ImagePairKey& key) { return listed.key < key; });
  if (place == pairs.end() || !(place->key == pair)) {
    fail(matches_path, group(pair, kLayouts[0]), "the pair is not in the file; match it first");
  }
  return *place;
}

std::string HlocStore::Impl::group(const ImagePairKey& pair, const Layout& layout) const {
  const std::string first = encoded(image(pair.first).name), second = encoded(image(pair.second).name);
  return layout.reverse ? second + layout.separator + first : first + layout.separator + second;
}

std::size_t HlocStore::Impl::keypointCount(std::uint32_t number) const {
  const std::string path = image(number).name + "/" + kKeypoints;
  const std::vector<std::size_t> shape = features.shape(path);
  if (shape.size() == 2 && shape[1] == 2) return shape[0];
  std::vector<std::string> extents;
  for (const std::size_t extent : shape) extents.push_back(std::to_string(extent));
  fail(features_path, path,
       "has the shape " + joinList(extents, " x ") + ", expected N x 2: x and y of every keypoint, px");
}

std::vector<float> HlocStore::Impl::scores(const std::string& group, std::size_t rows) const {
  const std::string path = group + "/" + kScores;
  if (!matches.exists(path)) return {};
  std::vector<float> values = matches.floats(path);
  if (values.size() != rows) {
    fail(matches_path, path,
         "has " + std::to_string(values.size()) + " numbers, but matches0 has " + std::to_string(rows));
  }
  return values;
}

void HlocStore::Impl::writeGroup(Hdf5File& file, const std::string& group, bool reverse,
                                 const VerifiedPair* result) const {
  const std::string matches_name = group + "/" + kMatches, scores_name = group + "/" + kScores;
  std::vector<std::int64_t> numbers = file.integers(matches_name);
  std::vector<std::uint8_t> kept(numbers.size(), 0);
  for (std::size_t i = 0; result != nullptr && i < result->geometry.inliers.size(); ++i) {
    const KeypointPair& row = result->geometry.inliers[i];
    const std::size_t from = row[reverse ? 1 : 0];
    if (from < numbers.size() && numbers[from] == row[reverse ? 0 : 1]) kept[from] = 1;
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (kept[i] == 0) numbers[i] = -1;
  }
  file.write(matches_name, numbers);
  if (file.exists(scores_name)) {
    std::vector<float> values = file.floats(scores_name);
    values.resize(std::max(values.size(), kept.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i >= kept.size() || kept[i] == 0) values[i] = 0;
    }
    values.resize(file.floats(scores_name).size());
    file.write(scores_name, values);
  }
  file.setAttribute(group, "corrsel_status", result == nullptr ? "not_verified" : toString(result->status));
  if (result == nullptr) return;
  file.setAttribute(group, "corrsel_scene", toString(result->scene));
  file.setAttribute(group, "corrsel_config", toString(result->geometry.config));
  file.setAttribute(group, "corrsel_confidence", result->confidence);
}

void HlocStore::Impl::writeOutput(const fs::path& path, const std::string& configuration) const {
  fs::copy_file(matches_path, path, fs::copy_options::overwrite_existing);
  fs::permissions(path, fs::perms::owner_write, fs::perm_options::add);
  Hdf5File file(path, Hdf5File::Access::kWrite);
  const std::vector<ImagePairKey> verified = journal->verifiedPairs(configuration);
  for (const ListedPair& pair : pairs) {
    const bool has_result = std::binary_search(verified.begin(), verified.end(), pair.key);
    const VerifiedPair result = has_result ? journal->verified(pair.key) : VerifiedPair{};
    for (std::size_t i = 0; i < kLayouts.size(); ++i) {
      if ((pair.layouts >> i & 1U) == 0) continue;
      writeGroup(file, group(pair.key, kLayouts[i]), kLayouts[i].reverse, has_result ? &result : nullptr);
    }
  }
  file.setAttribute("/", "corrsel_configuration", configuration);
  file.flush();
}

HlocStore::HlocStore(const fs::path& features, const fs::path& matches, const fs::path& output)
    : impl_(std::make_unique<Impl>(features, matches, output)) {}

HlocStore::~HlocStore() = default;

const std::vector<StoredImage>& HlocStore::images() const { return impl_->images; }

std::vector<ImagePairKey> HlocStore::pairs() const {
  std::vector<ImagePairKey> keys;
  keys.reserve(impl_->pairs.size());
  for (const ListedPair& pair : impl_->pairs) keys.push_back(pair.key);
  return keys;
}

StoredKeypoints HlocStore::keypoints(std::uint32_t image) const {
  const std::size_t count = impl_->keypointCount(image);
  const std::vector<float> values = impl_->features.floats(impl_->image(image).name + "/" + kKeypoints);
  StoredKeypoints keypoints;
  keypoints.positions.reserve(count);
  for (std::size_t i = 0; i < count; ++i) keypoints.positions.emplace_back(values[2 * i], values[2 * i + 1]);
  return keypoints;
}

StoredMatches HlocStore::matches(const ImagePairKey& pair) const {
  const ListedPair& listed = impl_->listed(pair);
  std::size_t layout = 0;
  while ((listed.layouts >> layout & 1U) == 0) ++layout;
  const bool reverse = kLayouts[layout].reverse;
  const std::string group = impl_->group(pair, kLayouts[layout]), path = group + "/" + kMatches;
  const std::vector<std::int64_t> numbers = impl_->matches.integers(path);
  const std::size_t count = impl_->keypointCount(reverse ? pair.second : pair.first);
  const std::size_t other_count = impl_->keypointCount(reverse ? pair.first : pair.second);
  if (numbers.size() != count) {
    fail(impl_->matches_path, path,
         "has " + std::to_string(numbers.size()) + " numbers, but the image has " + std::to_string(count) +
             " keypoints; do the two files belong together?");
  }
  if (impl_->matches.numberSize(path) == 2 && other_count > kMaxShortRows) {
    fail(impl_->matches_path, path,
         "numbers of 16 bits cannot name the " + std::to_string(other_count) +
             " keypoints of the other image; match with at most " + std::to_string(kMaxShortRows));
  }
  const std::vector<float> scores = impl_->scores(group, count);
  StoredMatches matches;
  bool useful = false, probabilities = !scores.empty();
  for (std::uint32_t i = 0; i < count; ++i) {
    if (numbers[i] == -1) continue;
    if (numbers[i] < -1 || numbers[i] > std::numeric_limits<std::int32_t>::max()) {
      fail(impl_->matches_path, path,
           "row " + std::to_string(i) + " is " + std::to_string(numbers[i]) +
               ", which is no keypoint and not -1; match with at most " + std::to_string(kMaxShortRows) +
               " keypoints");
    }
    const auto other = static_cast<std::uint32_t>(numbers[i]);
    matches.rows.push_back(reverse ? KeypointPair{other, i} : KeypointPair{i, other});
    if (scores.empty()) continue;
    matches.probability.push_back(scores[i]);
    probabilities = probabilities && scores[i] >= 0 && scores[i] <= 1;
    useful = useful || scores[i] > 0;
  }
  if (!probabilities || !useful) matches.probability.clear();
  return matches;
}

std::vector<ImagePairKey> HlocStore::verifiedPairs(const std::string& configuration) const {
  return impl_->journal ? impl_->journal->verifiedPairs(configuration) : std::vector<ImagePairKey>{};
}

VerifiedPair HlocStore::verified(const ImagePairKey& pair) const {
  if (impl_->journal) return impl_->journal->verified(pair);
  fail(impl_->matches_path, impl_->group(pair, kLayouts[0]), "is not verified");
}

void HlocStore::write(const std::vector<VerifiedPair>& pairs, const std::string& configuration) {
  if (!impl_->journal) {
    throw StoreError(StoreError::Kind::kStorage,
                     impl_->matches_path.string() + " is only read; give a name for the output");
  }
  impl_->journal->write(pairs, configuration);
}

void HlocStore::complete(const std::string& configuration) {
  const fs::path path = extended(impl_->output, ".part.h5");
  try {
    impl_->writeOutput(path, configuration);
    fs::rename(path, impl_->output);
  } catch (const fs::filesystem_error& error) {
    throw StoreError(StoreError::Kind::kStorage, impl_->output.string() + " cannot be written (" +
                                                     error.code().message() + "); the results are in " +
                                                     extended(impl_->output, ".part").string());
  }
  impl_->journal->remove();
  impl_->journal.reset();
}

const std::vector<std::string>& HlocStore::warnings() const { return impl_->warnings; }

}  // namespace corrsel::core
