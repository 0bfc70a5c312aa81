#pragma once

#include <dlfcn.h>

#include <map>
#include <memory>
#include <mutex>
#include <pluginlib/class_loader.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "ros/plugins/plugin_declarations.h"

namespace corrsel {

/// The plug-ins of one base class: what packages declare, and the libraries that have been loaded.
/// Thread-safe. The lock is recursive, since the constructor of a plug-in may create others.
///
/// It must never be destroyed: the libraries' code must stay for plug-ins that end later.
template <class Base>
class PluginLoader {
 public:
  explicit PluginLoader(const PluginKind& kind) : kind_(kind), declarations_(kind) {}

  /// Throws std::invalid_argument that names the plug-in, the file that declares it and the remedy.
  std::unique_ptr<Base> create(const std::string& name) {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    // A package may have been built, or changed, since.
    if (declarations_.fileOf(name) == nullptr) declarations_.search();
    const std::string* const file = declarations_.fileOf(name);
    if (file == nullptr) throw std::invalid_argument(declarations_.unknown(name));
    const std::string declared = kind_.noun + (" '" + name) + "' is declared in " + *file;
    try {
      // By the instance's own deleter a library could go while another one of its plug-ins is at work.
      Loader& loader = loaderOf(*file);
      std::unique_ptr<Base> plugin(loader.createUnmanagedInstance(name));
      // class_loader closes its libraries when the process ends, before the last plug-ins may.
      dlopen(loader.getClassLibraryPath(name).c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
      return plugin;
    } catch (const pluginlib::LibraryLoadException& error) {
      throw std::invalid_argument(declared +
                                  ", but its library cannot be loaded: build that package and source the "
                                  "setup.bash of its workspace. " +
                                  error.what());
    } catch (const pluginlib::PluginlibException& error) {
      throw std::invalid_argument(declared +
                                  ", but its library does not make it: the file's 'type' must be the class "
                                  "of PLUGINLIB_EXPORT_CLASS(class, " +
                                  kind_.base + "). " + error.what());
    }
  }

  /// Looks through all packages anew. @return the names of the plug-ins of other packages
  std::vector<std::string> search() {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    declarations_.search();
    return declarations_.names();
  }

  std::vector<std::string> problems() {
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    return declarations_.problems();
  }

 private:
  using Loader = pluginlib::ClassLoader<Base>;

  /// One per file, so that a bad one does no harm to the others.
  Loader& loaderOf(const std::string& file) {
    std::unique_ptr<Loader>& loader = loaders_[file];
    if (!loader) {
      loader = std::make_unique<Loader>(kPluginPackage, kind_.base, kPluginAttribute,
                                        std::vector<std::string>{file});
    }
    return *loader;
  }

  const PluginKind kind_;
  std::recursive_mutex mutex_;
  PluginDeclarations declarations_;
  std::map<std::string, std::unique_ptr<Loader>> loaders_;
};

}  // namespace corrsel
