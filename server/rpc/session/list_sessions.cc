// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <optional>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {
namespace {

constexpr char kSeparator = '/';

}  // namespace

absl::StatusOr<v1::ListSessionsResponse> ListSessions(const Services& services, const Call& call,
                                                      const v1::ListSessionsRequest& request) {
  v1::ListSessionsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string key, FromPageToken(request.page_token()));
  std::optional<storage::SessionPosition> after;
  if (!key.empty()) {
    after.emplace();
    const auto time = std::from_chars(key.data(), key.data() + key.size(), after->create_time);
    if (time.ptr == key.data() + key.size() || *time.ptr != kSeparator) {
      return InvalidArgument("page_token is not from this call");
    }
    after->id = SessionId(std::string(time.ptr + 1, key.data() + key.size()));
  }
  ENFILADE_ASSIGN_OR_RETURN(auto sessions, services.sessions.List(call.context(), site, {}, size + 1, after));
  if (CutToPage(sessions, size)) {
    const storage::Session& last = sessions.back();
    response.set_next_page_token(ToPageToken(std::to_string(last.create_time) + kSeparator + last.id.value()));
  }
  for (const storage::Session& session : sessions) *response.add_sessions() = ToProto(session);
  return response;
}

}  // namespace enfilade::server
