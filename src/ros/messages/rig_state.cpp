#include "corrsel/ros/rig_state.h"

#include <algorithm>
#include <cmath>

#include "ros/messages/vectors.h"

namespace corrsel {
namespace {

template <class Array>
void write(const core::Pose& pose, double baseline, Array& rotation, boost::array<double, 3>& translation) {
  std::copy_n(pose.rotation.val, rotation.size(), rotation.begin());
  for (int k = 0; k < 3; ++k) translation[static_cast<std::size_t>(k)] = baseline * pose.translation[k];
}

}  // namespace

RigState toMsg(const core::RigReport& report, double baseline, const PairInfo& info) {
  RigState msg;
  msg.header = info.header;
  msg.right_stamp = info.right_stamp;
  msg.right_frame_id = info.right_frame_id;
  msg.state = static_cast<std::uint8_t>(report.state);
  msg.message = report.message;
  msg.window = report.seconds;
  msg.n_pairs = static_cast<std::uint32_t>(report.pairs);
  msg.n_matches = static_cast<std::uint32_t>(report.matches);
  write(report.calibrated, baseline, msg.calibrated_rotation, msg.calibrated_translation);
  write(report.reference, baseline, msg.reference_rotation, msg.reference_translation);
  write(report.corrected, baseline, msg.corrected_rotation, msg.corrected_translation);
  msg.learned = report.learned;
  std::copy_n(report.deviation.val, 5, msg.deviation.begin());
  std::copy_n(report.covariance.val, 25, msg.covariance.begin());
  std::copy_n(report.shown.val, 5, msg.significant.begin());
  std::copy(report.observable.begin(), report.observable.end(), msg.observable.begin());
  cv::Vec3d a, b;
  core::translationBasis(report.reference.translation, a, b);
  msg.basis_a = vectorMsg(a);
  msg.basis_b = vectorMsg(b);
  msg.angle = report.angle;
  msg.agreed = report.agreed;
  msg.noise = report.noise;
  msg.grid = static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(report.regions.size()))));
  for (const core::RigRegion& region : report.regions) {
    msg.region_matches.push_back(static_cast<std::uint32_t>(region.count));
    msg.region_median.push_back(region.median);
    msg.region_rms.push_back(region.rms);
    msg.region_corrected_median.push_back(region.corrected_median);
  }
  return msg;
}

}  // namespace corrsel
