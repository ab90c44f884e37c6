// SPDX-License-Identifier: Apache-2.0
#include "server/app/ingest/pose_reports.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/error.h"

namespace enfilade::server {
namespace {

// Sites whose reports are stored at the same time.
constexpr int kPoseWriters = 3;

}  // namespace

PoseReports::PoseReports(const storage::RobotPoseStore& store, const Options& options)
    : store_(store), options_(options), writers_(kPoseWriters, options.max_waiting) {
  gatherer_ = std::thread([this] { Gather(); });
}

PoseReports::~PoseReports() { Stop(); }

void PoseReports::Stop() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  if (gatherer_.joinable()) gatherer_.join();
  writers_.Stop();
}

void PoseReports::Report(storage::RobotPose pose, std::string actor, Answer answer) {
  absl::Status refusal;
  {
    MutexLock lock(mutex_);
    if (stopping_) {
      refusal = absl::UnavailableError("the server is shutting down: report again");
    } else if (waiting_ >= options_.max_waiting) {
      refusal = ResourceExhausted("{} reports of poses wait to be stored: report again later", waiting_);
    } else {
      std::deque<Waiting>& waiting = sites_[pose.site].waiting;
      waiting.push_back({std::move(pose), std::move(actor), std::move(answer)});
      if (++waiting_ == 1) changed_.NotifyAll();
    }
  }
  if (!refusal.ok()) answer(refusal);
}

void PoseReports::Gather() {
  MutexLock lock(mutex_);
  while (true) {
    while (waiting_ == 0 && !stopping_) changed_.Wait(mutex_);
    const auto due = std::chrono::steady_clock::now() + options_.gather;
    while (!stopping_ && changed_.WaitUntil(mutex_, due)) {
    }
    StartBatches();
    if (!stopping_) continue;
    while (!sites_.empty()) {
      changed_.Wait(mutex_);  // for batches that are being stored
      StartBatches();
    }
    return;
  }
}

void PoseReports::StartBatches() {
  for (auto& [site, reports] : sites_) {
    if (reports.storing || reports.waiting.empty()) continue;
    reports.storing = true;
    const std::size_t count = std::min(reports.waiting.size(), options_.max_batch);
    const auto end = reports.waiting.begin() + static_cast<std::ptrdiff_t>(count);
    const auto batch = std::make_shared<std::vector<Waiting>>(std::make_move_iterator(reports.waiting.begin()),
                                                              std::make_move_iterator(end));
    reports.waiting.erase(reports.waiting.begin(), end);
    waiting_ -= count;
    writers_.PostNext([this, site = site, batch] { Store(site, *batch); });
  }
}

void PoseReports::Store(const SiteId& site, const std::vector<Waiting>& batch) {
  std::vector<storage::RobotPose> poses;
  poses.reserve(batch.size());
  for (const Waiting& report : batch) poses.push_back(report.pose);
  storage::CallContext context = storage::CallContext::WithTimeout(options_.timeout);
  const std::string& actor = batch.front().actor;
  if (std::all_of(batch.begin(), batch.end(), [&](const Waiting& report) { return report.actor == actor; })) {
    context.actor = actor;
  }
  const std::vector<absl::Status> answers = store_.ReportAll(context, poses);
  for (std::size_t i = 0; i < batch.size(); ++i) batch[i].answer(answers[i]);
  MutexLock lock(mutex_);
  const auto found = sites_.find(site);
  found->second.storing = false;
  if (found->second.waiting.empty()) sites_.erase(found);
  changed_.NotifyAll();
}

}  // namespace enfilade::server
