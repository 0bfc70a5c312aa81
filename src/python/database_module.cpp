// The Python module corrsel._database: verification of whole databases. Documentation for users is in the
// Python package, which wraps it.

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <exception>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "corrsel/database/colmap_store.h"
#include "corrsel/database/hloc_store.h"
#include "corrsel/database/pair_verifier.h"
#include "corrsel/database/verification.h"
#include "python/arrays.h"

namespace corrsel::python {
namespace {

using core::ColmapStore;
using core::ImagePairKey;
using Names = std::vector<std::pair<std::string, std::string>>;

/// Busy files become BlockingIOError, and files that cannot be used OSError or ValueError.
void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const core::StoreError& error) {
    switch (error.kind()) {
      case core::StoreError::Kind::kBusy:
        PyErr_SetString(PyExc_BlockingIOError, error.what());
        return;
      case core::StoreError::Kind::kStorage:
        PyErr_SetString(PyExc_OSError, error.what());
        return;
      case core::StoreError::Kind::kContent:
        PyErr_SetString(PyExc_ValueError, error.what());
        return;
    }
  }
}

core::PairVerifier verifierOf(const core::OptionMap& values) {
  core::PairVerifierOptions options;
  core::setOptions(options, values, "verification");
  return core::PairVerifier(options);
}

core::VerificationOptions runOptions(const py::dict& values) {
  core::VerificationOptions options;
  options.threads = values["threads"].cast<int>();
  options.again = values["again"].cast<bool>();
  options.strict = values["strict"].cast<bool>();
  options.dry_run = values["dry_run"].cast<bool>();
  options.memory_gib = values["memory"].cast<double>();
  return options;
}

/// The numbers of images by their names.
std::vector<ImagePairKey> keysOf(const Names& names, const std::vector<core::StoredImage>& images) {
  std::unordered_map<std::string, std::uint32_t> numbers;
  for (const core::StoredImage& image : images) numbers.emplace(image.name, image.id);
  const auto number = [&](const std::string& name) {
    const auto found = numbers.find(name);
    if (found != numbers.end()) return found->second;
    throw std::invalid_argument("pairs: the database has no image '" + name + "'");
  };
  std::vector<ImagePairKey> keys;
  for (const auto& [first, second] : names) {
    const std::uint32_t a = number(first), b = number(second);
    if (a == b) throw std::invalid_argument("pairs: '" + first + "' is paired with itself");
    keys.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

/// Calls a Python function from a run that has released the lock of the interpreter. What the function
/// raises, and Ctrl-C, end the run at the next pair.
class ProgressCall {
 public:
  explicit ProgressCall(const py::object& function) : function_(function) {}

  void operator()(const core::VerificationProgress& progress) {
    const py::gil_scoped_acquire acquired;
    if (raised_) return;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!function_.is_none()) function_(progress.done, progress.total, progress.accepted, progress.seconds);
    } catch (py::error_already_set&) {
      raised_ = std::current_exception();
      interrupt_ = true;
    }
  }

  const std::atomic<bool>* interrupt() const { return &interrupt_; }

  /// Raises what the function has raised. The lock of the interpreter must be held.
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  const py::object& function_;
  std::exception_ptr raised_;
  std::atomic<bool> interrupt_{false};
};

/// What is told of every pair, as columns.
struct Columns {
  void add(const core::VerifiedPair& pair) {
    images.push_back({pair.pair.first, pair.pair.second});
    putative.push_back(static_cast<std::uint32_t>(pair.putative));
    inliers.push_back(static_cast<std::uint32_t>(pair.geometry.inliers.size()));
    config.push_back(static_cast<std::uint8_t>(pair.geometry.config));
    status.push_back(static_cast<std::uint8_t>(pair.status));
    scene.push_back(static_cast<std::uint8_t>(pair.scene));
    confidence.push_back(pair.confidence);
    ambiguity.push_back(pair.ambiguity);
  }

  void writeTo(py::dict& result) {
    const auto rows = static_cast<py::ssize_t>(images.size());
    result["pairs"] = arrayFrom<std::uint32_t>(std::move(images), {rows, 2});
    result["putative"] = arrayFrom(std::move(putative));
    result["inliers"] = arrayFrom(std::move(inliers));
    result["config"] = arrayFrom(std::move(config));
    result["status"] = arrayFrom(std::move(status));
    result["scene"] = arrayFrom(std::move(scene));
    result["confidence"] = arrayFrom(std::move(confidence));
    result["ambiguity"] = arrayFrom(std::move(ambiguity));
  }

  std::vector<std::array<std::uint32_t, 2>> images;
  std::vector<std::uint32_t> putative, inliers;
  std::vector<std::uint8_t> config, status, scene;
  std::vector<double> confidence, ambiguity;
};

/// The files of a run.
struct Files {
  std::string path;          ///< a database of COLMAP, or the matches of hloc
  std::string features;      ///< of hloc; empty: a database
  std::string output;        ///< of hloc; empty: none
  bool keep_others = false;  ///< whether rows of other programs stay in the database
};

/// A run, and what it found.
class Verification {
 public:
  Verification(const Files& files, const core::OptionMap& verifier, const core::VerificationOptions& run)
      : verifier_(verifierOf(verifier)), options_(run), keep_others_(files.keep_others) {
    if (files.features.empty()) {
      database_.emplace(files.path, run.dry_run ? ColmapStore::Access::kRead : ColmapStore::Access::kWrite);
    } else {
      hloc_.emplace(files.features, files.path, files.output);
    }
  }

  /// @param names  the pairs; absent: all
  void run(const std::optional<Names>& names, ProgressCall& progress) {
    options_.pairs = names ? keysOf(*names, store().images()) : store().pairs();
    leaveOthers();
    // No pairs would mean all of them.
    if (!options_.pairs.empty()) {
      summary_ = core::verifyPairs(
          store(), verifier_, options_, [this](const core::VerifiedPair& pair) { note(pair); },
          [&](const core::VerificationProgress& state) { progress(state); }, progress.interrupt());
    }
    if (options_.dry_run) return;
    readStored();
    const bool complete = !summary_.interrupted && !(options_.strict && !faulty_.empty());
    if (hloc_ && complete) hloc_->complete(verifier_.configuration());
  }

  py::dict result() {
    py::dict result;
    columns_.writeTo(result);
    py::dict images;
    for (const core::StoredImage& image : store().images()) images[py::int_(image.id)] = image.name;
    result["images"] = images;
    result["faulty"] = faulty_;
    result["warnings"] = database_ ? database_->warnings() : hloc_->warnings();
    result["configuration"] = verifier_.configuration();
    result["verified"] = summary_.verified;
    result["skipped"] = summary_.skipped;
    result["of_others"] = of_others_;
    result["seconds"] = summary_.seconds;
    return result;
  }

 private:
  core::PairStore& store() {
    if (database_) return *database_;
    return *hloc_;
  }

  /// Takes out the pairs that other programs have verified, unless they are to be verified again.
  void leaveOthers() {
    if (!keep_others_ || !database_ || options_.again) return;
    const std::vector<ImagePairKey> others = database_->pairsOfOthers();
    std::vector<ImagePairKey> left;
    std::set_difference(options_.pairs.begin(), options_.pairs.end(), others.begin(), others.end(),
                        std::back_inserter(left));
    of_others_ = options_.pairs.size() - left.size();
    options_.pairs = std::move(left);
  }

  void note(const core::VerifiedPair& pair) {
    if (pair.faulty) {
      faulty_.emplace_back(pair.pair.first, pair.pair.second, pair.message);
    } else if (options_.dry_run) {
      columns_.add(pair);
    }
  }

  /// The results of this run and of earlier ones, so that a report does not depend on interruptions.
  void readStored() {
    const std::vector<ImagePairKey> stored = store().verifiedPairs(verifier_.configuration());
    for (const ImagePairKey& pair : options_.pairs) {
      if (std::binary_search(stored.begin(), stored.end(), pair)) columns_.add(store().verified(pair));
    }
  }

  std::optional<ColmapStore> database_;
  std::optional<core::HlocStore> hloc_;
  core::PairVerifier verifier_;
  core::VerificationOptions options_;
  bool keep_others_;
  std::size_t of_others_ = 0;
  core::VerificationSummary summary_;
  Columns columns_;
  std::vector<std::tuple<std::uint32_t, std::uint32_t, std::string>> faulty_;
};

/// @param files     path, features, output and keep_others, as in Files
/// @param progress  a function of done, total, accepted and seconds, or None
py::dict verify(const std::tuple<std::string, std::string, std::string, bool>& files,
                const core::OptionMap& verifier, const py::dict& run, const std::optional<Names>& names,
                const py::object& progress) {
  const core::VerificationOptions options = runOptions(run);
  ProgressCall call(progress);
  std::optional<Verification> verification;
  {
    const py::gil_scoped_release released;
    const auto& [path, features, output, keep_others] = files;
    verification.emplace(Files{path, features, output, keep_others}, verifier, options);
    verification->run(names, call);
  }
  call.rethrow();
  return verification->result();
}

void continueCopy(const std::string& from, const std::string& to) {
  const py::gil_scoped_release released;
  ColmapStore::continueCopy(from, to);
}

/// The names that belong to numbers in the columns config, status and scene.
template <class Value>
std::vector<std::string> namesOf(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back(toString(static_cast<Value>(i)));
  return names;
}

}  // namespace
}  // namespace corrsel::python

PYBIND11_MODULE(_database, module) {
  using namespace corrsel;
  using namespace corrsel::python;
  py::register_exception_translator(&translate);
  module.def("verify", &verify);
  module.def("continue_copy", &continueCopy);
  module.def("options", [] { return toDicts(core::PairVerifierOptions()); });
  module.attr("CONFIGS") = namesOf<core::TwoViewConfig>(9);
  module.attr("STATUSES") = namesOf<core::Status>(9);
  module.attr("SCENES") = namesOf<core::SceneKind>(6);
}
