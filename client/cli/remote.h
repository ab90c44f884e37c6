// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/geometry.pb.h"
#include "enfilade/v1/map.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// What commands that talk to a server share.

inline client::Connection ConnectionOf(const Globals& globals) {
  return {globals.server, std::chrono::duration<double>(globals.timeout_s), globals.actor};
}

// sites/{--site}
inline std::string SiteNameOf(const Globals& globals) { return "sites/" + globals.site; }

// The resource name of the session that a person means: by its id or its resource name.
std::string SessionNameOf(const Globals& globals, const std::string& session);

// The map that a person means: by its display name, its id or its resource name, in this order. NOT_FOUND.
absl::StatusOr<v1::Map> FindMap(const client::Connection& connection, const Globals& globals, const std::string& map);

// "2026-11-20 23:41:35" UTC; empty for an unset time.
std::string TimeInWords(const google::protobuf::Timestamp& time);

// x, y, yaw (m, rad) and the covariance's nine numbers, row by row.
nlohmann::json PoseToJson(const v1::PoseWithCovariance& pose);

// The last segment of a resource name.
std::string IdOf(const std::string& name);

}  // namespace enfilade::cli
