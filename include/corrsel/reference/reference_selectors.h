#pragma once

namespace corrsel::core {

/// Adds the selectors of the library corrsel::reference to builtInSelectors(): published methods that are
/// there for comparison, while corrsel::core has those that robots use. A program that offers every selector
/// calls it once; further calls do nothing. May be called from any thread.
void addReferenceSelectors();

}  // namespace corrsel::core
