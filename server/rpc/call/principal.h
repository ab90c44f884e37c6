// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace enfilade::server {

// Who makes a call.
struct Principal {
  std::string name;            // for the audit trail and logs; empty if the caller gave no name
  bool authenticated = false;  // whether `name` was proved, or is only what the caller says
};

// The principal of a call whose request metadata `enfilade-actor` is `actor`: at most its first 200 bytes, not
// authenticated. An authenticator belongs here: it reads credentials instead and sets `authenticated`.
Principal IdentifyPrincipal(std::string_view actor);

}  // namespace enfilade::server
