#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/options.h"
#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/selectors/selector_spec.h"

namespace corrsel::core {

/// The heading under which listings and documentation show a selector. The order is that of the listings.
enum class SelectorGroup : std::uint8_t {
  kPaper,           ///< the eight of Zhao et al., arXiv:1904.13383
  kConsensus,       ///< the model with the best support, found by random samples
  kLocal,           ///< neighbouring matches agree with each other
  kMultiStructure,  ///< several models in one pair of images
  kAutomatic,       ///< the method follows from the matches
  kReference,    ///< further published methods, for comparison; see corrsel/reference/reference_selectors.h
  kBaseline,     ///< what every selector is compared with
  kOtherPackage  ///< loaded at run time, "package/Class"
};

/// "paper", "consensus", "local", "multi-structure", "automatic", "reference", "baseline", "other packages".
std::string toString(SelectorGroup group);

/// A few words on what the selectors of a group have in common, for listings.
std::string meaningOf(SelectorGroup group);

/// What trades a selector's precision against its recall, and the values at which operating curves are
/// measured: options that change together, all with the same number of values. Empty: the selector has none.
using MainParameter = std::vector<std::pair<std::string, std::vector<double>>>;

/// Makes the selectors of one class, linked or from another package: its name, group, presets and options,
/// and instances of it. Copyable; its functions may be called from any thread.
class SelectorFactory {
 public:
  /// Makes an instance with default options.
  using Make = std::function<std::unique_ptr<Selector>()>;

  /// @param cost     growth of the time with the number of matches N, e.g. "N log N"; empty if unknown
  /// @param meaning  a few words for lists, e.g. "Grid-based motion statistics"
  /// @param parameter  of operating curves, with ascending values
  SelectorFactory(std::string name, SelectorGroup group, std::string cost, std::string meaning, Make make,
                  MainParameter parameter = {});

  /// The factory of a selector class S of this process, under the name that an instance returns. The
  /// parameters are those of the constructor.
  template <class S>
  static SelectorFactory of(SelectorGroup group, std::string cost, std::string meaning,
                            MainParameter parameter = {}) {
    return {
        S().name(),          group, std::move(cost), std::move(meaning), [] { return std::make_unique<S>(); },
        std::move(parameter)};
  }

  /// As in createSelector(), without preset.
  const std::string& name() const { return name_; }
  SelectorGroup group() const { return group_; }
  const std::string& cost() const { return cost_; }
  const std::string& meaning() const { return meaning_; }
  const MainParameter& mainParameter() const { return parameter_; }

  /// Presets beside the default; may be empty. Throws what create() throws.
  Presets presets() const;

  /// @param preset   name of a preset; none = the defaults
  /// @param options  on top of the preset; unknown names are an error
  /// @param common   values that are offered to every selector (seed, model, max_seconds...). Names that the
  ///                 selector does not have are skipped. They are weaker than the preset and the options.
  /// Throws std::invalid_argument naming the selector: unknown preset or option (listing the valid ones),
  /// option out of range, or whatever the constructor of a class of another package threw.
  std::unique_ptr<Selector> create(const std::optional<std::string>& preset = {},
                                   const OptionMap& options = {}, const OptionMap& common = {}) const;

 private:
  std::unique_ptr<Selector> make() const;

  std::string name_;
  SelectorGroup group_;
  std::string cost_;
  std::string meaning_;
  Make make_;
  MainParameter parameter_;
};

/// The selectors that the program has under a short name: those of this library and those of addSelectors(),
/// in the order of listings: group by group, those of the paper in its order. The pseudo-selector keep_all,
/// the baseline, comes last. May be called from any thread.
std::vector<SelectorFactory> builtInSelectors();

/// Adds selectors to builtInSelectors(), for the whole process; each one follows those of its group that are
/// there. May be called from any thread. Throws std::invalid_argument for a name that is taken, empty, or of
/// the form "package/Class", and then adds none.
void addSelectors(const std::vector<SelectorFactory>& selectors);

/// Finds one of builtInSelectors(), or one of another package through the loader. A name of the library
/// corrsel::reference that has not been added is asked of the loader as "corrsel/NAME". Throws
/// std::invalid_argument for an unknown name, listing the valid ones.
SelectorFactory findSelector(const std::string& name);

/// Makes a selector of another package from the name of its class, with default options. Throws if it cannot.
using SelectorLoader = std::function<std::unique_ptr<Selector>(const std::string& class_name)>;

/// Sets the loader for names of the form "package/Class", for the whole process; an empty loader removes it.
/// May be called from any thread.
void setSelectorLoader(SelectorLoader loader);

/// Creates a selector from the text of a SelectorSpec, e.g. "gms", "lpm:v2", "package/Class:preset",
/// "usac[max_seconds=0.01]". Options in the brackets win over `options`. Other parameters and errors are
/// those of findSelector() and SelectorFactory::create(); where the text has brackets, the error names it.
std::unique_ptr<Selector> createSelector(const std::string& spec, const OptionMap& options = {},
                                         const OptionMap& common = {});

/// Names of builtInSelectors().
std::vector<std::string> selectorNames();

/// The selectors that the name "all" stands for: those of the paper, `auto` and the baseline.
std::vector<std::string> usualSelectorNames();

/// Whether the name is that of a selector of another package: "package/Class".
bool isPluginName(const std::string& spec);

/// Whether the name, without preset, is that of a selector of the library corrsel::reference.
bool isReferenceName(const std::string& name);

/// Names of the members of Correspondences beside the coordinates, e.g. "left_frame" or "right_size", without
/// which the selector returns `unsupported_input`. It is found out by selections of one match each, in
/// microseconds.
std::vector<std::string> neededInput(const Selector& selector);

/// Names of the presets of findSelector(name).
std::vector<std::string> selectorPresets(const std::string& name);

}  // namespace corrsel::core
