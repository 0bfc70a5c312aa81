#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include "corrsel/confidence.h"
#include "corrsel/correspondences.h"
#include "corrsel/options.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/presets.h"
#include "corrsel/workspace.h"

namespace corrsel {
namespace core {

/// Decides which putative matches are correct.
///
/// Contract:
///  - select() is const and re-entrant and keeps no state. The same options and the same input give the same
///    result, bit for bit, on any thread.
///  - select() never throws on data. For any input, the mask has the length of the input, and status and
///    message give the reason for an unusual result.
///  - Rows whose coordinates are NaN, infinite or beyond 1e6 px are removed before the algorithm runs. They
///    never influence the other rows, and their mask is 0.
///  - Options out of range cause std::invalid_argument, which names the option, its value and its range.
///
/// To write a selector, derive from SelectorWithOptions and implement name() and run(). Override
/// missingInput() if the algorithm needs a column beyond the coordinates, and presets() if it has named sets
/// of option values. A selector is made by its default constructor and then given its options by configure().
/// docs/adding_selectors.md describes the steps, for this library and for other packages.
class Selector {
 public:
  virtual ~Selector() = default;

  /// @return the mask (as long as `matches`), status, counts, wall time. Cost: see the algorithm's header.
  Selection select(const Correspondences& matches) const;

  /// Same result; memory that is kept between calls belongs to `workspace` and not to the calling thread.
  Selection select(const Correspondences& matches, Workspace& workspace) const;

  /// Lower-case name as in the factory, without preset; "package/Class" of a selector of another package.
  virtual std::string name() const = 0;

  /// The options in force.
  virtual const OptionSet& options() const = 0;

  /// Named sets of option values, applied on top of the defaults.
  virtual Presets presets() const { return {}; }

  /// Sets options. The factory calls it once, after construction, with the values from the preset and from
  /// the user and with those common values (seed, model, max_seconds...) whose names are in options(). Throws
  /// std::invalid_argument; unless overridden, for every option.
  virtual void configure(const OptionMap& options);

 protected:
  /// A sentence that names a missing column or image size, or an empty text if nothing is missing.
  virtual std::string missingInput(const Correspondences& matches) const;

  /// Confidence below which the status `ok` becomes `uncertain`; 0 = never. Above 0, select() computes the
  /// confidence as addConfidence() does, unless run() has set it.
  virtual double minConfidence() const { return 0.0; }

  /// The algorithm. `matches` holds finite coordinates only; `result.n_ignored` receives the number of others
  /// that the algorithm cannot use, for example because they have no ray. `result.mask` has the length of the
  /// input and is zero. Memory that should last until the next call is a part of the workspace, see
  /// Workspace::part().
  virtual void run(const Correspondences& matches, Workspace& workspace, Selection& result) const = 0;
};

/// Computes the confidence of a selection, by the same definition for every selector (docs/selectors.md).
/// A selector computes it by itself only where its decision needs it: where `min_confidence` is above 0, or
/// inside its algorithm. The others leave it NaN, because it takes longer than a fast selector
/// (docs/selectors.md has the times).
/// A confidence that the selection has already is kept. It stays NaN where the status is `failed` or
/// `unsupported_input`.
/// @param matches    those that the selector was given
/// @param selection  of select(), for these matches
/// Does nothing where the selection is not of these matches or their columns are inconsistent. O(N log N).
void addConfidence(const Correspondences& matches, Selection& selection);

/// Computes the noise of a selection's model and the probability that each match is right, by the same
/// definition for every selector (docs/selectors.md). `auto` computes them by itself; the others leave them
/// to this function, because it takes longer than a fast selector (docs/selectors.md has the times). It also
/// computes the confidence, as addConfidence() does. A probability that the selection has already is kept. It
/// stays empty where the status is `failed` or `unsupported_input`.
/// @param matches    those that the selector was given
/// @param selection  of select(), for these matches
/// Does nothing where the selection is not of these matches or their columns are inconsistent. O(N log N).
void addProbability(const Correspondences& matches, Selection& selection);

/// Base of selectors with options: it stores and checks them.
/// @tparam Options  an option struct, or NoOptions; derived from ConfidenceOptions if it has min_confidence
template <class Options>
class SelectorWithOptions : public Selector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit SelectorWithOptions(Options options = {}) : options_(std::move(options)) { options_.check(); }

  const OptionSet& options() const override { return options_; }

  /// Throws std::invalid_argument for an unknown name or a value out of range, and then changes nothing.
  void configure(const OptionMap& options) override {
    Options changed = options_;
    setOptions(changed, options, name());
    changed.check();
    options_ = std::move(changed);
  }

 protected:
  double minConfidence() const override {
    if constexpr (std::is_base_of_v<ConfidenceOptions, Options>) return options_.min_confidence;
    return 0.0;
  }

  Options options_;
};

}  // namespace core

// The names from which selectors of other packages derive.
using core::Selector;
using core::SelectorWithOptions;

}  // namespace corrsel
