// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace enfilade {

// A random UUID (RFC 9562, version 4) in lower case, from the operating system's generator.
std::string NewUuid();

}  // namespace enfilade
