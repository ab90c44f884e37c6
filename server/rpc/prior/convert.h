// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "enfilade/v1/prior_map.pb.h"
#include "enfilade/v1/prior_map_service.pb.h"
#include "perception/plan/read_plan.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

v1::PriorMap ToProto(const storage::PriorMap& prior_map);
storage::PriorMapElements ElementsOf(const prior::PlanGraph& plan);

// INVALID_ARGUMENT naming the field, as in those below.
absl::StatusOr<std::vector<storage::PriorMapPair>> PairsOf(
    const SiteId& site, const google::protobuf::RepeatedPtrField<v1::ControlPair>& pairs);
absl::StatusOr<perception::ReadPlanOptions> ReadPlanOptionsOf(const v1::ImportPriorMapManifest& manifest);
absl::StatusOr<perception::PlanMeasure> MeasureOf(const std::string& field, const v1::PlanMeasure& measure);
absl::StatusOr<std::vector<storage::PriorMapProduct>> ProductsOf(const google::protobuf::RepeatedField<int>& products);

}  // namespace enfilade::server
