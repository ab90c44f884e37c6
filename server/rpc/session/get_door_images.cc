// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {
namespace {

absl::StatusOr<closure::DoorVerdict> FindVerdict(const Services& services, const storage::CallContext& context,
                                                 const convert::DoorVerdictName& name) {
  ENFILADE_ASSIGN_OR_RETURN(
      auto verdicts, services.door_verdicts.List(context, name.site, name.session, name.sequence - 1, /*limit=*/1));
  if (verdicts.empty() || verdicts.front().sequence != name.sequence) {
    return NotFound("{} does not exist", convert::NameOf(name));
  }
  return std::move(verdicts.front());
}

// Depth is for programs.
bool IsPicture(const v1::Image& image) { return image.encoding() != v1::Image::ENCODING_DEPTH_PNG16; }

}  // namespace

absl::StatusOr<v1::GetDoorImagesResponse> GetDoorImages(const Services& services, const Call& call,
                                                        const v1::GetDoorImagesRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseDoorVerdictName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const closure::DoorVerdict verdict, FindVerdict(services, call.context(), name));
  v1::GetDoorImagesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto records,
                            services.records.ReadEach(call.context(), name.site, name.session, verdict.evidence));
  for (const sensor::Record& record : records) {
    v1::Record out = convert::ToProto(record);
    if (out.has_image() && IsPicture(out.image())) *response.add_seen() = std::move(*out.mutable_image());
  }
  std::vector<LinkPointId> places;
  for (const closure::DoorComparison& comparison : verdict.comparisons) places.push_back(comparison.link_point);
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence, services.link_points.ListEvidence(call.context(), name.site, places));
  for (const closure::DoorComparison& comparison : verdict.comparisons) {
    v1::KeptImages& kept = *response.add_kept();
    kept.set_link_point(convert::NameOf(convert::LinkPointName{name.site, comparison.link_point}));
    kept.set_map(convert::NameOf(convert::MapName{name.site, comparison.map}));
    for (const storage::Evidence& item : evidence) {
      if (item.link_point != comparison.link_point || item.map != comparison.map) continue;
      v1::Evidence out = ToProto(name.site, item);
      if (out.has_image() && IsPicture(out.image())) *kept.add_images() = std::move(*out.mutable_image());
    }
  }
  return response;
}

}  // namespace enfilade::server
