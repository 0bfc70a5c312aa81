#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "base/temporary_folder.h"
#include "corrsel/tracking/track_file.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TrackKeeper::Frame frame(std::uint64_t id) { return {id, {{1.25F, float(id)}, {1000.125F, 0.5F}}, nullptr}; }

TEST(TrackFile, HasTheSightsOfTracksThatWereSeenTwice) {
  const TemporaryFolder folder("track_file");
  const std::filesystem::path path = folder.path() / "tracks.csv";
  TrackFile file(path);
  TrackKeeper keeper;
  const auto text = [&] {
    std::ifstream in(path);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  keeper.add(frame(1000000000000000001));
  file.add(1000000000000000001, keeper.tracks());
  EXPECT_EQ(text(), "track,stamp,keypoint,x,y\n");
  keeper.add(frame(1000000000000000002), 1000000000000000001, {{0, 1, 0}});
  file.add(1000000000000000002, keeper.tracks());
  const std::string two = text();  // it is flushed
  EXPECT_EQ(two,
            "track,stamp,keypoint,x,y\n"
            "2,1000000000000000001,1,1000.125,0.5\n"
            "2,1000000000000000002,0,1.25,1e+18\n");
  keeper.add(frame(1000000000000000003), 1000000000000000002, {{1, 0, 0}});
  file.add(1000000000000000003, keeper.tracks());
  EXPECT_EQ(text(), two + "2,1000000000000000003,1,1000.125,0.5\n");
}

TEST(TrackFile, AFileThatCannotBeWrittenIsNamed) {
  EXPECT_TRUE(mentions(errorOf([] { TrackFile("/no_such_folder/tracks.csv"); }),
                       {"/no_such_folder/tracks.csv", "room"}));
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  EXPECT_TRUE(mentions(errorOf([] { TrackFile("/dev/full"); }), {"/dev/full", "room"}));
}

TEST(TrackFile, ADiskThatFillsUpIsReported) {
  const TemporaryFolder folder("track_file");
  TrackFile file(folder.path() / "tracks.csv");
  // Files of this process cannot grow any more, which looks like a full disk.
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{}, small{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  small = limit;
  small.rlim_cur = 100;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  TrackKeeper keeper;
  const std::string error = errorOf([&] {
    keeper.add(frame(1));
    for (std::uint64_t k = 2; k < 20; ++k) {
      keeper.add(frame(k), k - 1, {{0, 0, 0}, {1, 1, 0}});
      file.add(k, keeper.tracks());
    }
  });
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, before);
  EXPECT_TRUE(mentions(error, {"tracks.csv cannot be written", "room"}));
}

}  // namespace
}  // namespace corrsel::core
