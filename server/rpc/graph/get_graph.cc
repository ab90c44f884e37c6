// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <string>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "proto/convert/names.h"
#include "server/app/graph/graph_page.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"
#include "server/rpc/paging.h"

namespace enfilade::server {
namespace {

// Maps, link points and edges of an answer without pages: some 2 MB, below what clients of gRPC take by default.
constexpr std::size_t kMaxWhole = 10'000;

// Pages are of one version, so that places in the lists stay what they are.
struct GraphPageKey {
  std::int64_t version = 0;
  GraphPosition position;
};

std::string ToToken(const GraphPageKey& key) {
  const GraphPosition& at = key.position;
  return ToPageToken(
      fmt::format("{}/{}/{}/{}/{}", key.version, static_cast<int>(at.part), at.index, at.first, at.second));
}

absl::StatusOr<GraphPageKey> FromToken(const std::string& token) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, FromPageToken(token));
  long long version = 0;
  unsigned part = 0;
  GraphPageKey key;
  int end = 0;
  const int read = std::sscanf(text.c_str(), "%lld/%u/%zu/%zu/%zu%n", &version, &part, &key.position.index,
                               &key.position.first, &key.position.second, &end);
  if (read != 5 || end != static_cast<int>(text.size()) || part > 2 || version < 1) {
    return InvalidArgument("page_token is not from this call");
  }
  key.version = version;
  key.position.part = static_cast<GraphPosition::Part>(part);
  return key;
}

absl::Status CheckFitsOneAnswer(const SiteGraph& graph) {
  const graph::GraphSnapshot& snapshot = graph.graph();
  const std::size_t edges = CountEdges(snapshot);
  if (snapshot.map_count() + snapshot.link_point_count() + edges <= kMaxWhole) return absl::OkStatus();
  return ResourceExhausted(
      "the graph has {} maps, {} link points and {} edges, more than {} for one answer: set page_size and follow "
      "next_page_token",
      snapshot.map_count(), snapshot.link_point_count(), edges, kMaxWhole);
}

absl::StatusOr<v1::GetGraphResponse> GetPage(const Services& services, const Call& call, const SiteId& site,
                                             const v1::GetGraphRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const int page_size, PageSize(request.page_size()));
  GraphPageKey key{.version = request.graph_version(), .position = {}};
  if (!request.page_token().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(key, FromToken(request.page_token()));
    if (request.graph_version() != 0 && request.graph_version() != key.version) {
      return InvalidArgument("graph_version is {}, but page_token continues version {}", request.graph_version(),
                             key.version);
    }
  }
  const auto graph = services.graphs.GetVersion(call.context(), site, key.version);
  if (absl::IsNotFound(graph.status()) && !request.page_token().empty()) {
    return Aborted("version {} of the graph, of which the first page was, is gone: begin again", key.version);
  }
  ENFILADE_RETURN_IF_ERROR(graph.status());
  const GraphPage page = ListPage(**graph, key.position, static_cast<std::size_t>(page_size), request.with_edges());
  v1::GetGraphResponse response;
  *response.mutable_graph() = ToProto(site, **graph, page);
  if (page.next) response.set_next_page_token(ToToken({(*graph)->graph().version(), *page.next}));
  return response;
}

}  // namespace

absl::StatusOr<v1::GetGraphResponse> GetGraph(const Services& services, const Call& call,
                                              const v1::GetGraphRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  if (request.graph_version() < 0) return InvalidArgument("graph_version is {}: negative", request.graph_version());
  if (request.page_size() != 0 || !request.page_token().empty()) return GetPage(services, call, site, request);
  ENFILADE_ASSIGN_OR_RETURN(const auto graph,
                            services.graphs.GetVersion(call.context(), site, request.graph_version()));
  ENFILADE_RETURN_IF_ERROR(CheckFitsOneAnswer(*graph));
  v1::GetGraphResponse response;
  *response.mutable_graph() = ToProto(site, *graph);
  return response;
}

}  // namespace enfilade::server
