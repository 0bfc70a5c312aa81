#pragma once

#include "auto/decision.h"
#include "auto/evidence.h"
#include "auto/memory.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/auto.h"

namespace corrsel::core {

/// Writes the answer that was decided on: mask, score, model, groups, confidence, noise, probabilities,
/// scene, status and message.
/// @param memory  in which the evidence was gathered
/// @param effort  receives the cost of the search for further planes, where the answer has them
void writeAnswer(const Decision& decision, const Evidence& evidence, const AutoOptions& options,
                 AutoMemory& memory, Effort& effort, Selection& result);

}  // namespace corrsel::core
