// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/stored_plan.h"

#include <string>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/geojson_plan.h"

namespace enfilade::server {

absl::StatusOr<prior::PlanGraph> ReadStoredPlan(const storage::CallContext& context,
                                                const storage::PriorMapStore& prior_maps,
                                                const storage::BlobStore& blobs, const storage::PriorMap& prior_map) {
  ENFILADE_ASSIGN_OR_RETURN(const auto files, prior_maps.ListFiles(context, prior_map.site, prior_map.id));
  for (const storage::PriorMapFile& file : files) {
    if (file.product != storage::PriorMapProduct::kPlan) continue;
    ENFILADE_ASSIGN_OR_RETURN(const std::string text, blobs.Get(context, prior_map.site, file.sha256));
    return prior::ReadGeoJsonPlan(text);
  }
  return NotFound("{} does not exist", NameOf(prior_map.site, prior_map.id));
}

}  // namespace enfilade::server
