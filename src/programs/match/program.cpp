#include "programs/match/program.h"

#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <stdexcept>
#include <utility>

#include "base/size_text.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/match_drawing.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"
#include "features/parts/image_bytes.h"
#include "matching/match_table.h"
#include "programs/command_line.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr int kReliable = 0, kUnreliable = 1, kUnusable = 2;
constexpr int kMostThreads = 256;
constexpr char kWithoutCameras[] = "auto", kWithCameras[] = "pose";

CommandLineTable argumentTable(const MatchFront& front) {
  CommandLineTable table = {
      front.program,
      "Matches two images and prints what they have in common: the kind of scene, the matches that are kept, "
      "the "
      "confidence, the model or pose, and the times.",
      {"LEFT", "RIGHT"},
      {{"features", "NAMES", "sift+sift", "detector+descriptor, see docs/features.md"},
       {"selector", "NAME", "",
        "what decides which matches are kept, with a preset where wanted, e.g. gms, usac:f; auto by default, "
        "and "
        "pose where cameras are given"},
       {"set", "LIST", "", "options of the selector: NAME=VALUE,NAME=VALUE"},
       {"camera", "CAMERA", "", "the calibrated camera of both images"},
       {"left_camera", "CAMERA", "", "the camera of the left image"},
       {"right_camera", "CAMERA", "", "the camera of the right image"},
       {"csv", "FILE", "", "write the kept matches"},
       {"putative", "FILE", "", "write all matches as they were before the selection, as CSV, too"},
       {"picture", "FILE", "", "draw what was kept, in the colours of its groups, and what was rejected"},
       {"width", "PX", "1600",
        "width of the picture, to which images are enlarged at most twice; 0 = that of the images"},
       {"lines", "N", "100", "largest number of lines in the picture, of kept and of rejected matches each"},
       {"threads", "N", "1", "threads that may be used; the result does not depend on it"},
       {"json", "", "", "print the answer as JSON"}},
      "CAMERA is fx,fy,cx,cy in px, or a YAML file of Kalibr or EuRoC: camchain.yaml, camchain.yaml:cam1.\n"
      "\n"
      "exit code: 0 = the answer can be relied on, 1 = it cannot, or nothing was found (see the status), 2 = "
      "wrong\n"
      "arguments or a file that cannot be used (the message names it and the remedy)\n"};
  if (front.write_npz) {
    table.arguments.insert(
        table.arguments.begin() + 7,
        {"npz", "FILE", "", "write keypoints, putative matches and what was kept as arrays"});
  }
  return table;
}

[[noreturn]] void fail(const std::string& path, const std::string& fault, const std::string& remedy) {
  throw std::runtime_error(path + ": " + fault + "; " + remedy);
}

std::vector<std::uint8_t> readBytes(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) fail(path, "there is no such file", "check the path");
  if (fs::is_directory(path, ignored)) fail(path, "is a folder", "give an image file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(path, "cannot be read", "check the permissions");
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

cv::Mat readImage(const std::string& path, const MatchFront& front) {
  const std::vector<std::uint8_t> bytes = readBytes(path);
  const cv::Mat image = bytes.empty() || core::isCutOff(bytes) ? cv::Mat() : front.decode(bytes);
  if (image.empty()) throw std::runtime_error(path + ": " + core::undecodableCause(bytes));
  return image;
}

void writeBytes(const std::string& path, const char* bytes, std::size_t size) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(bytes, static_cast<std::streamsize>(size));
  stream.close();
  if (!stream)
    fail(path, "cannot be written", "check that the folder exists, its permissions and the free space");
}

void writeText(const std::string& path, const std::string& text) {
  writeBytes(path, text.data(), text.size());
}

std::vector<std::uint8_t> encodePicture(const std::string& path, const MatchFront& front,
                                        const cv::Mat& picture) {
  const std::string ending = fs::path(path).extension().string();
  std::vector<std::uint8_t> bytes;
  if (!ending.empty()) bytes = front.encode(ending, picture);
  if (bytes.empty())
    throw UsageError("--picture is '" + path + "', which ends like no image; valid: FILE.png, FILE.jpg");
  return bytes;
}

core::OptionMap optionsOf(const ArgumentValues& values) {
  core::OptionMap options;
  for (const std::string& item : values.list("set")) {
    const std::size_t sign = item.find('=');
    if (sign == std::string::npos || sign == 0)
      throw UsageError("--set has '" + item + "'; valid: NAME=VALUE, e.g. --set threshold=3,seed=1");
    if (!options.emplace(item.substr(0, sign), item.substr(sign + 1)).second)
      throw UsageError("--set has '" + item.substr(0, sign) + "' twice; give it once");
  }
  return options;
}

/// A camera of the image from the text of an argument.
core::Camera cameraOf(const std::string& text, const cv::Size& image, const MatchFront& front) {
  const std::vector<std::string> parts = core::splitList(text);
  if (parts.size() == 4) {
    std::vector<double> k;
    for (const std::string& part : parts)
      k.push_back(core::parseNumber(part, "a number of the camera " + text));
    return core::cameraFromOpenCv({k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1}, {}, image);
  }
  const std::size_t colon = text.rfind(":cam");
  const std::string path = text.substr(0, colon);
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) {
    throw UsageError("the camera is '" + text +
                     "', which is no file; valid: fx,fy,cx,cy in px, or a YAML file of Kalibr or EuRoC");
  }
  core::Camera camera = front.camera(path, colon == std::string::npos ? "cam0" : text.substr(colon + 1));
  if (!camera.size.empty() && camera.size != image) {
    fail(path,
         "is the camera of images of " + core::sizeText(camera.size) + " px, but the image has " +
             core::sizeText(image),
         "give the camera of this image");
  }
  return camera;
}

/// Adds the cameras that the command line has. @return whether there are any
bool addCameras(const ArgumentValues& values, const MatchFront& front, core::Correspondences& matches) {
  const auto given = [&values](const char* side) {
    return values.text(values.given(side) ? side : "camera");
  };
  const std::string left = given("left_camera"), right = given("right_camera");
  if (left.empty() && right.empty()) return false;
  if (left.empty() || right.empty()) {
    throw UsageError(std::string("the camera of the ") + (left.empty() ? "left" : "right") +
                     " image is missing; give --camera for both images, or --left_camera and --right_camera");
  }
  matches.left_camera = cameraOf(left, matches.left_size, front);
  matches.right_camera = cameraOf(right, matches.right_size, front);
  return true;
}

MatchAnswer match(const ArgumentValues& values, const MatchFront& front) {
  const int threads = values.integer("threads", 1, kMostThreads);
  MatchAnswer answer;
  answer.left.file = values.text("LEFT");
  answer.right.file = values.text("RIGHT");
  answer.features = values.text("features");
  const auto extractor = core::createExtractor(answer.features);
  core::Stopwatch watch;
  answer.left.pixels = readImage(answer.left.file, front);
  answer.right.pixels = readImage(answer.right.file, front);
  std::error_code ignored;
  if (fs::equivalent(answer.left.file, answer.right.file, ignored)) {
    throw UsageError("LEFT and RIGHT are the same file, " + answer.left.file + "; give two images");
  }
  answer.read_seconds = watch.restart();
  core::Correspondences sizes;
  sizes.left_size = answer.left.pixels.size();
  sizes.right_size = answer.right.pixels.size();
  const bool calibrated = addCameras(values, front, sizes);
  answer.selector = values.text("selector");
  if (answer.selector.empty()) answer.selector = calibrated ? kWithCameras : kWithoutCameras;
  const auto selector =
      core::createSelector(answer.selector, optionsOf(values), {{"threads", std::to_string(threads)}});
  watch.restart();
  const auto [left, right] = core::extractPair(*extractor, answer.left.pixels, answer.right.pixels, threads);
  answer.left.features = left.keypoints.size();
  answer.right.features = right.keypoints.size();
  answer.features_seconds = watch.restart();
  answer.matches = core::matchFeatures(left, right, {}, threads);
  answer.match_seconds = watch.restart();
  answer.matches.left_camera = sizes.left_camera;
  answer.matches.right_camera = sizes.right_camera;
  answer.selection = selector->select(answer.matches);
  core::addProbability(answer.matches, answer.selection);
  answer.select_seconds = watch.seconds();
  return answer;
}

/// @return the files
std::vector<std::string> writeFiles(const ArgumentValues& values, const MatchFront& front,
                                    const MatchAnswer& answer) {
  std::vector<std::string> files;
  const auto isWanted = [&](const char* name) {
    if (!values.given(name)) return false;
    files.push_back(values.text(name));
    return true;
  };
  if (isWanted("csv")) writeText(files.back(), core::selectedTable(answer.matches, answer.selection));
  if (isWanted("putative")) writeText(files.back(), core::putativeTable(answer.matches));
  if (front.write_npz && isWanted("npz")) front.write_npz(files.back(), answer);
  if (isWanted("picture")) {
    core::SelectionDrawingOptions options;
    options.width = values.integer("width", 0, 100000);
    options.max_lines = static_cast<std::size_t>(values.integer("lines", 0, 1000000));
    const cv::Mat picture = core::drawSelection(answer.left.pixels, answer.right.pixels, answer.matches,
                                                answer.selection, options);
    const std::vector<std::uint8_t> bytes = encodePicture(files.back(), front, picture);
    writeBytes(files.back(), reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return files;
}

}  // namespace

int runMatch(const std::vector<std::string>& words, const MatchFront& front, std::ostream& out,
             std::ostream& errors) {
  const CommandLineTable table = argumentTable(front);
  try {
    const ArgumentValues values = parseCommandLine(table, words);
    if (values.help) {
      out << helpText(table);
      return kReliable;
    }
    // Before the work, so that a wrong name does not cost it.
    if (values.given("picture")) encodePicture(values.text("picture"), front, cv::Mat::zeros(1, 1, CV_8UC3));
    const MatchAnswer answer = match(values, front);
    const bool as_json = values.isOn("json");
    // Before the files, so that one that cannot be written does not cost the answer.
    out << (as_json ? jsonOf(answer) : textOf(answer));
    const std::vector<std::string> files = writeFiles(values, front, answer);
    if (!as_json && !files.empty()) out << writtenLine(files);
    return answer.selection.status == core::Status::kOk ? kReliable : kUnreliable;
  } catch (const UsageError& error) {
    errors << front.program << ": " << error.what() << "; --help lists the arguments\n";
  } catch (const std::exception& error) {
    errors << front.program << ": " << error.what() << "\n";
  }
  return kUnusable;
}

}  // namespace corrsel
