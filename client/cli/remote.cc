#include "client/cli/remote.h"

#include <ctime>

#include "core/base/error.h"
#include "core/base/ids.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {

absl::StatusOr<v1::Map> FindMap(const Connection& connection, const Globals& globals, const std::string& map) {
  v1::ListMapsRequest by_display_name;
  by_display_name.set_parent(SiteNameOf(globals));
  by_display_name.set_display_name(map);
  ENFILADE_ASSIGN_OR_RETURN(const v1::ListMapsResponse named,
                            connection.Call(&v1::MapService::Stub::ListMaps, by_display_name));
  if (!map.empty() && named.maps_size() == 1) return named.maps(0);

  v1::GetMapRequest by_id;
  by_id.set_name(IsValidResourceId(map) ? SiteNameOf(globals) + "/maps/" + map : map);
  if (by_id.name().rfind("sites/", 0) == 0) {
    const auto found = connection.Call(&v1::MapService::Stub::GetMap, by_id);
    if (found.ok()) return found->map();
    if (!absl::IsNotFound(found.status()) && !absl::IsInvalidArgument(found.status())) return found.status();
  }
  return NotFound("site \"{}\" has no map \"{}\": see `enfilade map list`", globals.site, map);
}

std::string TimeInWords(const google::protobuf::Timestamp& time) {
  if (time.seconds() == 0) return "";
  const auto seconds = static_cast<std::time_t>(time.seconds());
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  return std::string(text, std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S", &utc));
}

std::string IdOf(const std::string& name) { return name.substr(name.rfind('/') + 1); }

}  // namespace enfilade::cli
