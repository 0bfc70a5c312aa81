#pragma once

#include <string>
#include <utility>

#include "corrsel/selectors/presets.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct KeepAllOptions : OptionSet {
  void visit(OptionVisitor&) const override {}
};

/// Selects every match with finite coordinates: the baseline that every selector must beat. O(N).
class KeepAllSelector : public Selector {
 public:
  explicit KeepAllSelector(KeepAllOptions options = {}) : options_(std::move(options)) {}
  static Presets presets() { return {}; }
  std::string name() const override { return "keep_all"; }
  const OptionSet& options() const override { return options_; }

 protected:
  void run(const Correspondences& matches, Selection& result) const override;

 private:
  KeepAllOptions options_;
};

}  // namespace corrsel::core
