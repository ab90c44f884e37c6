// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/graph_export.h"

#include "client/sdk/api/chunks.h"
#include "client/sdk/api/file_download.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<ExportedGraph> ExportGraph(const Connection& connection, const SiteId& site,
                                          const GraphContent& content) {
  v1::ExportGraphRequest request;
  request.set_site(NameOf(site));
  request.set_without_edges(!content.with_edges);
  v1::GraphService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  connection.SetMinGraphVersions(context);
  connection.SetDeadline(context);
  ExportedGraph graph;
  const auto start = [&](const v1::ExportGraphManifest& manifest) {
    graph.version = manifest.graph_version();
    return manifest.files_size() == 1 ? absl::OkStatus()
                                      : absl::DataLossError("the server's manifest is not of one file");
  };
  const auto take = [&](const v1::FileChunk& chunk) {
    graph.geojson += chunk.data();
    return absl::OkStatus();
  };
  ENFILADE_RETURN_IF_ERROR(ReceiveFiles(connection, context, stub.ExportGraph(&context, request),
                                        FileSink<decltype(start), decltype(take)>{start, take, {}}));
  return graph;
}

}  // namespace enfilade::client
