// SPDX-License-Identifier: Apache-2.0
#include "client/cli/remote.h"

#include <ctime>
#include <iostream>
#include <vector>

#include "client/sdk/api/maps.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

client::Connection ConnectionOf(const Globals& globals) {
  client::Credentials credentials;
  if (!globals.tls.empty()) {
    auto made = client::Credentials::Tls(globals.tls, [](const absl::StatusOr<io::CheckedTls>& tls) {
      if (tls.ok()) return;
      std::cerr << "enfilade: the TLS files have changed, and are not used: " << tls.status().message() << '\n';
    });
    if (!made.ok()) throw CommandFailed{made.status()};
    credentials = *std::move(made);
  }
  return {globals.server, std::chrono::duration<double>(globals.timeout_s), globals.actor, std::move(credentials)};
}

std::string ResourceNameOf(const Globals& globals, const std::string& collection, const std::string& id) {
  return id.starts_with("sites/") ? id : SiteNameOf(globals) + "/" + collection + "/" + id;
}

absl::StatusOr<v1::Map> FindMap(const client::Connection& connection, const Globals& globals, const std::string& map) {
  return client::FindMap(connection, SiteId(globals.site), map);
}

absl::StatusOr<PoseInMap> FindPoseInMap(const client::Connection& connection, const Globals& globals,
                                        const std::string& text) {
  ENFILADE_ASSIGN_OR_RETURN(PoseInMap found, ParsePoseInMap(text));
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, found.map));
  found.map = map.name();
  return found;
}

std::string FormatTime(const google::protobuf::Timestamp& time) {
  if (time.seconds() == 0) return "";
  const auto seconds = static_cast<std::time_t>(time.seconds());
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  return std::string(text, std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S", &utc));
}

nlohmann::json PoseToJson(const v1::PoseWithCovariance& pose) {
  return {{"x", pose.pose().x()},
          {"y", pose.pose().y()},
          {"yaw", pose.pose().yaw()},
          {"covariance", std::vector<double>(pose.covariance().begin(), pose.covariance().end())}};
}

std::string IdOf(const std::string& name) { return name.empty() ? "-" : name.substr(name.rfind('/') + 1); }

}  // namespace enfilade::cli
