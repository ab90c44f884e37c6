// SPDX-License-Identifier: Apache-2.0
#include "server/app/watch/site_moment.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace enfilade::server {
namespace {

// Of removed sessions: a watcher that does not read for so long may not hear of them.
constexpr DurationNs kRemovalsKept = 900 * kNsPerSecond;

// FNV-1a, so that every server and every build has the same.
class FnvDigest {
 public:
  void Add(std::string_view text) {
    for (const char c : text) AddByte(static_cast<unsigned char>(c));
    AddByte(0);
  }
  void Add(std::int64_t number) {
    for (int shift = 0; shift < 64; shift += 8) AddByte(static_cast<unsigned char>(number >> shift));
  }
  std::uint64_t value() const { return value_; }

 private:
  void AddByte(unsigned char byte) { value_ = (value_ ^ byte) * 0x100000001b3U; }
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

std::uint64_t DigestOfSessions(const std::vector<storage::SessionProgress>& sessions) {
  FnvDigest digest;
  for (const storage::SessionProgress& session : sessions) {
    if (session.is_over()) continue;
    digest.Add(session.id.value());
    digest.Add(session.robot.value());
    digest.Add(session.map ? session.map->value() : "");
    digest.Add(static_cast<std::int64_t>(session.state));
    digest.Add(session.acknowledged_sequence);
    digest.Add(session.mapped_sequence);
    digest.Add(session.error);
  }
  return digest.value();
}

std::uint64_t DigestOfRevisions(const std::vector<storage::CurrentRevision>& revisions) {
  FnvDigest digest;
  for (const storage::CurrentRevision& revision : revisions) {
    digest.Add(revision.map.value());
    digest.Add(revision.number);
    digest.Add(revision.create_time);
  }
  return digest.value();
}

bool IsKnown(const ActivityView& view, const SessionId& session) {
  return std::any_of(view.removed_sessions.begin(), view.removed_sessions.end(),
                     [&session](const ActivityView::RemovedSession& removed) { return removed.id == session; });
}

void AddRemoved(ActivityView& view, SessionId session) {
  if (!IsKnown(view, session)) view.removed_sessions.push_back({std::move(session), view.moment, view.activity.time});
}

// A view that is older counts as another, so that watchers' positions keep near the present.
constexpr DurationNs kViewKept = 3600 * kNsPerSecond;

bool IsSame(const ActivityView& a, const ActivityView& b) {
  return b.activity.time < a.activity.time + kViewKept && a.activity.sessions == b.activity.sessions &&
         a.activity.revisions == b.activity.revisions && a.activity.site_created == b.activity.site_created &&
         a.activity.waiting_sessions == b.activity.waiting_sessions &&
         static_cast<std::int64_t>(a.activity.mapping_lag_s) == static_cast<std::int64_t>(b.activity.mapping_lag_s);
}

}  // namespace

std::shared_ptr<const ActivityView> Following(const std::shared_ptr<const ActivityView>& before,
                                              storage::SiteActivity activity) {
  auto view = std::make_shared<ActivityView>();
  view->moment = before == nullptr ? 1 : before->moment + 1;
  view->activity = std::move(activity);
  if (before != nullptr) {
    for (const ActivityView::RemovedSession& removed : before->removed_sessions) {
      if (removed.time + kRemovalsKept > view->activity.time) view->removed_sessions.push_back(removed);
    }
  }
  const std::size_t known = view->removed_sessions.size();
  for (SessionId& session : view->activity.removed_sessions) AddRemoved(*view, std::move(session));
  view->activity.removed_sessions.clear();
  std::vector<storage::SessionProgress>& sessions = view->activity.sessions;
  for (const storage::SessionProgress& session : sessions) {
    if (session.deleted) AddRemoved(*view, session.id);
  }
  std::erase_if(sessions, [](const storage::SessionProgress& session) { return session.deleted; });
  if (before != nullptr && view->removed_sessions.size() == known && IsSame(*before, *view)) return before;
  view->sessions_digest = DigestOfSessions(sessions);
  view->revisions_digest = DigestOfRevisions(view->activity.revisions);
  return view;
}

}  // namespace enfilade::server
