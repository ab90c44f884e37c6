// SPDX-License-Identifier: Apache-2.0
#include "client/cli/remote.h"

#include <ctime>
#include <vector>

#include "client/sdk/uplink/session_setup.h"
#include "core/base/ids.h"

namespace enfilade::cli {

std::string SessionNameOf(const Globals& globals, const std::string& session) {
  return session.rfind("sites/", 0) == 0 ? session : SiteNameOf(globals) + "/sessions/" + session;
}

absl::StatusOr<v1::Map> FindMap(const client::Connection& connection, const Globals& globals, const std::string& map) {
  return enfilade::client::FindMap(connection, SiteId(globals.site), map);
}

std::string TimeInWords(const google::protobuf::Timestamp& time) {
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

std::string IdOf(const std::string& name) { return name.substr(name.rfind('/') + 1); }

}  // namespace enfilade::cli
