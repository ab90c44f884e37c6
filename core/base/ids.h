// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace enfilade {

// The id of one resource: the last segment of its resource name ("sites/{site}" -> SiteId). Typed, so that a map's id
// cannot be passed for a session's. Valid ids match [a-z0-9]([a-z0-9-]{0,61}[a-z0-9])? (AIP-122); `IsValidResourceId`
// checks, the type itself does not.
template <typename Tag>
class Id {
 public:
  Id() = default;
  explicit Id(std::string value) : value_(std::move(value)) {}

  const std::string& value() const { return value_; }
  bool empty() const { return value_.empty(); }

  friend auto operator<=>(const Id&, const Id&) = default;

 private:
  std::string value_;
};

using SiteId = Id<struct SiteTag>;
using MapId = Id<struct MapTag>;
using MapDraftId = Id<struct MapDraftTag>;
using MapAreaId = Id<struct MapAreaTag>;
using MapAliasId = Id<struct MapAliasTag>;
using PriorMapId = Id<struct PriorMapTag>;
using LinkPointId = Id<struct LinkPointTag>;
using RobotId = Id<struct RobotTag>;
using SessionId = Id<struct SessionTag>;

inline bool IsValidResourceId(std::string_view id) {
  const auto alphanumeric = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  if (id.empty() || id.size() > 63 || !alphanumeric(id.front()) || !alphanumeric(id.back())) return false;
  for (const char c : id) {
    if (!alphanumeric(c) && c != '-') return false;
  }
  return true;
}

}  // namespace enfilade

template <typename Tag>
struct std::hash<enfilade::Id<Tag>> {
  std::size_t operator()(const enfilade::Id<Tag>& id) const { return std::hash<std::string>()(id.value()); }
};
