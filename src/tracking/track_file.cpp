#include "corrsel/tracking/track_file.h"

#include <locale>
#include <stdexcept>

namespace corrsel::core {
namespace {

void writeRow(std::ostream& file, std::uint64_t track, std::uint64_t frame, std::uint32_t feature,
              const cv::Point2f& point) {
  file << track << ',' << frame << ',' << feature << ',' << point.x << ',' << point.y << '\n';
}

}  // namespace

TrackFile::TrackFile(const std::filesystem::path& path)
    : path_(path), file_(path, std::ios::binary | std::ios::trunc) {
  file_.imbue(std::locale::classic());
  file_.precision(7);  // what a float holds
  file_ << "track,stamp,keypoint,x,y\n";
  check();
}

void TrackFile::add(std::uint64_t frame, const std::vector<FeatureTrack>& tracks) {
  for (std::uint32_t i = 0; i < tracks.size(); ++i) {
    const FeatureTrack& track = tracks[i];
    if (track.age < 2) continue;
    if (track.age == 2) {
      writeRow(file_, track.id, track.first.frame, track.first.feature, track.first.point);
    }
    writeRow(file_, track.id, frame, i, track.point);
  }
  check();
}

void TrackFile::check() {
  file_.flush();
  if (!file_) {
    throw std::runtime_error("the file of tracks " + path_.string() +
                             " cannot be written; check that its folder exists, may be written to and has "
                             "room");
  }
}

}  // namespace corrsel::core
