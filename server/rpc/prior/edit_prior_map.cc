// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/plan/plan_edits.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/prior/product_file.h"
#include "server/rpc/resources.h"
#include "storage/etag.h"

namespace enfilade::server {
namespace {

absl::StatusOr<prior::EditedPlan> Edited(const prior::PlanGraph& before, const v1::EditPriorMapRequest& request) {
  prior::PlanGraph drawn = before;
  if (!request.plan().empty()) {
    auto read = prior::ReadEditedPlan(request.plan());
    if (!read.ok()) return WithContext(read.status(), "plan");
    drawn = *std::move(read);
  }
  if (request.has_measure()) {
    ENFILADE_ASSIGN_OR_RETURN(const auto measure, MeasureOf("measure", request.measure()));
    drawn.metres_per_unit = measure.metres / (measure.to - measure.from).norm();
  }
  auto edited = prior::ApplyEdits(before, drawn);
  if (!edited.ok()) return WithContext(edited.status(), "plan");
  return edited;
}

v1::PriorMapChanges ChangesToProto(const prior::PlanChanges& changes) {
  v1::PriorMapChanges out;
  out.set_walls_added(changes.walls_added);
  out.set_walls_removed(changes.walls_removed);
  out.set_walls_changed(changes.walls_changed);
  out.set_doors_added(changes.doors_added);
  out.set_doors_removed(changes.doors_removed);
  out.set_scale_changed(changes.scale_changed);
  return out;
}

}  // namespace

absl::StatusOr<v1::EditPriorMapResponse> EditPriorMap(const Services& services, const Call& call,
                                                      const v1::EditPriorMapRequest& request) {
  v1::EditPriorMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  if (request.plan().empty() && !request.has_measure()) return InvalidArgument("expected plan, measure, or both");
  ENFILADE_ASSIGN_OR_RETURN(storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  if (etag != 0 && etag != prior_map.etag) return storage::StaleEtag(convert::NameOf(name));
  ENFILADE_ASSIGN_OR_RETURN(const std::string stored,
                            ReadProductFile(services, call, name, storage::PriorMapProduct::kPlan, kPlanFileName));
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph before, prior::ReadGeoJsonPlan(stored));
  ENFILADE_ASSIGN_OR_RETURN(const prior::EditedPlan edited, Edited(before, request));
  *response.mutable_changes() = ChangesToProto(edited.changes);
  for (const std::string& warning : edited.warnings) response.add_warnings(warning);
  if (edited.changes.Any()) {
    const storage::PriorMapElements elements = ElementsOf(edited.plan);
    const std::string reason = prior_map.alignment ? "it was corrected since it was aligned: align it again"
                                                   : "it was corrected, and not aligned yet";
    if (request.validate_only()) {
      prior_map.elements = elements;
      prior_map.state = storage::PriorMapState::kNew;
      prior_map.reason = reason;
    } else {
      // The correction is of the plan as it was read.
      ENFILADE_ASSIGN_OR_RETURN(prior_map, services.prior_maps.ReplacePlan(
                                               call.context(), name.site, name.prior_map, prior_map.etag, elements,
                                               {storage::PriorMapProduct::kPlan, std::string(kPlanFileName),
                                                prior::WriteGeoJsonPlan(edited.plan)},
                                               reason));
    }
  }
  *response.mutable_prior_map() = ToProto(prior_map);
  return response;
}

}  // namespace enfilade::server
