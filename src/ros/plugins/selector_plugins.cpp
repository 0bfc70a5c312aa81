#include "corrsel/ros/selector_plugins.h"

#include <dlfcn.h>
#include <ros/package.h>
#include <tinyxml2.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <pluginlib/class_loader.hpp>
#include <set>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/selectors/factory.h"

namespace corrsel {
namespace {

constexpr const char* kPackage = "corrsel";
constexpr const char* kBase = "corrsel::Selector";  // as plug-in files spell it
constexpr const char* kAttribute = "plugin";

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

/// Names of the selectors that a plug-in file declares. Throws std::invalid_argument saying what is wrong
/// with a file that pluginlib would stumble over: it never returns from a library without a path.
std::vector<std::string> declaredSelectors(const std::string& file) {
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
      throw std::invalid_argument(file + ": a library has no 'path', e.g. path=\"lib/libyour_selectors\"");
    }
    for (const auto* entry = library->FirstChildElement("class"); entry;
         entry = entry->NextSiblingElement("class")) {
      const std::string type = attributeOf(*entry, "type"), base = attributeOf(*entry, "base_class_type");
      if (type.empty() || base.empty()) {
        throw std::invalid_argument(file + ": a class has no 'type' or no 'base_class_type'");
      }
      if (base != kBase) continue;
      const std::string name = attributeOf(*entry, "name");
      names.push_back(name.empty() ? type : name);
    }
  }
  return names;
}

/// The selectors of other packages: what is declared, and the libraries that have been loaded. Not
/// thread-safe.
class Registry {
 public:
  /// Looks through all packages anew.
  void search() {
    files_.clear();
    problems_.clear();
    std::vector<std::string> files;
    ros::package::getPlugins(kPackage, kAttribute, files, true);
    if (ros::package::getPath(kPackage).empty()) {
      problems_.push_back(
          "rospack does not find the package corrsel, nor those that depend on it: source the setup.bash of "
          "the workspace");
    }
    std::map<std::string, std::set<std::string>> declared;
    for (const std::string& file : files) {
      try {
        std::set<std::string> own, twice;
        for (const std::string& name : declaredSelectors(file)) {
          if (!isClassName(name)) {
            problems_.push_back("'" + name + "' in " + file +
                                " is left out: a selector's name reads package/Class, of letters, digits and "
                                "underscores");
          } else if (!own.insert(name).second && twice.insert(name).second) {
            problems_.push_back("'" + name + "' is left out: it is declared twice in " + file +
                                "; remove one");
          }
        }
        for (const std::string& name : own) {
          if (twice.count(name) == 0) declared[name].insert(file);
        }
      } catch (const std::invalid_argument& error) {
        problems_.push_back(error.what());
      }
    }
    for (const auto& [name, from] : declared) {
      if (from.size() == 1) {
        files_[name] = *from.begin();
      } else {
        problems_.push_back("'" + name + "' is left out: it is declared in " +
                            core::joinList({from.begin(), from.end()}, " and in ") + "; rename one");
      }
    }
  }

  /// Those of other packages.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    const std::string own = kPackage + std::string("/");
    for (const auto& declaration : files_) {
      if (declaration.first.rfind(own, 0) != 0) names.push_back(declaration.first);
    }
    return names;
  }

  const std::vector<std::string>& problems() const { return problems_; }

  std::unique_ptr<core::Selector> create(const std::string& name) {
    // A package may have been built, or changed, since.
    if (files_.count(name) == 0) search();
    const auto found = files_.find(name);
    if (found == files_.end()) throw std::invalid_argument(unknown(name));
    try {
      // By the instance's own deleter a library could go while another one of its selectors is at work.
      Loader& loader = loaderOf(found->second);
      std::unique_ptr<core::Selector> selector(loader.createUnmanagedInstance(name));
      // class_loader closes its libraries when the process ends, before the last selectors may.
      dlopen(loader.getClassLibraryPath(name).c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
      return selector;
    } catch (const pluginlib::LibraryLoadException& error) {
      throw std::invalid_argument("selector '" + name + "' is declared in " + found->second +
                                  ", but its library cannot be loaded: build that package and source the "
                                  "setup.bash of its workspace. " +
                                  error.what());
    } catch (const pluginlib::PluginlibException& error) {
      throw std::invalid_argument(
          "selector '" + name + "' is declared in " + found->second +
          ", but its library does not make it: the file's 'type' must be the class of "
          "PLUGINLIB_EXPORT_CLASS(class, corrsel::Selector). " +
          error.what());
    }
  }

 private:
  using Loader = pluginlib::ClassLoader<core::Selector>;

  std::string unknown(const std::string& name) const {
    std::string text =
        "unknown selector '" + name + "'" + core::validNames(name, names(), "selectors of other packages");
    for (const std::string& problem : problems_) text += "; " + problem;
    return text;
  }

  /// One per file, so that a bad one does no harm to the others.
  Loader& loaderOf(const std::string& file) {
    std::unique_ptr<Loader>& loader = loaders_[file];
    if (!loader) {
      loader = std::make_unique<Loader>(kPackage, kBase, kAttribute, std::vector<std::string>{file});
    }
    return *loader;
  }

  std::map<std::string, std::string> files_;  ///< by name of the selector
  std::map<std::string, std::unique_ptr<Loader>> loaders_;
  std::vector<std::string> problems_;
};

/// A registry under its lock. The lock is recursive, since a selector's constructor may create others.
class Plugins {
 public:
  /// The process's own. It is never destroyed: the libraries' code must stay for selectors that end later.
  static Plugins& instance() {
    static Plugins& plugins = *new Plugins;
    return plugins;
  }

  std::unique_ptr<core::Selector> create(const std::string& name) {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    return registry_.create(name);
  }

  std::vector<std::string> search() {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    registry_.search();
    return registry_.names();
  }

  std::vector<std::string> problems() {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    return registry_.problems();
  }

 private:
  std::recursive_mutex mutex_;
  Registry registry_;
};

}  // namespace

void enableSelectorPlugins() {
  core::setSelectorLoader([](const std::string& name) { return Plugins::instance().create(name); });
}

std::vector<std::string> selectorPlugins() { return Plugins::instance().search(); }

std::vector<std::string> selectorPluginProblems() { return Plugins::instance().problems(); }

}  // namespace corrsel
