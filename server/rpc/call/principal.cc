// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/principal.h"

#include "fmt/format.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxNameBytes = 200;

}  // namespace

Principal IdentifyPrincipal(std::string_view certificate, std::string_view actor) {
  if (certificate.empty()) return {.name = std::string(actor.substr(0, kMaxNameBytes)), .authenticated = false};
  std::string name(certificate.substr(0, kMaxNameBytes));
  if (!actor.empty() && actor != certificate) name = fmt::format("{} (says: {})", name, actor).substr(0, kMaxNameBytes);
  return {.name = std::move(name), .authenticated = true};
}

}  // namespace enfilade::server
