#include "datasets/unrelated.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "corrsel/random.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMaxPairs = 120;
constexpr std::size_t kSharedLetters = 3;

/// A sequence, and its pairs.
struct Sequence {
  std::string name;
  std::vector<std::size_t> pairs;
};

std::vector<Sequence> sequencesOf(const DatasetReader& scenes) {
  std::vector<Sequence> sequences;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string name = scenes.id(i).sequence;
    const auto found = std::find_if(sequences.begin(), sequences.end(),
                                    [&name](const Sequence& sequence) { return sequence.name == name; });
    if (found == sequences.end()) {
      sequences.push_back({name, {i}});
    } else {
      found->pairs.push_back(i);
    }
  }
  return sequences;
}

/// Number of characters with which all names begin.
std::size_t commonBeginning(const std::vector<Sequence>& sequences) {
  std::size_t common = sequences.empty() ? 0 : sequences.front().name.size();
  for (const Sequence& sequence : sequences) {
    const std::string &first = sequences.front().name, &name = sequence.name;
    const auto end = first.begin() + static_cast<std::ptrdiff_t>(std::min(common, name.size()));
    common = static_cast<std::size_t>(std::mismatch(first.begin(), end, name.begin()).first - first.begin());
  }
  return common;
}

bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

bool mayShowOnePlace(const std::string& a, const std::string& b, std::size_t common) {
  if (a == b) return true;
  const std::string first = lowerCase(a.substr(std::min(common, a.size())));
  const std::string second = lowerCase(b.substr(std::min(common, b.size())));
  for (std::size_t i = 0; i + kSharedLetters <= first.size(); ++i) {
    const std::string part = first.substr(i, kSharedLetters);
    if (std::all_of(part.begin(), part.end(), isLetter) && second.find(part) != std::string::npos)
      return true;
  }
  return false;
}

UnrelatedReader::UnrelatedReader(std::unique_ptr<DatasetReader> scenes, int seed)
    : scenes_(std::move(scenes)) {
  const std::vector<Sequence> sequences = sequencesOf(*scenes_);
  const std::size_t common = commonBeginning(sequences);
  struct Choice {
    const Sequence* left;
    std::size_t right;
  };
  std::vector<Choice> choices;
  for (const Sequence& left : sequences) {
    for (const Sequence& right : sequences) {
      if (mayShowOnePlace(left.name, right.name, common)) continue;
      for (const std::size_t pair : right.pairs) choices.push_back({&left, pair});
    }
  }
  if (choices.empty()) {
    const std::string name = scenes_->size() > 0 ? scenes_->id(0).dataset : "";
    throw DatasetError("dataset '" + name + "' has no two sequences that show different places (it has " +
                       std::to_string(sequences.size()) +
                       "; names that share three letters in a row may show the same one); rename its "
                       "sequences, or take another dataset for unrelated pairs");
  }
  Random random(static_cast<std::uint64_t>(seed));
  const std::size_t drawn = std::min(kMaxPairs, choices.size());
  for (std::size_t i = 0; i < drawn; ++i) {
    std::swap(choices[i], choices[i + random.index(static_cast<std::uint32_t>(choices.size() - i))]);
    const std::vector<std::size_t>& lefts = choices[i].left->pairs;
    pairs_.push_back({lefts[random.index(static_cast<std::uint32_t>(lefts.size()))], choices[i].right});
  }
}

PairId UnrelatedReader::id(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  const PairId left = scenes_->id(pair.left), right = scenes_->id(pair.right);
  return {kUnrelatedPrefix + left.dataset, left.sequence + "+" + right.sequence,
          left.pair + "+" + right.pair};
}

ImagePair UnrelatedReader::read(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  ImagePair result;
  result.id = id(index);
  const ImagePair left = scenes_->read(pair.left), right = scenes_->read(pair.right);
  result.left = left.left;
  result.right = right.right;
  result.left_name = left.left_name;
  result.right_name = right.right_name;
  result.left_camera = left.left_camera;
  result.right_camera = right.right_camera;
  result.stretched = left.stretched ? left.stretched : right.stretched;
  for (const auto& [image, scene] :
       {std::pair(&result.left, pair.left), std::pair(&result.right, pair.right)}) {
    if (image->empty()) {
      throw DatasetError(scenes_->id(scene).text() +
                         " has no images, and matches alone make no pair of different scenes");
    }
  }
  return result;
}

void UnrelatedReader::check(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  scenes_->check(pair.left);
  scenes_->check(pair.right);
}

}  // namespace corrsel::core
