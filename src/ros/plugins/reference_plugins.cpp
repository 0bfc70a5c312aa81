// The selectors of corrsel::reference in the form in which every package exports its selectors, for programs
// that do not link the library.

#include <pluginlib/class_list_macros.hpp>

#include "corrsel/reference/frame_votes.h"
#include "corrsel/reference/gaim.h"
#include "corrsel/reference/icf.h"
#include "corrsel/reference/lap.h"
#include "corrsel/reference/logos.h"
#include "corrsel/reference/mlesac.h"
#include "corrsel/reference/multigs.h"
#include "corrsel/reference/pnapsac.h"
#include "corrsel/reference/ranks.h"
#include "corrsel/reference/rfm_scan.h"
#include "corrsel/reference/rrwm.h"
#include "corrsel/reference/tlinkage.h"

PLUGINLIB_EXPORT_CLASS(corrsel::core::LapSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::RanksSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::RfmScanSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::LogosSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::FrameVotesSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::GaimSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::RrwmSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::MultigsSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::PnapsacSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::MlesacSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::IcfSelector, corrsel::Selector)
PLUGINLIB_EXPORT_CLASS(corrsel::core::TlinkageSelector, corrsel::Selector)
