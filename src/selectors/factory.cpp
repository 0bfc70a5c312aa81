#include "corrsel/selectors/factory.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "corrsel/selectors/gms.h"
#include "corrsel/selectors/gtm.h"
#include "corrsel/selectors/keep_all.h"
#include "corrsel/selectors/lpm.h"
#include "corrsel/selectors/nnsr.h"
#include "corrsel/selectors/ransac.h"
#include "corrsel/selectors/st.h"
#include "corrsel/selectors/usac.h"
#include "corrsel/selectors/vfc.h"

namespace corrsel::core {
namespace {

struct Entry {
  std::string name;
  Presets presets;
  std::unique_ptr<Selector> (*create)(const OptionMap& common, const OptionMap& preset,
                                      const OptionMap& options, const std::string& name);
};

template <class S, class O>
Entry entry(const std::string& name) {
  return {name, S::presets(),
          [](const OptionMap& common, const OptionMap& preset, const OptionMap& options,
             const std::string& context) {
            O values;
            setOptionsWherePresent(values, common, context);
            setOptions(values, preset, context);
            setOptions(values, options, context);
            try {
              return std::unique_ptr<Selector>(std::make_unique<S>(values));
            } catch (const std::invalid_argument& error) {
              throw std::invalid_argument(context + ": " + error.what());
            }
          }};
}

/// The one place where a selector is announced, in the paper's order.
const std::vector<Entry>& entries() {
  static const std::vector<Entry> table = {
      entry<NnsrSelector, NnsrOptions>("nnsr"),
      entry<RansacSelector, RansacOptions>("ransac"),
      entry<StSelector, StOptions>("st"),
      entry<GtmSelector, GtmOptions>("gtm"),
      entry<UsacSelector, UsacOptions>("usac"),
      entry<VfcSelector, VfcOptions>("vfc"),
      entry<GmsSelector, GmsOptions>("gms"),
      entry<LpmSelector, LpmOptions>("lpm"),
      entry<KeepAllSelector, KeepAllOptions>("keep_all"),
  };
  return table;
}

struct LoaderSlot {
  std::mutex mutex;
  SelectorLoader loader;
};

/// Never destroyed: the loader's code may be unloaded before this library is.
LoaderSlot& loaderSlot() {
  static LoaderSlot& slot = *new LoaderSlot;
  return slot;
}

SelectorLoader selectorLoader() {
  LoaderSlot& slot = loaderSlot();
  const std::lock_guard<std::mutex> lock(slot.mutex);
  return slot.loader;
}

const Entry& find(const std::string& name) {
  for (const Entry& candidate : entries()) {
    if (candidate.name == name) return candidate;
  }
  throw std::invalid_argument("unknown selector '" + name + "'; valid: " + joinList(selectorNames()) +
                              (selectorLoader() ? ", package/Class of another package" : ""));
}

/// The values for configure(): what the user gave, and those of the common values that the selector knows.
OptionMap pluginOptions(const Selector& selector, const std::string& name, const OptionMap& options,
                        const OptionMap& common) {
  OptionMap values = options;
  std::vector<std::string> known;
  for (const OptionText& option : listOptions(selector.options())) {
    known.push_back(option.name);
    const auto offered = common.find(option.name);
    if (offered != common.end()) values.insert(*offered);
  }
  for (const auto& [option, value] : options) {
    if (std::find(known.begin(), known.end(), option) == known.end()) {
      throw std::invalid_argument("unknown option " + name + "." + option +
                                  "; valid: " + (known.empty() ? "none" : joinList(known)));
    }
  }
  return values;
}

std::unique_ptr<Selector> createPlugin(const std::string& name, const OptionMap& options,
                                       const OptionMap& common) {
  if (name.find(':') != std::string::npos) {
    throw std::invalid_argument("selector '" + name +
                                "': selectors of other packages have no presets; give " +
                                name.substr(0, name.find(':')) + " and its options");
  }
  const SelectorLoader load = selectorLoader();
  if (!load) {
    throw std::invalid_argument(
        "selector '" + name +
        "' is of another package, and this program cannot load such; valid: " + joinList(selectorNames()));
  }
  std::unique_ptr<Selector> selector = load(name);
  if (!selector) throw std::invalid_argument("selector '" + name + "' could not be made");
  const OptionMap values = pluginOptions(*selector, name, options, common);
  selector->configure(values);
  selector->options().check();
  return selector;
}

std::string withName(const std::string& name, const std::string& text) {
  return text.find(name) == std::string::npos ? name + ": " + text : text;
}

}  // namespace

void setSelectorLoader(SelectorLoader loader) {
  LoaderSlot& slot = loaderSlot();
  const std::lock_guard<std::mutex> lock(slot.mutex);
  slot.loader.swap(loader);
}

bool isPluginName(const std::string& spec) { return spec.find('/') != std::string::npos; }

std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options,
                                         const OptionMap& common) {
  if (isPluginName(spec)) {
    try {
      return createPlugin(spec, options, common);
    } catch (const std::exception& error) {
      throw std::invalid_argument(withName(spec, error.what()));
    } catch (...) {
      throw std::invalid_argument(spec + ": its class threw something that is not a std::exception");
    }
  }
  const std::size_t colon = spec.find(':');
  const Entry& found = find(spec.substr(0, colon));
  if (colon == std::string::npos) return found.create(common, {}, options, found.name);
  const std::string preset = spec.substr(colon + 1);
  for (const auto& [name, values] : found.presets) {
    if (name == preset) return found.create(common, values, options, found.name);
  }
  const std::vector<std::string> valid = selectorPresets(found.name);
  throw std::invalid_argument("unknown preset '" + preset + "' of selector " + found.name +
                              "; valid: " + (valid.empty() ? "none" : joinList(valid)));
}

std::vector<std::string> selectorNames() {
  std::vector<std::string> names;
  for (const Entry& candidate : entries()) names.push_back(candidate.name);
  return names;
}

std::vector<std::string> selectorPresets(const std::string& name) {
  std::vector<std::string> presets;
  if (isPluginName(name)) return presets;
  for (const auto& preset : find(name).presets) presets.push_back(preset.first);
  return presets;
}

}  // namespace corrsel::core
