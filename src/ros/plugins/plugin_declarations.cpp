#include "ros/plugins/plugin_declarations.h"

#include <ros/package.h>
#include <tinyxml2.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "base/text.h"

namespace corrsel {
namespace {

/// "package/Class", each part of letters, digits and underscores: it must not collide with the separators of
/// presets, options and lists.
bool isClassName(const std::string& name) {
  const auto special = [](char c) {
    return !((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_');
  };
  return name.find('/') != std::string::npos && name.front() != '/' && name.back() != '/' &&
         std::count_if(name.begin(), name.end(), special) == 1;
}

std::string attributeOf(const tinyxml2::XMLElement& element, const char* name) {
  const char* const text = element.Attribute(name);
  return text ? text : "";
}

/// Names of the plug-ins with this base class that a file declares. Throws std::invalid_argument saying what
/// is wrong with a file that pluginlib would stumble over: it never returns from a library without a path.
std::vector<std::string> declaredIn(const std::string& file, const PluginKind& kind) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS) {
    throw std::invalid_argument(file + " is missing or no XML");
  }
  const tinyxml2::XMLElement* library = document.RootElement();
  if (std::string(library->Value()) == "class_libraries") {
    library = library->FirstChildElement("library");
  } else if (std::string(library->Value()) != "library") {
    throw std::invalid_argument(file + ": the outermost element must be 'library' or 'class_libraries'");
  }
  std::vector<std::string> names;
  for (; library; library = library->NextSiblingElement("library")) {
    if (attributeOf(*library, "path").empty()) {
      throw std::invalid_argument(file + ": a library has no 'path', e.g. path=\"lib/libyour_" + kind.noun +
                                  "s\"");
    }
    for (const auto* entry = library->FirstChildElement("class"); entry;
         entry = entry->NextSiblingElement("class")) {
      const std::string type = attributeOf(*entry, "type"), base = attributeOf(*entry, "base_class_type");
      if (type.empty() || base.empty()) {
        throw std::invalid_argument(file + ": a class has no 'type' or no 'base_class_type'");
      }
      if (base != kind.base) continue;
      const std::string name = attributeOf(*entry, "name");
      names.push_back(name.empty() ? type : name);
    }
  }
  return names;
}

}  // namespace

void PluginDeclarations::search() {
  files_.clear();
  problems_.clear();
  std::vector<std::string> files;
  ros::package::getPlugins(kPluginPackage, kPluginAttribute, files, true);
  if (ros::package::getPath(kPluginPackage).empty()) {
    problems_.push_back(
        "rospack does not find the package corrsel, nor those that depend on it: source the setup.bash of "
        "the workspace");
  }
  std::map<std::string, std::vector<std::string>> declared;
  for (const std::string& file : files) {
    try {
      add(file, declared);
    } catch (const std::invalid_argument& error) {
      problems_.push_back(error.what());
    }
  }
  for (auto& [name, from] : declared) {
    std::sort(from.begin(), from.end());
    from.erase(std::unique(from.begin(), from.end()), from.end());
    if (from.size() == 1) {
      files_[name] = from.front();
    } else {
      problems_.push_back("'" + name + "' is left out: it is declared in " +
                          core::joinList(from, " and in ") + "; rename one");
    }
  }
}

/// Adds what one file declares once and under a valid name.
void PluginDeclarations::add(const std::string& file,
                             std::map<std::string, std::vector<std::string>>& declared) {
  std::set<std::string> own, twice;
  for (const std::string& name : declaredIn(file, kind_)) {
    if (!isClassName(name)) {
      problems_.push_back("'" + name + "' in " + file + " is left out: a " + kind_.noun +
                          "'s name reads package/Class, of letters, digits and underscores");
    } else if (!own.insert(name).second && twice.insert(name).second) {
      problems_.push_back("'" + name + "' is left out: it is declared twice in " + file + "; remove one");
    }
  }
  for (const std::string& name : own) {
    if (twice.count(name) == 0) declared[name].push_back(file);
  }
}

const std::string* PluginDeclarations::fileOf(const std::string& name) const {
  const auto found = files_.find(name);
  return found == files_.end() ? nullptr : &found->second;
}

std::vector<std::string> PluginDeclarations::names() const {
  std::vector<std::string> names;
  const std::string own = kPluginPackage + std::string("/");
  for (const auto& declaration : files_) {
    if (declaration.first.rfind(own, 0) != 0) names.push_back(declaration.first);
  }
  return names;
}

std::string PluginDeclarations::unknown(const std::string& name) const {
  const std::string noun = kind_.noun;
  std::string text =
      "unknown " + noun + " '" + name + "'" + core::validNames(name, names(), noun + "s of other packages");
  for (const std::string& problem : problems_) text += "; " + problem;
  return text;
}

}  // namespace corrsel
