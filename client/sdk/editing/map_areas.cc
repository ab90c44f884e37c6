// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/editing/map_areas.h"

#include <utility>

#include "client/sdk/api/file_folder.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/ids.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"

namespace enfilade::client {

using MapAreaStub = v1::MapAreaService::Stub;

absl::StatusOr<std::vector<v1::MapArea>> ListMapAreas(const Connection& connection, const std::string& map) {
  v1::ListMapAreasRequest request;
  request.set_parent(map);
  request.set_page_size(kMaxPageSize);
  return ListAll(connection, &MapAreaStub::ListMapAreas, request, &v1::ListMapAreasResponse::areas);
}

absl::StatusOr<v1::MapArea> FindMapArea(const Connection& connection, const std::string& map, const std::string& area) {
  v1::GetMapAreaRequest request;
  request.set_name(IsValidResourceId(area) ? map + "/areas/" + area : area);
  if (request.name().starts_with("sites/")) {
    const auto found = connection.Call(&MapAreaStub::GetMapArea, request);
    if (found.ok()) return found->area();
    if (!absl::IsNotFound(found.status()) && !absl::IsInvalidArgument(found.status())) return found.status();
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapArea> listed, ListMapAreas(connection, map));
  const v1::MapArea* by_name = nullptr;
  for (const v1::MapArea& one : listed) {
    if (one.display_name() != area) continue;
    if (by_name != nullptr) {
      return FailedPrecondition("{} and {} are both named \"{}\": give the id", by_name->name(), one.name(), area);
    }
    by_name = &one;
  }
  if (by_name != nullptr) return *by_name;
  return NotFound("{} has no area \"{}\": see `enfilade area list`", map, area);
}

absl::StatusOr<std::vector<std::filesystem::path>> ExportMapAreas(const Connection& connection,
                                                                  const v1::ExportMapAreasRequest& request,
                                                                  const std::filesystem::path& folder,
                                                                  const TransferProgress& progress) {
  ENFILADE_RETURN_IF_ERROR(CreateFolder(folder));
  MapAreaStub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  const auto ignore = [](const v1::ExportMapAreasManifest&) {};
  ENFILADE_ASSIGN_OR_RETURN(SavedFiles saved, SaveFiles(connection, context, stub.ExportMapAreas(&context, request),
                                                        folder, ignore, progress));
  return std::move(saved.files);
}

}  // namespace enfilade::client
