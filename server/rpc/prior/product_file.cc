// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/prior/product_file.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {

absl::StatusOr<std::string> ReadProductFile(const Services& services, const Call& call,
                                            const convert::PriorMapName& name, storage::PriorMapProduct product,
                                            std::string_view file_name) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  ENFILADE_ASSIGN_OR_RETURN(const auto files, services.prior_maps.ListFiles(call.context(), name.site, name.prior_map));
  for (const storage::PriorMapFile& file : files) {
    if (file.product != product || file.name != file_name) continue;
    return services.blobs.Get(call.context(), name.site, file.sha256);
  }
  std::string_view why = "was aligned by an earlier version of the server";
  if (!prior_map.alignment) why = "is not aligned";
  if (prior_map.alignment && prior_map.state == storage::PriorMapState::kNew)
    why = "was corrected since it was aligned";
  return FailedPrecondition("{} {}: align it", convert::NameOf(name), why);
}

}  // namespace enfilade::server
