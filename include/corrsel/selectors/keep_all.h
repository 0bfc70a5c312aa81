#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// Selects every match with finite coordinates: the baseline that every selector must beat. O(N).
class KeepAllSelector : public SelectorWithOptions<NoOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "keep_all"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
