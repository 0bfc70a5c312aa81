// Adds the selectors of corrsel::reference before the names of parameterised tests are made.

#include "corrsel/reference/reference_selectors.h"

namespace {

[[maybe_unused]] const bool kAdded = [] {
  corrsel::core::addReferenceSelectors();
  return true;
}();

}  // namespace
