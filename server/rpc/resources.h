// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "core/slam/slam_map.h"
#include "enfilade/v1/closure.pb.h"
#include "enfilade/v1/map.pb.h"
#include "enfilade/v1/robot.pb.h"
#include "enfilade/v1/session.pb.h"
#include "enfilade/v1/site.pb.h"
#include "google/protobuf/field_mask.pb.h"
#include "proto/convert/names.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/request_id.h"
#include "storage/sessions/session_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_store.h"

namespace enfilade::server {

// Stored rows as the API's resources, and the API's values as rows.

v1::Site ToProto(const storage::Site& site);
v1::Robot ToProto(const storage::Robot& robot);
v1::Map ToProto(const storage::Map& map);
v1::MapRevision ToProto(const storage::MapRevision& revision);
v1::Session ToProto(const storage::Session& session);
v1::Closure ToProto(const convert::SessionName& session, const slam::LoopClosure& closure);

// INVALID_ARGUMENT naming the field. Names, etags and output-only fields of the message are not read.
absl::StatusOr<storage::Site> FromProto(const v1::Site& site);
// INVALID_ARGUMENT naming the field, if it is not the tag of a revision.
absl::Status CheckTag(const char* field, const std::string& tag);
// INVALID_ARGUMENT naming the field, unless it has 1 to 200 characters.
absl::Status CheckDisplayName(const char* field, const std::string& name);
absl::StatusOr<storage::Robot> FromProto(const v1::Robot& robot);
absl::StatusOr<storage::Map> FromProto(const v1::Map& map);

// 0 for "" (any).
absl::StatusOr<std::int64_t> ParseEtag(const std::string& etag);

// The requested id, or a new one if it is empty. INVALID_ARGUMENT naming `field` if it is not a valid id.
absl::StatusOr<std::string> IdOrNew(const char* field, const std::string& requested);

// Of a creation: its request id with the digest of the whole request. INVALID_ARGUMENT if `id` is not a valid one.
absl::StatusOr<storage::RequestId> MakeRequestId(const std::string& id, const std::string& request);
template <typename Request>
absl::StatusOr<storage::RequestId> RequestIdOf(const Request& request) {
  if (request.request_id().empty()) return storage::RequestId();
  return MakeRequestId(request.request_id(), request.SerializeAsString());
}

// The id of what a request without an id creates: the same for the same request_id.
std::string IdOfRequest(const std::string& request_id);

// INVALID_ARGUMENT if a path of `mask` is not one of the editable fields.
absl::Status CheckMask(const google::protobuf::FieldMask& mask, std::initializer_list<const char*> editable);

// Whether an update writes the field: it is in the mask or, if the mask is empty, it is set.
bool IsUpdated(const google::protobuf::FieldMask& mask, const char* path, bool is_set);

}  // namespace enfilade::server
