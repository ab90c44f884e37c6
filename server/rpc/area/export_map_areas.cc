// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/areas/area_files.h"
#include "core/areas/area_geojson.h"
#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/ids.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/area/convert.h"
#include "server/rpc/area/handlers.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kAreaChunkBytes = 1U << 20;
constexpr int kAreasPerPage = 1'000;

// The areas that are asked for.
struct AreaChoice {
  std::string robot_type;      // empty: of any
  std::optional<TimeNs> time;  // unset: whenever they hold
};

absl::StatusOr<AreaChoice> AreaChoiceOf(const v1::ExportMapAreasRequest& request) {
  AreaChoice choice{.robot_type = request.robot_type(), .time = std::nullopt};
  if (!choice.robot_type.empty() && !IsValidResourceId(choice.robot_type)) {
    return InvalidArgument("robot_type is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\", or none for all areas",
                           Excerpt(choice.robot_type, 100));
  }
  if (request.has_time()) {
    const absl::StatusOr<TimeNs> time = convert::FromTimestamp(request.time());
    if (!time.ok()) return WithContext(time.status(), "time");
    choice.time = *time;
  } else if (request.format() != v1::MAP_AREA_FORMAT_GEOJSON) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    choice.time = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  }
  return choice;
}

absl::StatusOr<std::vector<areas::MapArea>> ReadAreasOf(const Services& services, const Call& call,
                                                        const storage::Map& map, const AreaChoice& choice,
                                                        std::initializer_list<areas::AreaKind> kinds) {
  std::vector<areas::MapArea> chosen;
  for (const areas::AreaKind kind : kinds) {
    ENFILADE_ASSIGN_OR_RETURN(auto stored, services.map_areas.ListOf(call.context(), map.site, map.id, kind));
    for (storage::MapArea& area : stored) {
      if (areas::HoldsFor(area.area, choice.robot_type, choice.time)) chosen.push_back(std::move(area.area));
    }
  }
  return chosen;
}

absl::StatusOr<std::vector<grid::MapFile>> RenderAreasGeoJson(const Services& services, const Call& call,
                                                              const storage::Map& map, const AreaChoice& choice) {
  std::vector<areas::NamedArea> chosen;
  storage::PageRequest page{.limit = kAreasPerPage, .after = ""};
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(auto stored, services.map_areas.List(call.context(), map.site, map.id, page));
    if (stored.empty()) break;
    page.after = stored.back().id.value();
    for (storage::MapArea& area : stored) {
      if (areas::HoldsFor(area.area, choice.robot_type, choice.time)) {
        chosen.push_back({std::move(area.id), std::move(area.area)});
      }
    }
  }
  std::vector<grid::MapFile> files;
  files.push_back({"areas.geojson", areas::WriteAreasGeoJson(chosen)});
  return files;
}

// The cells of a mask: those of the map's newest revision.
absl::StatusOr<grid::GridGeometry> CellsOf(const Services& services, const Call& call, const storage::Map& map) {
  if (map.current_revision == 0) {
    return FailedPrecondition("{} has no revision yet: a mask has the cells of a map's newest one",
                              NameOf(map.site, map.id));
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            services.revisions.Get(call.context(), map.site, map.id, 0));
  return revision.geometry;
}

absl::StatusOr<std::vector<grid::MapFile>> RenderAreas(const Services& services, const Call& call,
                                                       const storage::Map& map, v1::MapAreaFormat format,
                                                       const AreaChoice& choice) {
  if (format == v1::MAP_AREA_FORMAT_GEOJSON) return RenderAreasGeoJson(services, call, map, choice);
  ENFILADE_ASSIGN_OR_RETURN(const grid::GridGeometry cells, CellsOf(services, call, map));
  using areas::AreaKind;
  if (format == v1::MAP_AREA_FORMAT_NAV2_KEEPOUT) {
    ENFILADE_ASSIGN_OR_RETURN(const auto chosen,
                              ReadAreasOf(services, call, map, choice, {AreaKind::kKeepOut, AreaKind::kPreferred}));
    return areas::RenderKeepOutMask(chosen, cells);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto chosen, ReadAreasOf(services, call, map, choice, {AreaKind::kSpeedLimit}));
  return areas::RenderSpeedMask(chosen, cells);
}

// The manifest first, then the files chunk by chunk.
class AreaFiles {
 public:
  explicit AreaFiles(std::vector<grid::MapFile> files)
      : files_(std::make_shared<const std::vector<grid::MapFile>>(std::move(files))) {}

  absl::StatusOr<bool> operator()(v1::ExportMapAreasResponse& message) {
    message.Clear();
    if (!std::exchange(manifest_sent_, true)) {
      for (const grid::MapFile& file : *files_) {
        v1::FileEntry& entry = *message.mutable_manifest()->add_files();
        entry.set_name(file.name);
        entry.set_size_bytes(static_cast<std::int64_t>(file.bytes.size()));
        entry.set_sha256(Sha256(file.bytes));
      }
      return true;
    }
    while (file_ < files_->size() && offset_ == (*files_)[file_].bytes.size()) ++file_, offset_ = 0;
    if (file_ == files_->size()) return false;
    v1::FileChunk& chunk = *message.mutable_chunk();
    chunk.set_file(static_cast<std::int32_t>(file_));
    chunk.set_offset(static_cast<std::int64_t>(offset_));
    chunk.set_data((*files_)[file_].bytes.substr(offset_, kAreaChunkBytes));
    offset_ += chunk.data().size();
    return true;
  }

 private:
  std::shared_ptr<const std::vector<grid::MapFile>> files_;  // a source may be copied
  bool manifest_sent_ = false;
  std::size_t file_ = 0;
  std::size_t offset_ = 0;
};

}  // namespace

absl::StatusOr<MessageSource<v1::ExportMapAreasResponse>> ExportMapAreas(const Services& services, const Call& call,
                                                                         const v1::ExportMapAreasRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName parent, convert::ParseMapName("parent", request.parent()));
  if (request.format() == v1::MAP_AREA_FORMAT_UNSPECIFIED || !v1::MapAreaFormat_IsValid(request.format())) {
    return InvalidArgument("format is {}: expected MAP_AREA_FORMAT_GEOJSON, _NAV2_KEEPOUT or _NAV2_SPEED",
                           static_cast<int>(request.format()));
  }
  ENFILADE_ASSIGN_OR_RETURN(const AreaChoice choice, AreaChoiceOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, services.maps.Get(call.context(), parent.site, parent.map));
  ENFILADE_ASSIGN_OR_RETURN(auto files, RenderAreas(services, call, map, request.format(), choice));
  return AreaFiles(std::move(files));
}

}  // namespace enfilade::server
