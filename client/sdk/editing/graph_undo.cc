// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/editing/graph_undo.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "client/sdk/api/paging.h"
#include "client/sdk/editing/audited_link_point.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "google/protobuf/util/message_differencer.h"

namespace enfilade::client {
namespace {

using google::protobuf::util::MessageDifferencer;

// No transaction takes longer.
constexpr std::int64_t kLongestTransaction = 600;  // s

bool AreTogether(const v1::AuditEntry& a, const v1::AuditEntry& b) {
  return a.actor() == b.actor() && MessageDifferencer::Equals(a.time(), b.time());
}

// What all entries together have done to one row. Empty: there was none before, or is none after.
struct RowChange {
  std::string before;
  std::string after;
};

struct LinkPointHistory {
  std::optional<RowChange> row;
  std::map<std::string, RowChange> anchors;  // by map
};

void Continue(const v1::AuditEntry& entry, RowChange& change, bool is_first) {
  if (is_first) change.before = entry.before();
  change.after = entry.after();
}

std::map<std::string, LinkPointHistory> HistoriesOf(const std::vector<v1::AuditEntry>& entries) {
  std::map<std::string, LinkPointHistory> histories;
  for (const v1::AuditEntry& entry : entries) {
    const AuditedPart part = PartOf(entry);
    if (part.link_point.empty() || part.evidence) continue;
    LinkPointHistory& history = histories[part.link_point];
    if (part.anchor_map.empty()) {
      const bool is_first = !history.row;
      if (is_first) history.row.emplace();
      Continue(entry, *history.row, is_first);
    } else {
      const auto [change, is_first] = history.anchors.try_emplace(part.anchor_map);
      Continue(entry, change->second, is_first);
    }
  }
  return histories;
}

absl::Status ChangedSince(const std::string& link_point, const std::string& what) {
  return FailedPrecondition("{}: {} has been changed since: take that back first", link_point, what);
}

const v1::Anchor* FindAnchor(const v1::LinkPoint& link_point, const std::string& map) {
  for (const v1::Anchor& anchor : link_point.anchors()) {
    if (anchor.map() == map) return &anchor;
  }
  return nullptr;
}

// What is to be changed of one link point that is there before and after.
class InverseUpdate {
 public:
  explicit InverseUpdate(const v1::LinkPoint& present) : present_(present), wanted_(present) {}

  absl::Status TakeBackRow(const RowChange& change) {
    ENFILADE_ASSIGN_OR_RETURN(const v1::LinkPoint before, LinkPointOfRow(change.before));
    ENFILADE_ASSIGN_OR_RETURN(const v1::LinkPoint after, LinkPointOfRow(change.after));
    for (const char* path :
         {"kind", "tag", "direction_map", "difficulty", "environment", "state", "pinned", "state_valid_until"}) {
      if (IsSameField(path, before, after)) continue;
      if (!IsSameField(path, after, present_)) return ChangedSince(present_.name(), path);
      CopyField(path, before);
      mask_.add_paths(path);
    }
    return TakeBackUse(before.use(), after.use());
  }

  absl::Status TakeBackAnchor(const std::string& map, const RowChange& change) {
    std::optional<AuditedAnchor> before, after;
    if (!change.before.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(before, AnchorOfRow(change.before));
    }
    if (!change.after.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(after, AnchorOfRow(change.after));
    }
    if (!before && !after) return absl::OkStatus();
    const v1::Anchor* const now = FindAnchor(present_, map);
    const bool is_unchanged = after ? now != nullptr && IsSame(after->anchor, *now) : now == nullptr;
    if (!is_unchanged) return ChangedSince(present_.name(), "its anchor in " + map);
    auto& anchors = *wanted_.mutable_anchors();
    const auto place =
        std::find_if(anchors.begin(), anchors.end(), [&](const v1::Anchor& anchor) { return anchor.map() == map; });
    if (!before) {
      anchors.erase(place);
    } else if (place != anchors.end()) {
      *place = before->anchor;
    } else {
      *anchors.Add() = before->anchor;
    }
    if (!has_anchors_) mask_.add_paths("anchors");
    has_anchors_ = true;
    return absl::OkStatus();
  }

  std::vector<v1::GraphChange> Take() && {
    std::vector<v1::GraphChange> changes;
    if (mask_.paths_size() > 0) {
      v1::GraphChange& change = changes.emplace_back();
      *change.mutable_updated() = std::move(wanted_);
      *change.mutable_update_mask() = std::move(mask_);
    }
    if (!use_) return changes;
    v1::GraphChange& change = changes.emplace_back();
    if (changes.size() == 1) change.set_etag(present_.etag());
    (*use_ == v1::LinkPoint::USE_SUSPENDED ? change.mutable_suspended() : change.mutable_resumed())
        ->assign(present_.name());
    return changes;
  }

 private:
  static bool IsSameField(const std::string& path, const v1::LinkPoint& a, const v1::LinkPoint& b) {
    if (path == "kind") return a.kind() == b.kind();
    if (path == "tag") return a.tag() == b.tag();
    if (path == "direction_map") return a.direction_map() == b.direction_map();
    if (path == "difficulty") return a.difficulty() == b.difficulty();
    if (path == "environment") return a.environment() == b.environment();
    if (path == "state") return a.state() == b.state();
    if (path == "pinned") return !a.has_pinned() || !b.has_pinned() || a.pinned() == b.pinned();
    return a.has_state_valid_until() == b.has_state_valid_until() &&
           MessageDifferencer::Equals(a.state_valid_until(), b.state_valid_until());
  }

  void CopyField(const std::string& path, const v1::LinkPoint& from) {
    if (path == "kind") wanted_.set_kind(from.kind());
    if (path == "tag") wanted_.set_tag(from.tag());
    if (path == "direction_map") wanted_.set_direction_map(from.direction_map());
    if (path == "difficulty") wanted_.set_difficulty(from.difficulty());
    if (path == "environment") wanted_.set_environment(from.environment());
    if (path == "state") wanted_.set_state(from.state());
    if (path == "pinned") wanted_.set_pinned(from.pinned());
    if (path != "state_valid_until") return;
    wanted_.clear_state_valid_until();
    if (from.has_state_valid_until()) *wanted_.mutable_state_valid_until() = from.state_valid_until();
  }

  // The optimisation switches off and on again as it finds; only suspending is people's.
  absl::Status TakeBackUse(v1::LinkPoint::Use before, v1::LinkPoint::Use after) {
    const bool was = before == v1::LinkPoint::USE_SUSPENDED;
    const bool became = after == v1::LinkPoint::USE_SUSPENDED;
    if (was == became) return absl::OkStatus();
    if ((present_.use() == v1::LinkPoint::USE_SUSPENDED) != became) {
      return ChangedSince(present_.name(), "whether it is suspended");
    }
    use_ = was ? v1::LinkPoint::USE_SUSPENDED : v1::LinkPoint::USE_USED;
    return absl::OkStatus();
  }

  const v1::LinkPoint& present_;
  v1::LinkPoint wanted_;
  google::protobuf::FieldMask mask_;
  bool has_anchors_ = false;
  std::optional<v1::LinkPoint::Use> use_;
};

// What was deleted is made again.
absl::StatusOr<std::vector<v1::GraphChange>> MakeAgain(const LinkPointHistory& history) {
  ENFILADE_ASSIGN_OR_RETURN(v1::LinkPoint link_point, LinkPointOfRow(history.row->before));
  std::vector<AuditedAnchor> anchors;
  for (const auto& [map, change] : history.anchors) {
    if (change.before.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(AuditedAnchor anchor, AnchorOfRow(change.before));
    anchors.push_back(std::move(anchor));
  }
  std::sort(anchors.begin(), anchors.end(),
            [](const AuditedAnchor& a, const AuditedAnchor& b) { return a.ordinal < b.ordinal; });
  for (AuditedAnchor& anchor : anchors) *link_point.add_anchors() = std::move(anchor.anchor);
  std::vector<v1::GraphChange> changes(1);
  changes.front().set_force(link_point.forced());
  const bool suspended = link_point.use() == v1::LinkPoint::USE_SUSPENDED;
  const std::string name = link_point.name();
  *changes.front().mutable_created() = std::move(link_point);
  if (suspended) changes.emplace_back().set_suspended(name);
  return changes;
}

// What was made is deleted, as long as it is as it was made.
absl::StatusOr<std::vector<v1::GraphChange>> Unmake(const v1::LinkPoint& present, const LinkPointHistory& history) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::LinkPoint made, LinkPointOfRow(history.row->after));
  std::ptrdiff_t made_anchors = 0;
  for (const auto& [map, change] : history.anchors) {
    if (change.after.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(const AuditedAnchor anchor, AnchorOfRow(change.after));
    const v1::Anchor* const now = FindAnchor(present, map);
    if (now == nullptr || !IsSame(anchor.anchor, *now)) return ChangedSince(present.name(), "its anchor in " + map);
    ++made_anchors;
  }
  if (present.anchors_size() != made_anchors) return ChangedSince(present.name(), "the number of its anchors");
  if (present.tag() != made.tag()) return ChangedSince(present.name(), "tag");
  std::vector<v1::GraphChange> changes(1);
  changes.front().set_deleted(present.name());
  changes.front().set_etag(present.etag());
  return changes;
}

absl::StatusOr<std::vector<v1::GraphChange>> InverseOf(const std::string& name, const LinkPointHistory& history,
                                                       const v1::LinkPoint* present) {
  const bool was_there = !history.row || !history.row->before.empty();
  const bool is_there = !history.row || !history.row->after.empty();
  if (!was_there && !is_there) return std::vector<v1::GraphChange>();
  if (!is_there) {
    if (present != nullptr) return FailedPrecondition("{} has been made again since: it is there", name);
    return MakeAgain(history);
  }
  if (present == nullptr) return FailedPrecondition("{} has been deleted since: take that back first", name);
  if (!was_there) return Unmake(*present, history);
  InverseUpdate update(*present);
  if (history.row) ENFILADE_RETURN_IF_ERROR(update.TakeBackRow(*history.row));
  for (const auto& [map, change] : history.anchors) ENFILADE_RETURN_IF_ERROR(update.TakeBackAnchor(map, change));
  return std::move(update).Take();
}

}  // namespace

absl::StatusOr<std::vector<v1::AuditEntry>> ReadAuditedChange(const Connection& connection, const std::string& site,
                                                              const std::string& id) {
  v1::ListAuditEntriesRequest request;
  request.set_parent(site);
  request.set_page_size(kMaxPageSize);
  std::vector<v1::AuditEntry> entries;
  std::optional<v1::AuditEntry> asked;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const auto page, connection.Call(&v1::SiteService::Stub::ListAuditEntries, request));
    for (const v1::AuditEntry& entry : page.entries()) {
      entries.push_back(entry);
      if (entry.id() == id) asked = entry;
    }
    // Entries are listed as they were written; `time` is when the transaction began.
    const bool is_past = asked && !page.entries().empty() &&
                         page.entries().rbegin()->time().seconds() < asked->time().seconds() - kLongestTransaction;
    if (page.next_page_token().empty() || is_past) break;
    if (page.next_page_token() == request.page_token()) return Internal("the server repeats a page of the list");
    request.set_page_token(page.next_page_token());
    if (asked || entries.empty()) continue;
    const std::int64_t still_needed = entries.back().time().seconds() + kLongestTransaction;
    std::erase_if(entries,
                  [still_needed](const v1::AuditEntry& entry) { return entry.time().seconds() > still_needed; });
  }
  if (!asked) return NotFound("{} has no audit entry {}, or not any more: see enfilade site audit", site, id);
  std::erase_if(entries, [&](const v1::AuditEntry& entry) { return !AreTogether(entry, *asked); });
  std::reverse(entries.begin(), entries.end());
  return entries;
}

absl::StatusOr<std::vector<v1::GraphChange>> InverseOf(const std::vector<v1::AuditEntry>& entries,
                                                       const std::map<std::string, v1::LinkPoint>& present) {
  const std::map<std::string, LinkPointHistory> histories = HistoriesOf(entries);
  if (histories.empty()) {
    return FailedPrecondition("the change is none of link points and their anchors: only those are taken back");
  }
  std::vector<v1::GraphChange> changes;
  for (const auto& [name, history] : histories) {
    const auto now = present.find(name);
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::GraphChange> inverse,
                              InverseOf(name, history, now == present.end() ? nullptr : &now->second));
    changes.insert(changes.end(), inverse.begin(), inverse.end());
  }
  if (changes.empty()) {
    return FailedPrecondition("there is nothing to take back: what the optimisation has switched off, it judges again");
  }
  return changes;
}

absl::StatusOr<std::vector<v1::GraphChange>> ReadInverse(const Connection& connection, const std::string& site,
                                                         const std::string& id) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::AuditEntry> entries, ReadAuditedChange(connection, site, id));
  std::map<std::string, v1::LinkPoint> present;
  for (const v1::AuditEntry& entry : entries) {
    v1::GetLinkPointRequest request;
    request.set_name(PartOf(entry).link_point);
    if (request.name().empty() || present.contains(request.name())) continue;
    const auto found = connection.Call(&v1::LinkPointService::Stub::GetLinkPoint, request);
    if (absl::IsNotFound(found.status())) continue;
    ENFILADE_RETURN_IF_ERROR(found.status());
    present[request.name()] = found->link_point();
  }
  return InverseOf(entries, present);
}

}  // namespace enfilade::client
