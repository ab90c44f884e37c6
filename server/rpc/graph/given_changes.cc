// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/given_changes.h"

#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr int kMaxChanges = 100;

// Of an update without a mask.
google::protobuf::FieldMask UsualMask(const v1::LinkPoint& link_point) {
  google::protobuf::FieldMask mask;
  for (const char* path : {"anchors", "tag", "difficulty"}) mask.add_paths(path);
  if (link_point.kind() != 0) mask.add_paths("kind");
  if (link_point.state() != 0) mask.add_paths("state");
  if (link_point.state() != 0 || link_point.has_state_valid_until()) mask.add_paths("state_valid_until");
  if (link_point.environment() != 0) mask.add_paths("environment");
  if (!link_point.direction_map().empty()) mask.add_paths("direction_map");
  return mask;
}

class ChangesParser {
 public:
  ChangesParser(const SiteId& site, const FindStored& find) : site_(site), find_(find) {}

  absl::Status Add(int number, const v1::GraphChange& change) {
    ENFILADE_ASSIGN_OR_RETURN(storage::LinkPointChange parsed, Parse(number, change));
    changed_by_.try_emplace(storage::LinkPointOf(parsed), number);
    given_.changes.push_back(std::move(parsed));
    return absl::OkStatus();
  }

  GivenChanges Take() && { return std::move(given_); }

 private:
  absl::StatusOr<storage::LinkPointChange> Parse(int number, const v1::GraphChange& change) {
    if (!change.etag().empty() && (change.has_created() || change.has_updated())) {
      return InvalidArgument("etag is set beside {}: what is updated has its etag in itself, and what is made has none",
                             change.has_created() ? "created" : "updated");
    }
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(change.etag()));
    switch (change.change_case()) {
      case v1::GraphChange::kCreated:
        return Creation(number, change);
      case v1::GraphChange::kUpdated:
        return Update(change);
      case v1::GraphChange::kSuspended:
        return Suspension("suspended", change.suspended(), etag, true);
      case v1::GraphChange::kResumed:
        return Suspension("resumed", change.resumed(), etag, false);
      case v1::GraphChange::kDeleted: {
        ENFILADE_ASSIGN_OR_RETURN(LinkPointId id, IdOf("deleted", change.deleted()));
        if (etag != 0) ENFILADE_RETURN_IF_ERROR(CheckFirst(id, "etag is set"));
        return storage::LinkPointDeletion{std::move(id), etag};
      }
      case v1::GraphChange::CHANGE_NOT_SET:
        break;
    }
    return InvalidArgument("it has no change: set created, updated, suspended, resumed or deleted");
  }

  absl::StatusOr<storage::LinkPointChange> Creation(int number, const v1::GraphChange& change) {
    const v1::LinkPoint& created = change.created();
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint link_point, FromProto(site_, created));
    if (created.name() == NameOf(site_)) {
      link_point.point.id = LinkPointId(NewUuid());
      given_.unnamed[link_point.point.id] = number + 1;
    } else {
      ENFILADE_ASSIGN_OR_RETURN(link_point.point.id, IdOf("created.name", created.name()));
    }
    link_point.forced = change.force();
    return storage::LinkPointCreation{std::move(link_point)};
  }

  absl::StatusOr<storage::LinkPointChange> Update(const v1::GraphChange& change) const {
    const v1::LinkPoint& updated = change.updated();
    ENFILADE_RETURN_IF_ERROR(CheckLinkPointMask(change.update_mask()));
    ENFILADE_ASSIGN_OR_RETURN(LinkPointId id, IdOf("updated.name", updated.name()));
    ENFILADE_RETURN_IF_ERROR(CheckFirst(id, "it is an update"));
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(updated.etag()));
    ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint stored, find_(id));
    v1::LinkPoint wanted = ToProto(stored);
    Overwrite(updated, change.update_mask().paths_size() > 0 ? change.update_mask() : UsualMask(updated), wanted);
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint link_point, FromProto(site_, wanted));
    link_point.point.id = std::move(id);
    link_point.forced = stored.forced || change.force();
    link_point.etag = etag != 0 ? etag : stored.etag;
    return storage::LinkPointUpdate{std::move(link_point)};
  }

  absl::StatusOr<storage::LinkPointChange> Suspension(const char* field, const std::string& name, std::int64_t etag,
                                                      bool suspended) const {
    ENFILADE_ASSIGN_OR_RETURN(LinkPointId id, IdOf(field, name));
    if (etag != 0) ENFILADE_RETURN_IF_ERROR(CheckFirst(id, "etag is set"));
    return storage::LinkPointSuspension{std::move(id), etag, suspended};
  }

  // `what` is checked against the link point as it is stored, so no earlier change may have changed that.
  absl::Status CheckFirst(const LinkPointId& id, const char* what) const {
    const auto earlier = changed_by_.find(id);
    if (earlier == changed_by_.end()) return absl::OkStatus();
    return InvalidArgument("{}, but changes[{}] changes {} already: make all of it one update, and give its etag first",
                           what, earlier->second, NameOf(site_, id));
  }

  absl::StatusOr<LinkPointId> IdOf(const char* field, const std::string& name) const {
    ENFILADE_ASSIGN_OR_RETURN(convert::LinkPointName parsed, convert::ParseLinkPointName(field, name));
    if (parsed.site != site_) return InvalidArgument("{} is \"{}\": expected one of {}", field, name, NameOf(site_));
    return std::move(parsed.link_point);
  }

  const SiteId& site_;
  const FindStored& find_;
  std::map<LinkPointId, int> changed_by_;
  GivenChanges given_;
};

}  // namespace

absl::StatusOr<GivenChanges> ParseChanges(const SiteId& site,
                                          const google::protobuf::RepeatedPtrField<v1::GraphChange>& changes,
                                          const FindStored& find) {
  if (changes.empty()) return InvalidArgument("changes is empty: expected at least one change");
  if (changes.size() > kMaxChanges) {
    return InvalidArgument("changes has {} changes: at most {} are made together", changes.size(), kMaxChanges);
  }
  ChangesParser parser(site, find);
  for (int i = 0; i < changes.size(); ++i) {
    ENFILADE_RETURN_IF_ERROR(WithContext(parser.Add(i, changes.at(i)), fmt::format("changes[{}]", i)));
  }
  return std::move(parser).Take();
}

}  // namespace enfilade::server
