#include "corrsel/selectors/factory.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "corrsel/selectors/acransac.h"
#include "corrsel/selectors/adalam.h"
#include "corrsel/selectors/auto.h"
#include "corrsel/selectors/gms.h"
#include "corrsel/selectors/gtm.h"
#include "corrsel/selectors/keep_all.h"
#include "corrsel/selectors/laf.h"
#include "corrsel/selectors/lpm.h"
#include "corrsel/selectors/nnsr.h"
#include "corrsel/selectors/planes.h"
#include "corrsel/selectors/pose.h"
#include "corrsel/selectors/ransac.h"
#include "corrsel/selectors/significant.h"
#include "corrsel/selectors/st.h"
#include "corrsel/selectors/usac.h"
#include "corrsel/selectors/vfc.h"

namespace corrsel::core {
namespace {

/// Options that take the same values.
MainParameter sweep(const std::vector<std::string>& options, const std::vector<double>& values) {
  MainParameter parameter;
  for (const std::string& option : options) parameter.emplace_back(option, values);
  return parameter;
}

/// The one place where a selector of this library is announced: one line each, group by group.
std::vector<SelectorFactory> ownSelectors() {
  constexpr SelectorGroup kPaper = SelectorGroup::kPaper, kConsensus = SelectorGroup::kConsensus,
                          kLocal = SelectorGroup::kLocal, kMultiStructure = SelectorGroup::kMultiStructure,
                          kAutomatic = SelectorGroup::kAutomatic, kBaseline = SelectorGroup::kBaseline;
  const std::vector<double> thresholds = {1, 1.5, 2, 3, 5, 7, 10, 15, 20};  // px
  return {
      SelectorFactory::of<NnsrSelector>(
          kPaper, "N", "Ratio of descriptor distances, threshold by Otsu",
          sweep({"min_threshold", "max_threshold"}, {0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95})),
      SelectorFactory::of<RansacSelector>(kPaper, "N",
                                          "Random sample consensus, homography or fundamental matrix",
                                          sweep({"threshold"}, thresholds)),
      SelectorFactory::of<StSelector>(kPaper, "N^2", "Spectral technique",
                                      sweep({"threshold"}, {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8})),
      SelectorFactory::of<GtmSelector>(
          kPaper, "N^2", "Game-theoretic matching; needs local affine frames",
          sweep({"lambda"}, {1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01})),
      SelectorFactory::of<UsacSelector>(kPaper, "N", "Universal framework for random sample consensus",
                                        sweep({"threshold"}, thresholds)),
      SelectorFactory::of<VfcSelector>(
          kPaper, "N log N", "Vector field consensus",
          sweep({"threshold"}, {0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.999})),
      SelectorFactory::of<GmsSelector>(kPaper, "N", "Grid-based motion statistics",
                                       sweep({"alpha"}, {1, 1.5, 2, 3, 4, 6, 8, 11, 16})),
      // With 4 neighbours, costs are 0, 2, 4, 6 and 8.
      SelectorFactory::of<LpmSelector>(kPaper, "N log N", "Locality preserving matching",
                                       sweep({"lambda_first", "lambda_second"}, {0, 2, 4, 6, 8})),
      SelectorFactory::of<AcransacSelector>(kConsensus, "N log N",
                                            "A contrario random sample consensus, without a threshold",
                                            sweep({"min_threshold"}, thresholds)),
      SelectorFactory::of<PoseSelector>(kConsensus, "N",
                                        "Relative pose of calibrated cameras; needs both cameras",
                                        sweep({"threshold"}, {0.25, 0.5, 0.75, 1, 1.5, 2, 3, 5, 10})),
      SelectorFactory::of<AdalamSelector>(kLocal, "N",
                                          "Adaptive locally-affine matching; uses local affine frames",
                                          sweep({"confidence"}, {2, 5, 20, 50, 100, 200, 500, 2000, 10000})),
      SelectorFactory::of<LafSelector>(kLocal, "N", "Linear adaptive filtering",
                                       sweep({"accept"}, {0.5, 0.55, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99})),
      SelectorFactory::of<SignificantSelector>(kLocal, "N log N",
                                               "Neighbours that agree more often than by chance",
                                               sweep({"cut"}, {-32, -16, -8, -4, -2, -1, 0, 1, 2})),
      SelectorFactory::of<PlanesSelector>(kMultiStructure, "N log N",
                                          "Planes one after another, each found by its significance",
                                          sweep({"min_threshold"}, {1, 1.5, 2, 3, 4, 5, 7, 10, 15})),
      SelectorFactory::of<AutoSelector>(
          kAutomatic, "N", "Finds out by itself what kind of scene it has",
          {{"threshold", thresholds}, {"fundamental_threshold", {0.3, 0.45, 0.6, 0.9, 1.5, 2.1, 3, 4.5, 6}}}),
      SelectorFactory::of<KeepAllSelector>(kBaseline, "N", "Selects every match: the baseline"),
  };
}

/// The selectors that have a short name, for all threads. Never destroyed, because a thread may outlive
/// `main`.
class KnownSelectors {
 public:
  static KnownSelectors& instance() {
    static KnownSelectors& known = *new KnownSelectors;
    return known;
  }

  std::vector<SelectorFactory> list() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return selectors_;
  }

  void add(const std::vector<SelectorFactory>& selectors) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<SelectorFactory> all = selectors_;
    for (const SelectorFactory& selector : selectors) {
      const auto same = [&selector](const SelectorFactory& other) { return other.name() == selector.name(); };
      if (selector.name().empty() || isPluginName(selector.name()) ||
          std::any_of(all.begin(), all.end(), same)) {
        throw std::invalid_argument(
            "selector '" + selector.name() +
            "' cannot be added: a name must be new, and neither empty nor package/Class");
      }
      const auto later = [&selector](const SelectorFactory& other) {
        return other.group() > selector.group();
      };
      all.insert(std::find_if(all.begin(), all.end(), later), selector);
    }
    selectors_ = std::move(all);
  }

 private:
  mutable std::mutex mutex_;
  std::vector<SelectorFactory> selectors_ = ownSelectors();
};

/// Names of the library corrsel::reference, which this one does not depend on.
constexpr const char* kReferenceNames[] = {"lap",         "ranks",  "rfm_scan", "logos",
                                           "frame_votes", "gaim",   "rrwm",     "multigs",
                                           "pnapsac",     "mlesac", "icf",      "tlinkage"};

struct LoaderSlot {
  std::mutex mutex;
  SelectorLoader loader;
};

/// Never destroyed, because the loader's code may be unloaded before this library.
LoaderSlot& loaderSlot() {
  static LoaderSlot& slot = *new LoaderSlot;
  return slot;
}

SelectorLoader selectorLoader() {
  LoaderSlot& slot = loaderSlot();
  const std::lock_guard<std::mutex> lock(slot.mutex);
  return slot.loader;
}

/// The text, preceded by the name of the selector if it does not name it already.
std::string withName(const std::string& name, const std::string& text) {
  const auto part_of_word = [&text](std::size_t at) {
    return at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) || text[at] == '_');
  };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    if ((at == 0 || !part_of_word(at - 1)) && !part_of_word(at + name.size())) return text;
  }
  return name + ": " + text;
}

/// Runs a function that may run code of another package, and makes every exception one that names the
/// selector.
template <class Function>
auto naming(const std::string& name, const Function& function) {
  try {
    return function();
  } catch (const std::exception& error) {
    throw std::invalid_argument(withName(name, error.what()));
  } catch (...) {
    throw std::invalid_argument(name + ": its class threw something that is not a std::exception");
  }
}

/// Common values that the selector knows, then the preset, then the options: what comes later wins.
OptionMap mergedOptions(const Selector& selector, const std::string& name, const OptionMap& preset,
                        const OptionMap& options, const OptionMap& common) {
  OptionMap values = options;
  values.insert(preset.begin(), preset.end());
  std::vector<std::string> known;
  for (const OptionField& field : optionFields(selector.options())) {
    known.push_back(field.name);
    const auto offered = common.find(field.name);
    if (offered != common.end()) values.insert(*offered);
  }
  for (const auto& [option, value] : values) {
    if (std::find(known.begin(), known.end(), option) == known.end()) {
      throw std::invalid_argument("unknown option " + name + "." + option + validNames(option, known));
    }
  }
  return values;
}

std::vector<std::string> namesOf(const Presets& presets) {
  std::vector<std::string> names;
  for (const auto& preset : presets) names.push_back(preset.first);
  return names;
}

}  // namespace

std::string toString(SelectorGroup group) {
  switch (group) {
    case SelectorGroup::kPaper:
      return "paper";
    case SelectorGroup::kConsensus:
      return "consensus";
    case SelectorGroup::kLocal:
      return "local";
    case SelectorGroup::kMultiStructure:
      return "multi-structure";
    case SelectorGroup::kAutomatic:
      return "automatic";
    case SelectorGroup::kReference:
      return "reference";
    case SelectorGroup::kBaseline:
      return "baseline";
    default:
      return "other packages";
  }
}

std::string meaningOf(SelectorGroup group) {
  switch (group) {
    case SelectorGroup::kPaper:
      return "the eight that Zhao et al. compare";
    case SelectorGroup::kConsensus:
      return "the model with the best support, found by random samples";
    case SelectorGroup::kLocal:
      return "neighbouring matches agree with each other";
    case SelectorGroup::kMultiStructure:
      return "several models in one pair of images";
    case SelectorGroup::kAutomatic:
      return "the method follows from the matches";
    case SelectorGroup::kReference:
      return "further published methods, for comparison; in the library corrsel::reference";
    case SelectorGroup::kBaseline:
      return "what every selector is compared with";
    default:
      return "loaded at run time";
  }
}

SelectorFactory::SelectorFactory(std::string name, SelectorGroup group, std::string cost, std::string meaning,
                                 Make make, MainParameter parameter)
    : name_(std::move(name)),
      group_(group),
      cost_(std::move(cost)),
      meaning_(std::move(meaning)),
      make_(std::move(make)),
      parameter_(std::move(parameter)) {}

std::unique_ptr<Selector> SelectorFactory::make() const {
  std::unique_ptr<Selector> selector = make_();
  if (!selector) throw std::invalid_argument("selector '" + name_ + "' could not be made");
  return selector;
}

Presets SelectorFactory::presets() const {
  return naming(name_, [this] { return make()->presets(); });
}

std::unique_ptr<Selector> SelectorFactory::create(const std::optional<std::string>& preset,
                                                  const OptionMap& options, const OptionMap& common) const {
  return naming(name_, [&] {
    std::unique_ptr<Selector> selector = make();
    const Presets presets = selector->presets();
    OptionMap preset_options;
    if (preset) {
      const auto found = std::find_if(presets.begin(), presets.end(), [&preset](const auto& candidate) {
        return candidate.first == *preset;
      });
      if (found == presets.end()) {
        throw std::invalid_argument("unknown preset '" + *preset + "' of selector " + name_ +
                                    validNames(*preset, namesOf(presets)));
      }
      preset_options = found->second;
    }
    selector->configure(mergedOptions(*selector, name_, preset_options, options, common));
    selector->options().check();
    return selector;
  });
}

std::vector<SelectorFactory> builtInSelectors() { return KnownSelectors::instance().list(); }

void addSelectors(const std::vector<SelectorFactory>& selectors) {
  KnownSelectors::instance().add(selectors);
}

SelectorFactory findSelector(const std::string& name) {
  for (const SelectorFactory& candidate : builtInSelectors()) {
    if (candidate.name() == name) return candidate;
  }
  const SelectorLoader load = selectorLoader();
  if (isReferenceName(name)) {
    const auto make = [load, name] { return load("corrsel/" + name); };
    if (load) return {name, SelectorGroup::kReference, "", "", make};
    throw std::invalid_argument(
        "selector '" + name +
        "' is in the library corrsel::reference, which this program does not have: link it and call "
        "corrsel::core::addReferenceSelectors(); valid without it: " +
        joinList(selectorNames()));
  }
  if (isPluginName(name)) {
    if (load) return {name, SelectorGroup::kOtherPackage, "", "", [load, name] { return load(name); }};
    throw std::invalid_argument(
        "selector '" + name +
        "' belongs to another package, and this program cannot load selectors of other "
        "packages; valid: " +
        joinList(selectorNames()));
  }
  throw std::invalid_argument("unknown selector '" + name + "'" + validNames(name, selectorNames()) +
                              (load ? ", package/Class of another package" : ""));
}

void setSelectorLoader(SelectorLoader loader) {
  LoaderSlot& slot = loaderSlot();
  const std::lock_guard<std::mutex> lock(slot.mutex);
  slot.loader.swap(loader);
}

bool isPluginName(const std::string& spec) { return spec.find('/') != std::string::npos; }

bool isReferenceName(const std::string& name) {
  return std::find(std::begin(kReferenceNames), std::end(kReferenceNames), name) != std::end(kReferenceNames);
}

std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options,
                                         const OptionMap& common) {
  const SelectorSpec parts = SelectorSpec::fromText(spec);
  if (parts.options.empty()) return findSelector(parts.name).create(parts.preset, options, common);
  OptionMap values = parts.options;
  values.insert(options.begin(), options.end());
  try {
    return findSelector(parts.name).create(parts.preset, values, common);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("selector '" + spec + "': " + error.what());
  }
}

std::vector<std::string> selectorNames() {
  std::vector<std::string> names;
  for (const SelectorFactory& selector : builtInSelectors()) names.push_back(selector.name());
  return names;
}

std::vector<std::string> usualSelectorNames() {
  std::vector<std::string> names;
  for (const SelectorFactory& selector : builtInSelectors()) {
    const bool usual = selector.group() == SelectorGroup::kPaper ||
                       selector.group() == SelectorGroup::kBaseline ||
                       selector.group() == SelectorGroup::kAutomatic;
    if (usual) names.push_back(selector.name());
  }
  return names;
}

std::vector<std::string> neededInput(const Selector& selector) {
  const AffineFrame frame = {1, 0, 0, 0, 1, 0};
  Correspondences complete;
  complete.add({0, 0}, {0, 0});
  complete.distance = complete.second_distance = complete.probability = {1};
  complete.left_frame = complete.right_frame = {frame};
  complete.left_index = complete.right_index = {0};
  complete.left_size = complete.right_size = {1, 1};
  complete.left_camera = complete.right_camera = Camera();
  using Remove = void (*)(Correspondences&);
  static constexpr std::pair<const char*, Remove> kOptional[] = {
      {"left_size", [](Correspondences& m) { m.left_size = {}; }},
      {"right_size", [](Correspondences& m) { m.right_size = {}; }},
      {"distance", [](Correspondences& m) { m.distance.clear(); }},
      {"second_distance", [](Correspondences& m) { m.second_distance.clear(); }},
      {"probability", [](Correspondences& m) { m.probability.clear(); }},
      {"left_frame", [](Correspondences& m) { m.left_frame.clear(); }},
      {"right_frame", [](Correspondences& m) { m.right_frame.clear(); }},
      {"left_camera", [](Correspondences& m) { m.left_camera.reset(); }},
      {"right_camera", [](Correspondences& m) { m.right_camera.reset(); }},
      {"left_index", [](Correspondences& m) { m.left_index.clear(); }},
      {"right_index", [](Correspondences& m) { m.right_index.clear(); }}};
  std::vector<std::string> needed;
  for (const auto& [name, remove] : kOptional) {
    Correspondences matches = complete;
    remove(matches);
    if (selector.select(matches).status == Status::kUnsupportedInput) needed.emplace_back(name);
  }
  return needed;
}

std::vector<std::string> selectorPresets(const std::string& name) {
  return namesOf(findSelector(name).presets());
}

}  // namespace corrsel::core
