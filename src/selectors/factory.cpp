#include "corrsel/selectors/factory.h"

#include <stdexcept>

#include "corrsel/selectors/gms.h"
#include "corrsel/selectors/gtm.h"
#include "corrsel/selectors/keep_all.h"
#include "corrsel/selectors/lpm.h"
#include "corrsel/selectors/nnsr.h"
#include "corrsel/selectors/ransac.h"
#include "corrsel/selectors/st.h"
#include "corrsel/selectors/usac.h"
#include "corrsel/selectors/vfc.h"
#include "corrsel/text.h"

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

const Entry& find(const std::string& name) {
  for (const Entry& candidate : entries()) {
    if (candidate.name == name) return candidate;
  }
  throw std::invalid_argument("unknown selector '" + name + "'; valid: " + joinList(selectorNames()));
}

}  // namespace

std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options,
                                         const OptionMap& common) {
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
  for (const auto& preset : find(name).presets) presets.push_back(preset.first);
  return presets;
}

}  // namespace corrsel::core
