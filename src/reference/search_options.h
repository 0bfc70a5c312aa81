#pragma once

#include "corrsel/reference/search_options.h"
#include "search/selecting.h"

namespace corrsel::core {

/// Selects by the search of `usac` with another proposal.
void selectByUsac(const Correspondences& matches, const ReferenceSearchOptions& options, Proposal& proposal,
                  Workspace& workspace, Selection& result);

}  // namespace corrsel::core
