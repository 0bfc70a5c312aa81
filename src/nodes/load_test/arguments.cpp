#include "arguments.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::load_test {
namespace {

double parseWithin(const std::string& text, const std::string& name, double low, double high) {
  const double value = core::parseNumber(text, name);
  if (!(value >= low && value <= high)) {
    throw std::invalid_argument(name + " must be between " + core::formatNumber(low) + " and " +
                                core::formatNumber(high) + ", not " + text);
  }
  return value;
}

cv::Size parseSize(const std::string& text, const std::string& name) {
  const std::vector<std::string> parts = core::splitList(text, 'x');
  if (parts.size() != 2) throw std::invalid_argument(name + " must look like 640x480, not '" + text + "'");
  return {static_cast<int>(parseWithin(std::to_string(core::parseInteger(parts[0], name)), name, 16, 20000)),
          static_cast<int>(parseWithin(std::to_string(core::parseInteger(parts[1], name)), name, 16, 20000))};
}

std::string parseChoice(const std::string& text, const std::string& name,
                        const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
    throw std::invalid_argument(name + " must be one of " + core::joinList(choices) + ", not '" + text + "'");
  }
  return text;
}

std::vector<std::string> parseSelectors(const std::string& text, const std::string& name) {
  std::vector<std::string> selectors = core::splitList(text);
  if (selectors.empty()) throw std::invalid_argument(name + " is an empty list");
  for (const std::string& selector : selectors) parseChoice(selector, name, core::selectorNames());
  return selectors;
}

}  // namespace

Arguments parseArguments(const std::vector<std::string>& words) {
  constexpr double kLong = 1e7;  // s
  Arguments arguments;
  std::string name;
  const std::map<std::string, std::function<void(const std::string&)>> setters = {
      {"--images", [&](const std::string& text) { arguments.images = text; }},
      {"--size", [&](const std::string& text) { arguments.size = parseSize(text, name); }},
      {"--encoding",
       [&](const std::string& text) {
         arguments.encoding = parseChoice(text, name, {"mono8", "bgr8"});
       }},
      {"--rate", [&](const std::string& text) { arguments.rate = parseWithin(text, name, 0.01, 1000); }},
      {"--seconds",
       [&](const std::string& text) { arguments.seconds = parseWithin(text, name, 0.1, kLong); }},
      {"--reconfigure",
       [&](const std::string& text) { arguments.reconfigure = parseWithin(text, name, 0, kLong); }},
      {"--selectors", [&](const std::string& text) { arguments.selectors = parseSelectors(text, name); }},
      {"--matcher-node", [&](const std::string& text) { arguments.matcher_node = text; }},
      {"--selector-node", [&](const std::string& text) { arguments.selector_node = text; }},
      {"--seed", [&](const std::string& text) { arguments.seed = core::parseInteger(text, name); }},
      {"--csv", [&](const std::string& text) { arguments.csv = text; }},
      {"--interval",
       [&](const std::string& text) { arguments.interval = parseWithin(text, name, 1, kLong); }},
      {"--wait", [&](const std::string& text) { arguments.wait = parseWithin(text, name, 0.1, kLong); }},
      {"--max-drop-ratio",
       [&](const std::string& text) { arguments.max_drop_ratio = parseWithin(text, name, 0, 1); }},
      {"--max-memory-growth",
       [&](const std::string& text) { arguments.max_memory_growth = parseWithin(text, name, 0, 1000); }},
  };
  for (std::size_t i = 0; i < words.size(); ++i) {
    name = words[i];
    if (name == "--help" || name == "-h") {
      arguments.help = true;
      continue;
    }
    const auto setter = setters.find(name);
    if (setter == setters.end()) throw std::invalid_argument("unknown argument '" + name + "'");
    if (i + 1 >= words.size()) throw std::invalid_argument(name + " needs a value");
    setter->second(words[++i]);
  }
  return arguments;
}

std::string usage() {
  return "Plays two cameras and a consumer against running nodelets and says how they keep up.\n"
         "\n"
         "  roslaunch corrsel live.launch left_image:=left/image right_image:=right/image features:=orb+orb\n"
         "  rosrun corrsel load_test --rate 30 --seconds 60\n"
         "\n"
         "Publishes left/image and right/image, both stamped with the wall time of that moment, and\n"
         "listens to matches and selection. Topics are remapped as usual: left/image:=/camera/left.\n"
         "\n"
         "  --images LEFT,RIGHT     two image files\n"
         "  --images FOLDER         left_NAME and right_NAME, or left/NAME and right/NAME, in the order of\n"
         "                          names, over and over; default: the sample photographs at 640x480\n"
         "  --size WxH              images are scaled to this size, px\n"
         "  --encoding ENCODING     mono8 or bgr8 [mono8]\n"
         "  --rate HZ               pairs per second [10]\n"
         "  --seconds S             length of the test [10]\n"
         "  --interval S            the table has a line for every interval [60]\n"
         "  --wait S                for the first answer, before the test begins [30]\n"
         "  --reconfigure S         a random change of a parameter every S seconds; 0 = none [0]\n"
         "  --selectors LIST        selectors among which these changes choose [gms,lpm,nnsr,ransac]\n"
         "  --matcher-node NAME     whose parameters are changed [feature_matcher]\n"
         "  --selector-node NAME    whose parameters are changed [selector]\n"
         "  --seed N                of the random changes [0]\n"
         "  --csv FILE              one line for every pair sent\n"
         "  --max-drop-ratio R      fail where more than this share of the pairs is not answered [1]\n"
         "  --max-memory-growth R   fail where the memory of the last interval is larger than that of the\n"
         "                          interval at one sixth of the test by more than this share [no limit]\n"
         "  --help                  this text\n"
         "\n"
         "Printed: for every interval the pairs sent and answered, the latency from the stamp to the\n"
         "arrival of the matches, processor time and resident memory of the processes that answer (100 % =\n"
         "one core; only where they run on this machine); at the end where the time went, from the\n"
         "selections' own figures: wait (in queues), detect, describe, match, select, publish, and the rest\n"
         "(transport and scheduling). Detect and describe add up both images: where these are worked on\n"
         "side by side, the rest is the smaller by it, below zero (less). A pair is dropped where\n"
         "no matches came for it. Answers twice, out of order or for stamps never sent are counted and\n"
         "are a failure.\n"
         "\n"
         "Exit code: 0 = ok, 1 = a limit exceeded, no answer, a process that ended, 2 = wrong usage, 130 =\n"
         "interrupted.\n";
}

}  // namespace corrsel::load_test
