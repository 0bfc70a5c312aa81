#pragma once

#include <optional>
#include <string>
#include <vector>

namespace corrsel {

/// Holds the name of this node free from the moment it is chosen until the node is registered: programs of
/// this machine that choose a name in the meantime wait.
class NodeName {
 public:
  /// The master stops the node that has a name as soon as another node registers it, and roslaunch gives a
  /// second benchmark the name of the first. Therefore a name that a living node has is replaced:
  /// benchmark_2, benchmark_3 and so on. Names that the user chose are kept as they are.
  /// @param words   command line, of which `__name:=x`, `__ns:=x` and `__master:=x` are read
  /// @param usual   name where the command line has none; without slashes
  NodeName(const std::vector<std::string>& words, const std::string& usual);
  ~NodeName();
  NodeName(const NodeName&) = delete;
  NodeName& operator=(const NodeName&) = delete;

  /// For ros::init(), which must not see `__name:=x` then; none where the user's choice stays.
  const std::optional<std::string>& chosen() const { return chosen_; }

  /// What the user should know: which node has the usual name, and where this one publishes; empty if
  /// nothing.
  const std::string& note() const { return note_; }

 private:
  std::optional<std::string> chosen_;
  std::string note_;
  int lock_ = -1;  ///< file descriptor
};

}  // namespace corrsel
