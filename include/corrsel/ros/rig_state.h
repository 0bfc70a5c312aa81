#pragma once

#include "corrsel/RigState.h"
#include "corrsel/rig_monitor.h"
#include "corrsel/ros/conversions.h"

namespace corrsel {

/// Converts a report to a message.
/// @param baseline  length of the translation, m
/// @param info      newest pair of the window: stamps and frames are copied
RigState toMsg(const core::RigReport& report, double baseline, const PairInfo& info);

}  // namespace corrsel
