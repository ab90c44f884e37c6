// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/cli/pose_in_map.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "enfilade/v1/geometry.pb.h"
#include "enfilade/v1/map.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// What the commands that call a server share.

// Throws CommandFailed if the TLS files are not what they should be.
client::Connection ConnectionOf(const Globals& globals);

// sites/{--site}
inline std::string SiteNameOf(const Globals& globals) { return "sites/" + globals.site; }

// The resource name below the site that a person means by an id or a resource name:
// ResourceNameOf(globals, "sessions", "monday") is "sites/default/sessions/monday".
std::string ResourceNameOf(const Globals& globals, const std::string& collection, const std::string& id);

// The map that a person means by its display name, its id or its resource name, in this order. NOT_FOUND.
absl::StatusOr<v1::Map> FindMap(const client::Connection& connection, const Globals& globals, const std::string& map);

// A pose in a map, with the map's resource name. `text`: MAP,X,Y[,YAW]. INVALID_ARGUMENT; NOT_FOUND: no such map.
absl::StatusOr<PoseInMap> FindPoseInMap(const client::Connection& connection, const Globals& globals,
                                        const std::string& text);

// "2026-11-20 23:41:35" UTC; empty for an unset time.
std::string FormatTime(const google::protobuf::Timestamp& time);

// x, y, yaw (m, rad) and the covariance's nine numbers, row by row.
nlohmann::json PoseToJson(const v1::PoseWithCovariance& pose);

// The last segment of a resource name; "-" for none.
std::string IdOf(const std::string& name);

}  // namespace enfilade::cli
