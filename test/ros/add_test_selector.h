#pragma once

#include "corrsel/selectors/factory.h"

namespace corrsel::testing {

/// Adds a selector of the tests to those of this process, once.
template <class Selector>
void addTestSelector() {
  static const bool added = [] {
    core::addSelectors({core::SelectorFactory::of<Selector>(core::SelectorGroup::kLocal, "N", "for tests")});
    return true;
  }();
  static_cast<void>(added);
}

}  // namespace corrsel::testing
