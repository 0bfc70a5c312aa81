#pragma once

#include <string>

#include "corrsel/correspondences.h"
#include "corrsel/options.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"

namespace corrsel {
namespace core {

/// Decides which putative matches are correct.
///
/// Contract:
///  - select() is const and re-entrant and keeps no state: same options, same input, same answer, on any
///  thread.
///  - select() never throws on data. Whatever comes in, the mask has the length of the input and the status
///  says
///    why it looks as it does. Rows with NaN, infinite or absurd (beyond 1e6 px) coordinates are set aside
///    before the algorithm sees them, never influence the others, and are answered with 0.
///  - Constructors throw std::invalid_argument for options out of range, naming option, value and range.
///
/// To write one: derive, implement name(), options() and run(), and override missingInput() if a column
/// beyond the coordinates is needed. Those of other packages are made by their default constructor and given
/// their options by configure(): see docs/selectors.md.
class Selector {
 public:
  virtual ~Selector() = default;

  /// @return the mask (as long as `matches`), status, counts, wall time. Cost: see the algorithm's header.
  Selection select(const Correspondences& matches) const;

  /// Same result; memory that is kept between calls belongs to `workspace` and not to the calling thread.
  Selection select(const Correspondences& matches, Workspace& workspace) const;

  /// Lower-case name as in the factory, without preset; "package/Class" of a selector of another package.
  virtual std::string name() const = 0;

  virtual const OptionSet& options() const = 0;

  /// Takes over the options of a selector of another package: called once, after its construction and before
  /// anything but options(), with the values that the user gave and those common ones (seed, threads...)
  /// whose names are in options(). Override it where there are options: setOptions() and check() do the work.
  /// Throws std::invalid_argument; unless overridden for every option.
  virtual void configure(const OptionMap& options);

 protected:
  /// A sentence naming the missing column or image size, or empty when the input will do.
  virtual std::string missingInput(const Correspondences& matches) const;

  /// The algorithm. `matches` holds finite coordinates only; `result.mask` comes in all zero with the right
  /// length.
  virtual void run(const Correspondences& matches, Selection& result) const = 0;
};

}  // namespace core

/// The name under which plug-ins derive from it.
using core::Selector;

}  // namespace corrsel
