// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// A graph store that lets a test run something between the calls of another one, count them, and control its listeners.
class GraphStoreProbe final : public storage::GraphStore {
 public:
  explicit GraphStoreProbe(const storage::GraphStore& store) : store_(store) {}

  // Called after each read of changes or before each Apply, in the caller's thread. Null: nothing.
  void set_after_read(std::function<void()> hook) { Set(after_read_, std::move(hook)); }
  void set_before_apply(std::function<void()> hook) { Set(before_apply_, std::move(hook)); }
  // kLossy: the connection stands, but loses notifications. kSilent: nothing tells of changes. kBroken: there is no
  // connection.
  enum class Listening { kWorking, kLossy, kSilent, kBroken };
  void set_listening(Listening listening) {
    MutexLock lock(mutex_);
    listening_ = listening;
  }

  int reads() const { return Get(reads_); }
  int applies() const { return Get(applies_); }
  int locked_solves() const { return Get(locked_solves_); }

  absl::StatusOr<std::int64_t> GetVersion(const storage::CallContext& context, const SiteId& site) const override {
    return store_.GetVersion(context, site);
  }
  absl::StatusOr<storage::GraphChanges> ReadChanges(const storage::CallContext& context, const SiteId& site,
                                                    std::int64_t since) const override {
    auto changes = store_.ReadChanges(context, site, since);
    Call(reads_, after_read_);
    return changes;
  }
  absl::StatusOr<std::int64_t> Apply(const storage::CallContext& context, const SiteId& site, std::int64_t version,
                                     const storage::GraphSolution& solution) const override {
    Call(applies_, before_apply_);
    return store_.Apply(context, site, version, solution);
  }
  absl::StatusOr<std::int64_t> SolveHeld(
      const storage::CallContext& context, const SiteId& site, std::int64_t since,
      const std::function<absl::StatusOr<storage::GraphSolution>(const storage::GraphChanges&)>& solve) const override {
    Call(locked_solves_, {});
    return store_.SolveHeld(context, site, since, solve);
  }
  absl::StatusOr<std::vector<storage::GraphVersion>> ListVersions(const storage::CallContext& context,
                                                                  const SiteId& site, std::int64_t before,
                                                                  int limit) const override {
    return store_.ListVersions(context, site, before, limit);
  }
  absl::StatusOr<std::int64_t> FindLastOptimization(const storage::CallContext& context, const SiteId& site,
                                                    std::int64_t since) const override {
    return store_.FindLastOptimization(context, site, since);
  }
  absl::StatusOr<storage::MapPoseChanges> GetMapPoses(const storage::CallContext& context, const SiteId& site,
                                                      std::int64_t version, std::int64_t since) const override {
    return store_.GetMapPoses(context, site, version, since);
  }
  absl::StatusOr<std::vector<storage::MapPose>> GetPlaces(const storage::CallContext& context, const SiteId& site,
                                                          const std::vector<MapId>& maps) const override {
    return store_.GetPlaces(context, site, maps);
  }
  absl::StatusOr<std::int64_t> SetControlPoints(const storage::CallContext& context, const SiteId& site,
                                                const std::vector<storage::ControlPoint>& points) const override {
    return store_.SetControlPoints(context, site, points);
  }
  absl::StatusOr<std::vector<storage::ControlPoint>> GetControlPoints(const storage::CallContext& context,
                                                                      const SiteId& site) const override {
    return store_.GetControlPoints(context, site);
  }
  absl::StatusOr<std::vector<storage::StoredPlanTies>> ReadPlanTies(
      const storage::CallContext& context, const SiteId& site, const std::vector<std::string>& known) const override {
    return store_.ReadPlanTies(context, site, known);
  }
  absl::StatusOr<std::vector<storage::GraphListener::Change>> ListVersionsOf(
      const storage::CallContext& context, const std::vector<SiteId>& sites) const override {
    if (Get(listening_) == Listening::kSilent) return std::vector<storage::GraphListener::Change>();
    return store_.ListVersionsOf(context, sites);
  }
  absl::StatusOr<std::unique_ptr<storage::GraphListener>> Listen(const storage::CallContext& context) const override {
    if (Get(listening_) == Listening::kBroken) return absl::UnavailableError("no connection");
    auto listener = store_.Listen(context);
    if (!listener.ok()) return listener.status();
    return std::make_unique<Listener>(*this, *std::move(listener));
  }

 private:
  class Listener final : public storage::GraphListener {
   public:
    Listener(const GraphStoreProbe& probe, std::unique_ptr<storage::GraphListener> listener)
        : probe_(probe), listener_(std::move(listener)) {}

    absl::StatusOr<std::vector<Change>> Await(const storage::CallContext& context) override {
      const auto soon = std::chrono::steady_clock::now() + std::chrono::milliseconds(5);
      auto changes = listener_->Await({.deadline = std::min(soon, context.deadline)});
      const Listening listening = probe_.Get(probe_.listening_);
      if (listening == Listening::kBroken) return absl::UnavailableError("the connection is lost");
      if (listening != Listening::kWorking) return std::vector<Change>();
      return changes;
    }

   private:
    const GraphStoreProbe& probe_;
    const std::unique_ptr<storage::GraphListener> listener_;
  };

  void Set(std::function<void()>& hook, std::function<void()> value) {
    MutexLock lock(mutex_);
    hook = std::move(value);
  }
  template <typename T>
  T Get(const T& value) const {
    MutexLock lock(mutex_);
    return value;
  }
  void Call(int& calls, const std::function<void()>& hook) const {
    std::function<void()> run;
    {
      MutexLock lock(mutex_);
      ++calls;
      run = hook;
    }
    if (run) run();
  }

  const storage::GraphStore& store_;
  mutable Mutex mutex_;
  std::function<void()> after_read_;
  std::function<void()> before_apply_;
  Listening listening_ = Listening::kWorking;
  mutable int reads_ = 0;
  mutable int applies_ = 0;
  mutable int locked_solves_ = 0;
};

}  // namespace enfilade::server
