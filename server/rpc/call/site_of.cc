// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/site_of.h"

#include "core/base/ids.h"

namespace enfilade::server {

std::string SiteOfName(std::string_view name) {
  constexpr std::string_view kCollection = "sites/";
  if (!name.starts_with(kCollection)) return "";
  name.remove_prefix(kCollection.size());
  const std::string_view id = name.substr(0, name.find('/'));
  return IsValidResourceId(id) ? std::string(id) : "";
}

}  // namespace enfilade::server
