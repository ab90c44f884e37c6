// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace enfilade::server {

// The id in "sites/{site}" or "sites/{site}/..."; empty if `name` is not of this form.
std::string SiteOfName(std::string_view name);

// The id of the site that a request names first, in any of the fields that hold resource names; empty if in none.
template <typename Request>
std::string SiteOf(const Request& request) {
  std::string site;
  const auto read = [&site](const auto& field) {
    if (!site.empty()) return;
    if constexpr (requires { field.name(); }) {
      site = SiteOfName(field.name());
    } else if constexpr (requires { field.map(); }) {
      site = SiteOfName(field.map());
    } else if constexpr (requires { SiteOfName(field); }) {
      site = SiteOfName(field);
    }
  };
  if constexpr (requires { request.parent(); }) read(request.parent());
  if constexpr (requires { request.name(); }) read(request.name());
  if constexpr (requires { request.site(); }) read(request.site());
  if constexpr (requires { request.map(); }) read(request.map());
  if constexpr (requires { request.prior_map(); }) read(request.prior_map());
  if constexpr (requires { request.link_point(); }) read(request.link_point());
  if constexpr (requires { request.session(); }) read(request.session());
  if constexpr (requires { request.robot(); }) read(request.robot());
  if constexpr (requires { request.area(); }) read(request.area());
  if constexpr (requires { request.alias(); }) read(request.alias());
  if constexpr (requires { request.base(); }) read(request.base());
  if constexpr (requires { request.map_a(); }) read(request.map_a());
  if constexpr (requires { request.map_pose(); }) read(request.map_pose());
  if constexpr (requires { request.source_map(); }) read(request.source_map());
  if constexpr (requires { request.start_map(); }) read(request.start_map());
  // Of streams: their first message.
  if constexpr (requires { request.manifest().parent(); }) read(request.manifest().parent());
  if constexpr (requires { request.open().session(); }) read(request.open().session());
  return site;
}

}  // namespace enfilade::server
