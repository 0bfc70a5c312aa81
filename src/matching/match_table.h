#pragma once

#include <string>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Putative matches as a CSV file, with the columns that they have (docs/matches.md lists them).
std::string putativeTable(const Correspondences& putative);

/// The matches that a selector kept, as a CSV file with the columns of putativeTable(), the numbers of the
/// matches there, and what the selector says about each of them (docs/matches.md lists the columns).
/// @param selection  of `putative`
std::string selectedTable(const Correspondences& putative, const Selection& selection);

}  // namespace corrsel::core
