// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/rearrange/messages.h"

#include "core/base/resource_name.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {

v1::Rearrangement ToProto(const storage::StoredRearrangement& rearrangement) {
  const SiteId& site = rearrangement.site;
  v1::Rearrangement out;
  out.set_name(convert::NameOf(convert::RearrangementName{site, rearrangement.id.value()}));
  out.set_reason(rearrangement.reason);
  out.set_actor(rearrangement.actor);
  *out.mutable_create_time() = convert::ToTimestamp(rearrangement.create_time);
  out.set_graph_version(rearrangement.version_after);
  if (rearrangement.undo_time) *out.mutable_undo_time() = convert::ToTimestamp(*rearrangement.undo_time);
  out.set_undo_graph_version(rearrangement.version_undone);
  out.set_undo_expired(rearrangement.undo_expired);
  for (const MapId& map : rearrangement.new_maps) out.add_new_maps(NameOf(site, map));
  for (const rearrange::MapRedirect& redirect : rearrangement.redirects) {
    v1::MergedMap& merged = *out.add_merged_maps();
    merged.set_map(NameOf(site, redirect.from));
    merged.set_into(NameOf(site, redirect.to));
    *merged.mutable_pose_into_map() = convert::ToProto(redirect.T_to_from);
  }
  for (const rearrange::SessionMove& move : rearrangement.moves) {
    v1::MovedSession& moved = *out.add_moved_sessions();
    moved.set_session(NameOf(site, move.session));
    moved.set_map(NameOf(site, move.to));
    *moved.mutable_pose_map_from() = convert::ToProto(move.T_to_from);
  }
  for (const rearrange::SessionCut& cut : rearrangement.cuts) {
    v1::SessionCut& message = *out.add_cut_sessions();
    message.set_session(NameOf(site, cut.session));
    message.set_first_sequence(cut.first_sequence);
    message.set_rest(NameOf(site, cut.rest));
  }
  for (const LinkPointId& id : rearrangement.changed_link_points) out.add_changed_link_points(NameOf(site, id));
  for (const LinkPointId& id : rearrangement.removed_link_points) out.add_removed_link_points(NameOf(site, id));
  return out;
}

}  // namespace enfilade::server
