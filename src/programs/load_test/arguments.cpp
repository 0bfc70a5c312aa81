#include "programs/load_test/arguments.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::load_test {
namespace {

cv::Size sizeOf(const std::string& text) {
  const std::vector<std::string> parts = core::splitList(text, 'x');
  cv::Size size;
  try {
    if (parts.size() == 2) {
      size = {core::parseInteger(parts[0], "width"), core::parseInteger(parts[1], "height")};
    }
  } catch (const std::invalid_argument&) {
    size = {};
  }
  const auto valid = [](int length) { return length >= 16 && length <= 20000; };
  if (valid(size.width) && valid(size.height)) return size;
  throw UsageError("--size must read like 640x480, with both numbers between 16 and 20000, not '" + text +
                   "'");
}

std::vector<std::string> selectorsOf(const std::vector<std::string>& names) {
  if (names.empty()) throw UsageError("--selectors is an empty list");
  const std::vector<std::string> known = core::selectorNames();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw UsageError("--selectors: unknown selector '" + name + "'" + core::validNames(name, known));
  }
  return names;
}

}  // namespace

const CommandLineTable& argumentTable() {
  static const CommandLineTable table = {
      "load_test",
      "Plays two cameras and a consumer against running nodelets and measures how they keep up. It publishes "
      "left/image and right/image, both stamped with the wall time of that moment, and subscribes to matches "
      "and selection. Topics are remapped as usual: left/image:=/camera/left.",
      {},
      {
          {"images", "FILES", "",
           "LEFT,RIGHT: two image files; or a folder with left_NAME and right_NAME, or left/NAME and "
           "right/NAME, "
           "which are played repeatedly in the order of their names; default: the sample photographs at "
           "640x480"},
          {"size", "WxH", "", "size that the images are scaled to, px; default: that of the files"},
          {"encoding", "ENCODING", "mono8", "mono8 or bgr8"},
          {"sequence", "", "",
           "play one camera, on image: the two images of a pair in turn, 100 of them, then the next pair"},
          {"calibrated", "", "", "publish camera_info with every image"},
          {"mask-period", "N", "0",
           "publish a mask with the stamp of every N-th image, one image late, on left/mask and right/mask, "
           "or on mask; 0 = none"},
          {"rate", "HZ", "10", "pairs per second; with --sequence, images per second"},
          {"seconds", "S", "10", "length of the test"},
          {"interval", "S", "60", "the table has a line for every interval of this length"},
          {"wait", "S", "30", "how long to wait for the first result, before the test begins"},
          {"reconfigure", "S", "0", "time between two random changes of parameters; 0 = none"},
          {"selectors", "LIST", "gms,lpm,nnsr,ransac", "selectors that these changes choose from"},
          {"matcher-node", "NAME", "feature_matcher", "matcher whose parameters are changed"},
          {"selector-node", "NAME", "selector", "selector whose parameters are changed"},
          {"seed", "N", "0", "seed of the random changes"},
          {"csv", "FILE", "", "file that gets one line for every pair sent"},
          {"max-drop-ratio", "R", "1", "fail if a larger share of the pairs is dropped"},
          {"max-memory-growth", "R", "inf",
           "fail if the memory of the last interval exceeds that of the interval at one sixth of the test by "
           "a larger "
           "share"},
      },
      "For every interval the table shows the pairs sent and processed, the latency from the stamp to the\n"
      "arrival of the matches, and processor time (100 % = one core) and resident memory of the nodelets'\n"
      "processes, if they run on this machine. At the end the program prints how the time is divided, as "
      "the\n"
      "selections report it: wait (in queues), detect, describe, match, select, publish, and the rest\n"
      "(transport and scheduling). Detect and describe are sums over both images. If these are processed at\n"
      "the same time, the rest is smaller by the time saved and can be negative. A pair without matches "
      "counts\n"
      "as dropped. Results that come twice, out of order or for stamps never sent are counted as failures.\n"
      "\n"
      "exit code: 0 = ok, 1 = a limit exceeded, no result, or a process that ended, 2 = wrong arguments,\n"
      "130 = interrupted\n"};
  return table;
}

Arguments argumentsOf(const ArgumentValues& values) {
  constexpr double kLong = 1e7;  // s
  Arguments arguments;
  arguments.images = values.text("images");
  if (values.given("size")) arguments.size = sizeOf(values.text("size"));
  arguments.encoding = values.choice("encoding", {"mono8", "bgr8"});
  arguments.sequence = values.given("sequence");
  arguments.calibrated = values.given("calibrated");
  arguments.mask_period = values.integer("mask-period", 0, 1000000);
  arguments.rate = values.number("rate", 0.01, 1000);
  arguments.seconds = values.number("seconds", 0.1, kLong);
  arguments.reconfigure = values.number("reconfigure", 0, kLong);
  arguments.selectors = selectorsOf(values.list("selectors"));
  arguments.matcher_node = values.text("matcher-node");
  arguments.selector_node = values.text("selector-node");
  arguments.seed = values.integer("seed", 0, std::numeric_limits<int>::max());
  arguments.csv = values.text("csv");
  arguments.interval = values.number("interval", 1, kLong);
  arguments.wait = values.number("wait", 0.1, kLong);
  arguments.max_drop_ratio = values.number("max-drop-ratio", 0, 1);
  if (values.given("max-memory-growth")) {
    arguments.max_memory_growth = values.number("max-memory-growth", 0, 1000);
  }
  return arguments;
}

}  // namespace corrsel::load_test
