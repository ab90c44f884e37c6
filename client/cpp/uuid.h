#pragma once

#include <string>

namespace enfilade::client {

// A random UUID (RFC 4122, version 4) in lower case, also valid as a resource id.
std::string NewUuid();

}  // namespace enfilade::client
