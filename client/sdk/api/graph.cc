// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/graph.h"

#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/graph_service.grpc.pb.h"

namespace enfilade::client {
namespace {

constexpr int kAttempts = 5;

absl::StatusOr<v1::Graph> ReadPages(const Connection& connection, v1::GetGraphRequest request) {
  v1::Graph graph;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const v1::GetGraphResponse page,
                              connection.Call(&v1::GraphService::Stub::GetGraph, request));
    graph.MergeFrom(page.graph());  // appends the items; all else is the same in all pages
    if (page.next_page_token().empty()) return graph;
    if (page.next_page_token() == request.page_token()) return Internal("the server repeats a page of the graph");
    request.set_page_token(page.next_page_token());
  }
}

}  // namespace

absl::StatusOr<v1::Graph> ReadGraph(const Connection& connection, const std::string& site, const GraphRead& read) {
  v1::GetGraphRequest request;
  request.set_site(site);
  request.set_graph_version(read.version);
  request.set_page_size(kMaxPageSize);
  request.set_with_edges(read.with_edges);
  absl::StatusOr<v1::Graph> graph;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    graph = ReadPages(connection, request);
    if (!absl::IsAborted(graph.status())) break;
  }
  return graph;
}

}  // namespace enfilade::client
