#include "programs/benchmark/node_name.h"

#include <fcntl.h>
#include <ros/names.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "programs/xml_rpc.h"

namespace corrsel {
namespace {

/// The name that benchmark.launch gives the node: nobody chose it for this run.
constexpr char kLaunchedName[] = "benchmark";

std::string fromEnvironment(const char* variable, const std::string& otherwise) {
  const char* const value = std::getenv(variable);
  return value && *value ? value : otherwise;
}

/// The value of `key:=value`, the last one as in ros::init().
std::optional<std::string> remapped(const std::vector<std::string>& words, const std::string& key) {
  std::optional<std::string> value;
  const std::string beginning = key + ":=";
  for (const std::string& word : words) {
    if (word.compare(0, beginning.size(), beginning) == 0) value = word.substr(beginning.size());
  }
  return value;
}

/// Whether a node of this name is registered and replies. A node that crashed stays registered, and its name
/// is free.
bool isAlive(const std::string& master, const std::string& node) {
  XmlRpc::XmlRpcValue lookup, caller;
  lookup[0] = caller[0] = std::string("/benchmark");
  lookup[1] = node;
  const std::optional<XmlRpc::XmlRpcValue> uri = callXmlRpc(master, "lookupNode", lookup);
  if (!uri || uri->getType() != XmlRpc::XmlRpcValue::TypeString) return false;
  XmlRpc::XmlRpcValue text = *uri;
  return callXmlRpc(static_cast<std::string>(text), "getPid", caller).has_value();
}

/// Waits until no other program of this user is choosing a name. @return descriptor of the lock; -1 without a
/// lock
int lockNames() {
  const std::string file = "corrsel_node_names_" + std::to_string(getuid());
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  const int lock = open((folder / file).c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (lock >= 0) flock(lock, LOCK_EX);
  return lock;
}

}  // namespace

NodeName::NodeName(const std::vector<std::string>& words, const std::string& usual) {
  const std::optional<std::string> given = remapped(words, "__name");
  if (given && *given != kLaunchedName) return;
  const std::string wanted = given ? *given : usual;
  const std::string master =
      remapped(words, "__master").value_or(fromEnvironment("ROS_MASTER_URI", "http://localhost:11311"));
  const std::string space = remapped(words, "__ns").value_or(fromEnvironment("ROS_NAMESPACE", ""));
  const auto resolved = [&space](const std::string& name) {
    return ros::names::clean("/" + space + "/" + name);
  };
  lock_ = lockNames();
  std::string name = wanted;
  for (int k = 2; isAlive(master, resolved(name)); ++k) name = wanted + "_" + std::to_string(k);
  chosen_ = name;
  if (name == wanted) return;
  note_ = "another node is called " + resolved(wanted) + ", so this one is called " + resolved(name) +
          " and publishes " + resolved(name) + "/progress and " + resolved(name) + "/score";
}

NodeName::~NodeName() {
  if (lock_ >= 0) close(lock_);
}

}  // namespace corrsel
