// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "google/protobuf/repeated_ptr_field.h"

namespace enfilade::client {

// The largest page that the server sends.
constexpr int kMaxPageSize = 1000;

// All items of a List call, in the server's order:
//   ListAll(connection, &v1::MapService::Stub::ListMaps, request, &v1::ListMapsResponse::maps)
// `request` may set a page size; its page token is where the list starts. `limit`: at most so many items; 0: no limit.
// The first error ends the list. INTERNAL: the server gives the same page again and again.
template <typename Service, typename Request, typename Response, typename Item>
absl::StatusOr<std::vector<Item>> ListAll(
    const Connection& connection, grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
    Request request, const google::protobuf::RepeatedPtrField<Item>& (Response::*items)() const, int limit = 0) {
  std::vector<Item> all;
  while (true) {
    if (limit > 0) request.set_page_size(std::min(limit - static_cast<int>(all.size()), kMaxPageSize));
    ENFILADE_ASSIGN_OR_RETURN(const Response page, connection.Call(method, request));
    for (const Item& item : (page.*items)()) {
      if (limit > 0 && static_cast<int>(all.size()) == limit) break;
      all.push_back(item);
    }
    if (page.next_page_token().empty() || (limit > 0 && static_cast<int>(all.size()) == limit)) return all;
    if (page.next_page_token() == request.page_token()) return Internal("the server repeats a page of the list");
    request.set_page_token(page.next_page_token());
  }
}

}  // namespace enfilade::client
