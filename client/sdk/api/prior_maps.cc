// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/prior_maps.h"

#include <utility>

#include "client/sdk/api/file_folder.h"
#include "client/sdk/api/file_upload.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "io/file.h"
#include "proto/convert/names.h"

namespace enfilade::client {

absl::StatusOr<v1::PriorMap> FindPriorMap(const Connection& connection, const SiteId& site,
                                          const std::string& prior_map) {
  v1::ListPriorMapsRequest all;
  all.set_parent(NameOf(site));
  all.set_page_size(kMaxPageSize);
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::PriorMap> listed,
      ListAll(connection, &v1::PriorMapService::Stub::ListPriorMaps, all, &v1::ListPriorMapsResponse::prior_maps));
  for (const v1::PriorMap& one : listed) {
    if (one.display_name() == prior_map) return one;
  }
  v1::GetPriorMapRequest by_name;
  by_name.set_name(IsValidResourceId(prior_map) ? convert::NameOf(convert::PriorMapName{site, PriorMapId(prior_map)})
                                                : prior_map);
  if (by_name.name().starts_with("sites/")) {
    const auto found = connection.Call(&v1::PriorMapService::Stub::GetPriorMap, by_name);
    if (found.ok()) return found->prior_map();
    if (!absl::IsNotFound(found.status()) && !absl::IsInvalidArgument(found.status())) return found.status();
  }
  return NotFound("site \"{}\" has no prior map \"{}\": see `enfilade prior list`", site.value(), prior_map);
}

absl::StatusOr<v1::PriorMap> ImportPriorMap(const Connection& connection, v1::ImportPriorMapManifest manifest,
                                            const NamedFile& file, const TransferProgress& progress) {
  *manifest.mutable_file() = EntryOf(file);
  v1::ImportPriorMapRequest message;
  *message.mutable_manifest() = std::move(manifest);
  v1::PriorMapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  v1::ImportPriorMapResponse response;
  const auto writer = stub.ImportPriorMap(&context, &response);
  ENFILADE_RETURN_IF_ERROR(SendFiles(connection, *writer, message, absl::MakeConstSpan(&file, 1), progress));
  return response.prior_map();
}

absl::StatusOr<v1::PriorMap> ImportPriorMap(const Connection& connection, v1::ImportPriorMapManifest manifest,
                                            const std::filesystem::path& file, const TransferProgress& progress) {
  ENFILADE_ASSIGN_OR_RETURN(std::string bytes, io::ReadFile(file));
  return ImportPriorMap(connection, std::move(manifest), NamedFile{file.filename().string(), std::move(bytes)},
                        progress);
}

absl::StatusOr<std::vector<std::filesystem::path>> ExportPriorMap(const Connection& connection, const std::string& name,
                                                                  absl::Span<const v1::PriorMapProduct> products,
                                                                  const std::filesystem::path& folder,
                                                                  const TransferProgress& progress) {
  ENFILADE_RETURN_IF_ERROR(CreateFolder(folder));
  v1::ExportPriorMapRequest request;
  request.set_name(name);
  for (const v1::PriorMapProduct product : products) request.add_products(product);
  v1::PriorMapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  const auto ignore = [](const v1::ExportPriorMapManifest&) {};
  ENFILADE_ASSIGN_OR_RETURN(SavedFiles saved, SaveFiles(connection, context, stub.ExportPriorMap(&context, request),
                                                        folder, ignore, progress));
  return std::move(saved.files);
}

}  // namespace enfilade::client
