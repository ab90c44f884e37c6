// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_version_waits.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/error.h"
#include "core/base/mutex.h"

namespace enfilade::server {
namespace {

using std::chrono::steady_clock;

constexpr auto kAskAgain = std::chrono::milliseconds(50);
constexpr std::size_t kMaxVersionWaits = 1000;

}  // namespace

struct GraphVersionWaits::Wait {
  SiteId site;
  std::int64_t version;
  steady_clock::time_point until;
  std::function<void(const absl::Status&)> then;
  std::atomic<bool> done = false;
  // Guarded by the mutex of Waits.
  bool asking = true;
  steady_clock::time_point ask_again = {};

  void Finish(const absl::Status& status) {
    if (!done.exchange(true)) then(status);
  }
  absl::Status TimedOut() const {
    return Unavailable("this server has not yet read version {} of the graph of sites/{}: call again in a moment",
                       version, site.value());
  }
};

// Those who wait, until they are answered and a little longer.
class GraphVersionWaits::Waits {
 public:
  // What is due.
  struct Due {
    std::vector<std::shared_ptr<Wait>> expired;
    std::vector<std::shared_ptr<Wait>> to_ask;
  };

  bool Add(const std::shared_ptr<Wait>& wait) {
    MutexLock lock(mutex_);
    std::erase_if(waits_, [](const auto& other) { return other->done.load(); });
    if (waits_.size() >= kMaxVersionWaits) return false;
    waits_.push_back(wait);
    changed_.NotifyAll();
    return true;
  }
  void AskAgain(Wait& wait) {
    MutexLock lock(mutex_);
    wait.asking = false;
    wait.ask_again = steady_clock::now() + kAskAgain;
    changed_.NotifyAll();
  }
  void Stop() {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  // Waits until something is due; after Stop all expires at once. Nothing is due: it is over.
  Due Next() {
    MutexLock lock(mutex_);
    while (true) {
      const auto now = steady_clock::now();
      auto next = now + std::chrono::hours(1);
      Due due;
      std::erase_if(waits_, [](const auto& wait) { return wait->done.load(); });
      for (const std::shared_ptr<Wait>& wait : waits_) {
        if (stopping_ || wait->until <= now) {
          due.expired.push_back(wait);
        } else if (!wait->asking && wait->ask_again <= now) {
          wait->asking = true;
          due.to_ask.push_back(wait);
        }
        next = std::min(next, wait->asking ? wait->until : std::min(wait->until, wait->ask_again));
      }
      if (stopping_ || !due.expired.empty() || !due.to_ask.empty()) return due;
      changed_.WaitUntil(mutex_, next);
    }
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  std::vector<std::shared_ptr<Wait>> waits_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
};

GraphVersionWaits::GraphVersionWaits(SiteGraphs& graphs, steady_clock::duration max_wait)
    : graphs_(graphs), max_wait_(max_wait), waits_(std::make_shared<Waits>()) {
  thread_ = std::thread([this] { Run(); });
}

GraphVersionWaits::~GraphVersionWaits() {
  waits_->Stop();
  thread_.join();
}

void GraphVersionWaits::Await(const SiteId& site, std::int64_t version, steady_clock::time_point deadline,
                              std::function<void(const absl::Status&)> then) {
  const auto current = graphs_.FindCurrent(site);
  if (current != nullptr && current->graph().version() >= version) return then(absl::OkStatus());
  const auto wait = std::make_shared<Wait>();
  wait->site = site;
  wait->version = version;
  wait->until = std::min(steady_clock::now() + max_wait_, deadline);
  wait->then = std::move(then);
  if (!waits_->Add(wait)) {
    return wait->Finish(ResourceExhausted("too many calls wait for versions of graphs: try again later"));
  }
  Ask(graphs_, waits_, wait);
}

void GraphVersionWaits::Ask(SiteGraphs& graphs, const std::shared_ptr<Waits>& waits,
                            const std::shared_ptr<Wait>& wait) {
  graphs.Refresh(wait->site, [waits, wait](const SiteGraphs::Result& read) {
    if (!read.ok()) return wait->Finish(read.status());
    if ((*read)->graph().version() >= wait->version) return wait->Finish(absl::OkStatus());
    waits->AskAgain(*wait);
  });
}

void GraphVersionWaits::Run() {
  while (true) {
    const Waits::Due due = waits_->Next();
    for (const auto& wait : due.expired) wait->Finish(wait->TimedOut());
    for (const auto& wait : due.to_ask) Ask(graphs_, waits_, wait);
    if (due.expired.empty() && due.to_ask.empty()) return;
  }
}

}  // namespace enfilade::server
