// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

absl::StatusOr<storage::LinkPointFilter> FilterOf(const SiteId& site, const v1::ListLinkPointsRequest& request) {
  storage::LinkPointFilter filter;
  if (!request.map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(filter.map, MapOfSite("map", site, request.map()));
  }
  ENFILADE_ASSIGN_OR_RETURN(filter.candidate, CandidatesOf(request.subset()));
  if (!v1::LinkPoint::Kind_IsValid(request.kind()) || !v1::LinkPoint::State_IsValid(request.state()) ||
      !v1::LinkPoint::Use_IsValid(request.use())) {
    return InvalidArgument("kind {}, state {} or use {} is unknown to this server", static_cast<int>(request.kind()),
                           static_cast<int>(request.state()), static_cast<int>(request.use()));
  }
  if (request.kind() != 0) filter.kind = static_cast<graph::LinkPointKind>(request.kind());
  if (request.state() != 0) filter.state = static_cast<graph::PassageState>(request.state());
  if (request.use() != 0) filter.use = static_cast<graph::LinkPointUse>(request.use());
  if (!request.tag().empty()) filter.tag = request.tag();
  return filter;
}

}  // namespace

absl::StatusOr<v1::ListLinkPointsResponse> ListLinkPoints(const Services& services, const Call& call,
                                                          const v1::ListLinkPointsRequest& request) {
  v1::ListLinkPointsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::LinkPointFilter filter, FilterOf(site, request));
  ENFILADE_ASSIGN_OR_RETURN(auto found, services.link_points.List(call.context(), site, filter, {size + 1, after}));
  if (CutToPage(found, size)) response.set_next_page_token(ToPageToken(found.back().point.id.value()));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::LinkPoint> link_points,
                            WithEvidence(services, call.context(), site, found));
  for (v1::LinkPoint& link_point : link_points) *response.add_link_points() = std::move(link_point);
  return response;
}

}  // namespace enfilade::server
