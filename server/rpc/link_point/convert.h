// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "enfilade/v1/link_point_service.pb.h"
#include "google/protobuf/field_mask.pb.h"
#include "proto/convert/names.h"
#include "server/app/services.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// Stored link points as the API's resources, and the API's values as rows.

v1::LinkPoint ToProto(const storage::StoredLinkPoint& link_point);
// Fills a message that is part of another one, without a copy.
void ToProto(const storage::StoredLinkPoint& link_point, v1::LinkPoint& out);
v1::Evidence ToProto(const SiteId& site, const storage::Evidence& evidence);

// INVALID_ARGUMENT naming the field. Name, etag and output-only fields are ignored.
absl::StatusOr<storage::StoredLinkPoint> FromProto(const SiteId& site, const v1::LinkPoint& link_point);
absl::StatusOr<graph::Anchor> FromProto(const std::string& field, const SiteId& site, const v1::Anchor& anchor);
absl::StatusOr<storage::Evidence> FromProto(const convert::LinkPointName& name, const v1::Evidence& evidence);

// INVALID_ARGUMENT if a path of `mask` is no field that people may change.
absl::Status CheckLinkPointMask(const google::protobuf::FieldMask& mask);
// Copies the fields in the mask or, if that is empty, those that are set.
void Overwrite(const v1::LinkPoint& from, const google::protobuf::FieldMask& mask, v1::LinkPoint& to);

// The id of a map of `site`. INVALID_ARGUMENT for one of another site.
absl::StatusOr<MapId> MapOfSite(const std::string& field, const SiteId& site, const std::string& map);
// Unset: both. INVALID_ARGUMENT for an unknown value.
absl::StatusOr<std::optional<bool>> CandidatesOf(v1::LinkPointSubset subset);

// With their evidence.
absl::StatusOr<std::vector<v1::LinkPoint>> WithEvidence(const Services& services, const storage::CallContext& context,
                                                        const SiteId& site,
                                                        const std::vector<storage::StoredLinkPoint>& link_points);
absl::StatusOr<v1::LinkPoint> WithEvidence(const Services& services, const storage::CallContext& context,
                                           const storage::StoredLinkPoint& link_point);

}  // namespace enfilade::server
