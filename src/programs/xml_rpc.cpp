#include "programs/xml_rpc.h"

#include <ros/network.h>

#include <cstdint>

namespace corrsel {

std::optional<XmlRpc::XmlRpcValue> callXmlRpc(const std::string& uri, const std::string& method,
                                              const XmlRpc::XmlRpcValue& arguments) {
  constexpr int kSuccess = 1;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return {};
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  XmlRpc::XmlRpcValue reply;  // code, message, value
  const bool replied = client.execute(method.c_str(), arguments, reply) && !client.isFault();
  client.close();
  const bool complete = replied && reply.getType() == XmlRpc::XmlRpcValue::TypeArray && reply.size() == 3;
  if (!complete || static_cast<int>(reply[0]) != kSuccess) return {};
  return reply[2];
}

}  // namespace corrsel
