#include "programs/launch_arguments.h"

#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "programs/command_line.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

/// Names of the arguments that a caller may set: those without a fixed value.
std::vector<std::string> declaredArguments(const std::string& launch_file) {
  tinyxml2::XMLDocument document;
  const tinyxml2::XMLElement* launch = nullptr;
  if (document.LoadFile(launch_file.c_str()) == tinyxml2::XML_SUCCESS) launch = document.RootElement();
  if (launch == nullptr) throw std::invalid_argument("cannot read the launch file " + launch_file);
  std::vector<std::string> names;
  for (const auto* arg = launch->FirstChildElement("arg"); arg != nullptr;
       arg = arg->NextSiblingElement("arg")) {
    const char* const name = arg->Attribute("name");
    if (name != nullptr && arg->Attribute("value") == nullptr) names.emplace_back(name);
  }
  return names;
}

bool isLaunchFile(const std::string& word) {
  const std::string extension = fs::path(word).extension().string();
  return extension == ".launch" || extension == ".test" || extension == ".xml";
}

/// The words behind "roslaunch" where they start `launch_file` and no other; otherwise none.
std::vector<std::string> wordsFor(const std::vector<std::string>& words, const std::string& folder,
                                  const std::string& package, const std::string& launch_file) {
  const auto program = std::find_if(words.begin(), words.end(), [](const std::string& word) {
    return fs::path(word).filename() == "roslaunch";
  });
  if (program == words.end()) return {};
  const std::vector<std::string> rest(program + 1, words.end());
  bool found = false;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const bool assigned = rest[i].find(":=") != std::string::npos;
    if (assigned || !isLaunchFile(rest[i])) continue;
    std::error_code ignored;
    const bool in_package = i > 0 && rest[i - 1] == package && rest[i] == fs::path(launch_file).filename();
    if (!in_package && !fs::equivalent(fs::path(folder) / rest[i], launch_file, ignored)) return {};
    found = true;
  }
  return found ? rest : std::vector<std::string>();
}

}  // namespace

std::vector<std::string> launchArguments(const std::vector<std::string>& words, const std::string& folder,
                                         const std::string& package, const std::string& launch_file) {
  const std::vector<std::string> declared = declaredArguments(launch_file);
  std::map<std::string, std::string> values;
  std::vector<std::string> given;
  for (const std::string& word : wordsFor(words, folder, package, launch_file)) {
    const std::size_t assignment = word.find(":=");
    // Names with an underscore are those of ROS itself.
    if (assignment == std::string::npos || word[0] == '_' || word[0] == '-') continue;
    const std::string name = word.substr(0, assignment), value = word.substr(assignment + 2);
    if (std::find(declared.begin(), declared.end(), name) == declared.end()) {
      throw UsageError("unknown argument '" + word + "'" + core::validNames(name, declared));
    }
    const auto [before, inserted] = values.emplace(name, value);
    if (!inserted) {
      throw UsageError(name + " is given twice, as '" + before->second + "' and as '" + value +
                       "'; give it once");
    }
    given.push_back(word);
  }
  return given;
}

}  // namespace corrsel
