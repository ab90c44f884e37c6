// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/readiness.h"

#include <utility>

#include "core/base/error.h"

namespace enfilade::server {
namespace {

Readiness::State StateFrom(const absl::StatusOr<storage::SchemaState>& schema) {
  if (!schema.ok()) {
    return {false,
            "the database does not answer: " + std::string(schema.status().message()),
            {},
            schema.status().ToString()};
  }
  switch (schema->position) {
    case storage::SchemaState::Position::kAtHead:
    case storage::SchemaState::Position::kAhead:
      return {true, "", *schema, {}};
    case storage::SchemaState::Position::kEmpty:
      return {false, "the database has no schema: run deploy/database/migrate up", *schema, {}};
    case storage::SchemaState::Position::kBehind:
      return {false,
              fmt::format("the database is at {}, this program needs {}: run deploy/database/migrate up",
                          schema->deployed, schema->expected),
              *schema,
              {}};
    case storage::SchemaState::Position::kTooNew:
      return {false,
              fmt::format("the database is at {}: its change {} needs a program that knows {}, this one is for {}: use "
                          "a newer one",
                          schema->deployed, schema->breaking, schema->required, schema->expected),
              *schema,
              {}};
  }
  return {false, "unknown schema state", *schema, {}};
}

}  // namespace

Readiness::Readiness(CheckSchema check_schema, std::function<void(const State&)> on_change,
                     std::chrono::milliseconds interval)
    : check_schema_(std::move(check_schema)), on_change_(std::move(on_change)), interval_(interval) {
  State first = StateFrom(check_schema_());
  {
    MutexLock lock(mutex_);
    state_ = first;
  }
  on_change_(first);
  thread_ = std::thread([this] { Run(); });
}

Readiness::~Readiness() {
  stop_.Set();
  thread_.join();
}

Readiness::State Readiness::state() const {
  MutexLock lock(mutex_);
  return state_;
}

void Readiness::Drain() {
  State drained;
  {
    MutexLock lock(mutex_);
    draining_ = true;
    state_.ready = false;
    state_.reason = "the server is shutting down";
    drained = state_;
  }
  on_change_(drained);
}

void Readiness::Check() {
  const State found = StateFrom(check_schema_());
  bool changed = false;
  {
    MutexLock lock(mutex_);
    if (draining_) return;
    changed = found.ready != state_.ready;
    state_ = found;
  }
  if (changed) on_change_(found);
}

void Readiness::Run() {
  while (!stop_.WaitFor(interval_)) Check();
}

}  // namespace enfilade::server
