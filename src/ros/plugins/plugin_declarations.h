#pragma once

#include <map>
#include <string>
#include <vector>

namespace corrsel {

constexpr const char* kPluginPackage = "corrsel";
constexpr const char* kPluginAttribute = "plugin";

/// What a kind of plug-ins is called.
struct PluginKind {
  const char* base;  ///< the base class, as plug-in files spell it, e.g. "corrsel::Selector"
  const char* noun;  ///< in messages, e.g. "selector"
};

/// The plug-ins of one kind that packages on ROS_PACKAGE_PATH declare. Not thread-safe.
class PluginDeclarations {
 public:
  explicit PluginDeclarations(const PluginKind& kind) : kind_(kind) {}

  /// Looks through all packages anew, which takes about 0.1 s.
  void search();

  /// The file that declares a plug-in; null where there is none.
  const std::string* fileOf(const std::string& name) const;

  /// Those of other packages, sorted.
  std::vector<std::string> names() const;

  /// Why declared plug-ins are not available: one sentence for each.
  const std::vector<std::string>& problems() const { return problems_; }

  /// A sentence about a name that nobody declares, with the names that exist and the problems.
  std::string unknown(const std::string& name) const;

 private:
  void add(const std::string& file, std::map<std::string, std::vector<std::string>>& declared);

  const PluginKind kind_;
  std::map<std::string, std::string> files_;  ///< by name of the plug-in
  std::vector<std::string> problems_;
};

}  // namespace corrsel
