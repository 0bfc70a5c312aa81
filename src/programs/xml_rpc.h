#pragma once

#include <xmlrpcpp/XmlRpc.h>

#include <optional>
#include <string>

namespace corrsel {

/// Calls a method of the master's or of a node's API and waits for the result. It works before ros::init(),
/// too.
/// @param uri  of the API, e.g. "http://localhost:11311/"
/// @return the value; none where nobody is there or the call fails
std::optional<XmlRpc::XmlRpcValue> callXmlRpc(const std::string& uri, const std::string& method,
                                              const XmlRpc::XmlRpcValue& arguments);

}  // namespace corrsel
