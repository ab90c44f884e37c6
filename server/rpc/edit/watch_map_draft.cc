// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <limits>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "server/app/graph/pose_looks.h"
#include "server/rpc/edit/convert.h"
#include "server/rpc/edit/handlers.h"

namespace enfilade::server {
namespace {

constexpr auto kLookPeriod = std::chrono::milliseconds(200);
constexpr auto kHeartbeat = std::chrono::seconds(10);
constexpr int kEditsInMessage = 100;

v1::MapDraftPresence PresenceMessage(const DraftPresence& presence) {
  v1::MapDraftPresence out;
  out.set_client_id(presence.client_id);
  out.set_author(presence.author);
  if (presence.pointer) *out.mutable_pointer() = ToProto(*presence.pointer);
  out.set_tool(presence.tool);
  return out;
}

// What one stream has told.
class DraftWatch {
 public:
  DraftWatch(const Services& services, storage::MapDraftKey key, std::int64_t after_head, PoseLooks::Watcher watcher)
      : services_(services),
        key_(std::move(key)),
        name_(NameOf(key_.site, key_.map, key_.draft)),
        head_(after_head),
        watcher_(std::move(watcher)) {}

  absl::StatusOr<bool> Check(const storage::CallContext& context, v1::WatchMapDraftResponse& message) {
    message.Clear();
    ENFILADE_ASSIGN_OR_RETURN(const storage::MapDraft draft, services_.map_edit_store.Get(context, key_));
    // After a full message the client waits for more: it is told also that there is none.
    const bool was_full = has_more_;
    ENFILADE_RETURN_IF_ERROR(TellEdits(context, draft, message));
    const std::int64_t presences = services_.draft_presences.Version(name_);
    if (std::exchange(presences_, presences) != presences) {
      message.set_presences_changed(true);
      for (const DraftPresence& presence : services_.draft_presences.List(name_)) {
        *message.add_presences() = PresenceMessage(presence);
      }
    }
    if (std::exchange(etag_, draft.etag) != draft.etag) *message.mutable_draft() = ToProto(draft);
    ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state,
                              services_.map_edit_store.ReadOverlay(context, key_.site, key_.map));
    const std::int64_t version = state.overlay ? state.overlay->edit_version : 0;
    const bool is_news = was_full || message.edits_size() > 0 || message.presences_changed() || message.has_draft() ||
                         std::exchange(edit_version_, version) != version;
    const auto now = std::chrono::steady_clock::now();
    if (!is_news && now - told_ < kHeartbeat) return false;
    told_ = now;
    message.set_head(head_);
    message.set_edit_version(version);
    return true;
  }
  bool has_more() const { return has_more_; }

 private:
  absl::Status TellEdits(const storage::CallContext& context, const storage::MapDraft& draft,
                         v1::WatchMapDraftResponse& message) {
    has_more_ = false;
    if (draft.head <= head_ && sequence_ == kAll) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const auto edits,
                              services_.map_edit_store.ListEdits(context, draft, head_, sequence_, kEditsInMessage));
    for (const storage::StoredMapEdit& edit : edits) *message.add_edits() = ToProto(edit);
    has_more_ = edits.size() == kEditsInMessage;
    if (has_more_) {
      head_ = edits.back().head;
      sequence_ = edits.back().kept.sequence;
    } else {
      head_ = std::max(draft.head, edits.empty() ? 0 : edits.back().head);
      sequence_ = kAll;
    }
    return absl::OkStatus();
  }

  static constexpr std::int64_t kAll = std::numeric_limits<std::int64_t>::max();

  const Services& services_;
  const storage::MapDraftKey key_;
  const std::string name_;
  std::int64_t head_;
  std::int64_t sequence_ = kAll;  // of those of `head_` that are told
  std::int64_t presences_ = 0;
  std::int64_t etag_ = 0;
  std::int64_t edit_version_ = -1;
  bool has_more_ = false;
  std::chrono::steady_clock::time_point told_;
  const PoseLooks::Watcher watcher_;
};

}  // namespace

absl::StatusOr<v1::ReportMapDraftPresenceResponse> ReportMapDraftPresence(
    const Services& services, const Call& call, const v1::ReportMapDraftPresenceRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  const v1::MapDraftPresence& presence = request.presence();
  if (presence.client_id().empty() || presence.client_id().size() > 64) {
    return InvalidArgument("presence.client_id has {} bytes: expected 1 to 64", presence.client_id().size());
  }
  if (presence.tool().size() > 32) {
    return InvalidArgument("presence.tool has {} bytes: at most 32", presence.tool().size());
  }
  ENFILADE_ASSIGN_OR_RETURN(std::string author, AuthorOr("presence.author", presence.author(), call));
  ENFILADE_RETURN_IF_ERROR(services.map_edit_store.Get(call.context(), KeyOf(name)).status());
  DraftPresence known{presence.client_id(), std::move(author), std::nullopt, presence.tool()};
  if (presence.has_pointer()) known.pointer = server::FromProto(presence.pointer());
  services.draft_presences.Report(request.name(), std::move(known));
  return v1::ReportMapDraftPresenceResponse();
}

absl::StatusOr<Watch<v1::WatchMapDraftResponse>> WatchMapDraft(const Services& services, const Call& call,
                                                               const v1::WatchMapDraftRequest& request) {
  (void)call;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(PoseLooks::Watcher watcher, services.pose_looks.Admit(name.site));
  const auto watch = std::make_shared<DraftWatch>(services, KeyOf(name), request.after_head(), std::move(watcher));
  return Watch<v1::WatchMapDraftResponse>{
      .period = kLookPeriod,
      .check = [watch](const storage::CallContext& context,
                       v1::WatchMapDraftResponse& message) { return watch->Check(context, message); },
      .has_more = [watch] { return watch->has_more(); },
      .stopping = [&services] { return services.graphs.stopping(); }};
}

}  // namespace enfilade::server
