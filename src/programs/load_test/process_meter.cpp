#include "process_meter.h"

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>

#include "base/text.h"
#include "programs/xml_rpc.h"

namespace corrsel::load_test {
namespace {

/// Names of the nodes that publish a topic, by their fully resolved name.
std::set<std::string> publishersOf(const std::vector<std::string>& topics) {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  std::set<std::string> nodes;
  if (!ros::master::execute("getSystemState", request, response, state, false)) return nodes;
  for (int i = 0; i < state[0].size(); ++i) {
    if (std::find(topics.begin(), topics.end(), std::string(state[0][i][0])) == topics.end()) continue;
    for (int k = 0; k < state[0][i][1].size(); ++k) nodes.insert(std::string(state[0][i][1][k]));
  }
  return nodes;
}

/// @return the process number, 0 where the node does not run on this machine, -1 if it does not reply
int pidOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = node;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::master::execute("lookupNode", request, response, uri, false) ||
      !ros::network::splitURI(uri, host, port)) {
    return -1;
  }
  if (host != ros::network::getHost() && host != "localhost" && host.compare(0, 4, "127.") != 0) return 0;
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  std::optional<XmlRpc::XmlRpcValue> pid = callXmlRpc(uri, "getPid", caller);
  return pid ? static_cast<int>(*pid) : -1;
}

}  // namespace

ProcessMeter::ProcessMeter(const std::vector<std::string>& topics) {
  std::set<int> seen;
  for (const std::string& node : publishersOf(topics)) {
    const int pid = pidOf(node);
    if (pid < 0) notes_.push_back(node + " does not report its process number");
    if (pid == 0) notes_.push_back(node + " runs on another machine");
    if (pid > 0 && seen.insert(pid).second) processes_.push_back({pid, node});
  }
}

std::string ProcessMeter::text() const {
  std::vector<std::string> parts;
  for (const Process& process : processes_) {
    parts.push_back(process.node + " (pid " + std::to_string(process.pid) + ")");
  }
  parts.insert(parts.end(), notes_.begin(), notes_.end());
  return parts.empty() ? "no node" : core::joinList(parts);
}

ProcessMeter::Usage ProcessMeter::read() const {
  const double ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  Usage usage;
  for (const Process& process : processes_) {
    const std::string folder = "/proc/" + std::to_string(process.pid);
    const std::string stat = core::readTextFile(folder + "/stat");
    const std::string status = core::readTextFile(folder + "/status");
    const std::size_t resident = status.find("\nVmRSS:");
    if (stat.empty() || resident == std::string::npos) {  // a zombie has no memory any more
      usage.ended.push_back(process.node);
      continue;
    }
    // Fields are counted from the end of the name, which may hold blanks: utime and stime are 14 and 15 of
    // proc(5), the state behind the name is 3.
    std::istringstream fields(stat.substr(stat.rfind(')') + 1));
    std::string skipped;
    for (int field = 3; field < 14; ++field) fields >> skipped;
    double user = 0.0, system = 0.0;
    fields >> user >> system;
    usage.cpu_seconds += (user + system) / ticks;
    usage.resident_mib += std::stod(status.substr(resident + 7)) / 1024.0;
  }
  return usage;
}

}  // namespace corrsel::load_test
