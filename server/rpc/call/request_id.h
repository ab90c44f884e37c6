// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace enfilade::server {

// Whether a request id may go into logs and metadata: 1 to 128 letters, digits and "-_.:/+=".
bool IsValidRequestId(std::string_view id);

// 16 random hexadecimal digits. Thread-safe.
std::string NewRequestId();

// `given`, the request metadata `x-request-id`, if it is valid; else a new one.
std::string RequestIdOrNew(std::string_view given);

}  // namespace enfilade::server
