// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/principal.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxNameBytes = 200;

}  // namespace

Principal IdentifyPrincipal(std::string_view actor) {
  return {.name = std::string(actor.substr(0, kMaxNameBytes)), .authenticated = false};
}

}  // namespace enfilade::server
