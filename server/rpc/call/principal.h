// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace enfilade::server {

// Who makes a call.
struct Principal {
  std::string name;            // for the audit trail and logs; empty if the caller gave no name
  bool authenticated = false;  // whether `name` begins with what was proved, or is only what the caller says
};

// The principal of a call: at most 200 bytes of its name. `certificate`: the name in the client's certificate, which
// the handshake has checked; empty without one. `actor`: what the caller calls itself (request metadata
// `enfilade-actor`). With a certificate that is a note behind its name: "robot-7 (says: r7)".
Principal IdentifyPrincipal(std::string_view certificate, std::string_view actor);

}  // namespace enfilade::server
