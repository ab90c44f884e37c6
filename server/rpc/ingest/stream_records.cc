// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/stream_records.h"

#include <deque>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/ingest/batch.h"
#include "server/rpc/ingest/stream_messages.h"
#include "server/rpc/session/door_verdict.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxWaitingResponses = 64;

// One stream: reading -> (half-closed by the client, failed or draining) -> pending batches are answered -> finished.
// At most one read and one write are in progress. Called by gRPC's callbacks, the executor and Ingest's writers; only
// the executor's calls may block. Reading stops while a client leaves many answers unread.
class StreamRecordsReactor final : public grpc::ServerBidiReactor<v1::StreamRecordsRequest, v1::StreamRecordsResponse>,
                                   public std::enable_shared_from_this<StreamRecordsReactor> {
 public:
  StreamRecordsReactor(const Services& services, const CallEntry& entry)
      : services_(services), context_(entry.context), call_(BeginCall(entry)), blob_(services.uploads) {}

  void Begin() {
    self_ = shared_from_this();
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return EndReading(absl::OkStatus());
    switch (request_.request_case()) {
      case v1::StreamRecordsRequest::kOpen:
        return OpenSession();
      case v1::StreamRecordsRequest::kBatch:
        return TakeBatch();
      case v1::StreamRecordsRequest::kBlobChunk:
        return TakeChunk();
      case v1::StreamRecordsRequest::kPoseReport:
        return TakePose();
      case v1::StreamRecordsRequest::REQUEST_NOT_SET:
        break;
    }
    EndReading(InvalidArgument("the message has no content: expected open, batch, blob_chunk or pose_report"));
  }

  void OnWriteDone(bool ok) override {
    MutexLock lock(mutex_);
    writing_ = false;
    if (!ok) responses_.clear();
    WriteNext();
    if (reading_paused_ && responses_.size() < kMaxWaitingResponses / 2) {
      reading_paused_ = false;
      if (!ending_) StartRead(&request_);
    }
  }

  void OnCancel() override {
    call_.Cancel();
    EndReading(absl::CancelledError("the client has gone"));
  }

  void OnDone() override {
    std::shared_ptr<Ingest::Stream> stream;
    {
      MutexLock lock(mutex_);
      stream = std::move(stream_);
    }
    if (stream) services_.ingest.Close(stream);
    self_.reset();  // may end this object
  }

 private:
  void OpenSession() {
    if (opening_) return EndReading(InvalidArgument("open was sent twice: one stream carries one session"));
    opening_ = true;
    absl::StatusOr<convert::SessionName> name = convert::ParseSessionName("open.session", request_.open().session());
    if (!name.ok()) return EndReading(name.status());
    {
      MutexLock lock(mutex_);  // EndReading() reads the site
      call_.set_site(name->site.value());
    }
    call_.RunStep(CallLane::kUsual, [self = shared_from_this(), name = *std::move(name)](
                                        const absl::Status& admitted, const storage::CallContext& context) {
      if (admitted.ok()) return self->Open(context, name);
      self->EndReading(admitted);
    });
  }

  void Open(const storage::CallContext& context, const convert::SessionName& name) {
    const absl::StatusOr<storage::Session> session = services_.sessions.Get(context, name.site, name.session);
    if (!session.ok()) return EndReading(session.status());
    const std::shared_ptr<Ingest::Stream> stream = services_.ingest.Open(
        name, [self = std::weak_ptr<StreamRecordsReactor>(shared_from_this())](const IngestEvent& event) {
          if (const auto reactor = self.lock()) reactor->OnEvent(event);
        });
    bool ended = false;
    {
      MutexLock lock(mutex_);
      ended = ending_;  // cancelled meanwhile: OnDone may have come already
      if (!ended) {
        stream_ = stream;
        robot_ = {name.site, session->robot};
        session_ = name.session;
        responses_.emplace_back().mutable_opened()->set_acknowledged_sequence(session->acknowledged_sequence);
        WriteNext();
      }
    }
    if (ended) return services_.ingest.Close(stream);
    AwaitMap(name, session->entry);
    ReadOn();
  }

  // If the robot came into its map through a door, or was placed there.
  void AwaitMap(const convert::SessionName& name, const sensor::SessionEntry& entry) {
    if (!entry.previous && !entry.T_map_robot) return;
    const auto self = std::weak_ptr<StreamRecordsReactor>(shared_from_this());
    services_.map_entries.Await(name, self, [self](const MapEntry& entered) {
      const auto reactor = self.lock();
      if (!reactor) return;
      MutexLock lock(reactor->mutex_);
      if (reactor->finished_ || reactor->ending_) return;
      *reactor->responses_.emplace_back().mutable_map_entered() = ToProto(entered);
      reactor->WriteNext();
    });
  }

  void TakeBatch() {
    const std::size_t bytes = request_.batch().ByteSizeLong();
    Offer(ReadBatch(request_.batch()), bytes);
  }

  void TakeChunk() {
    const absl::StatusOr<bool> complete = blob_.Add(request_.blob_chunk());
    if (!complete.ok()) return EndReading(complete.status());
    if (!*complete) return ReadOn();
    IngestBlob blob = blob_.Take();
    const auto bytes = static_cast<std::size_t>(blob.data.size());
    Offer(std::move(blob), bytes);
  }

  // While one report is being stored the newest waits, and replaces any that waited.
  void TakePose() {
    absl::StatusOr<storage::RobotPose> pose = ReadPoseReport(request_.pose_report());
    bool is_open = false;
    {
      MutexLock lock(mutex_);
      is_open = stream_ != nullptr;
      if (is_open && pose.ok() && pose->site != robot_.site)
        pose = InvalidArgument("pose_report.map is of another site");
      if (is_open && pose.ok()) {
        pose->robot = robot_.robot;
        pose->session = session_;
        waiting_pose_ = *std::move(pose);
        StorePose();
      } else if (is_open) {
        RefusePose(pose.status());
      }
    }
    if (!is_open) return EndReading(InvalidArgument("the first message must be open"));
    ReadOn();
  }

  void StorePose() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (storing_pose_ || !waiting_pose_) return;
    storing_pose_ = true;
    // What was received is stored, even if the client has gone since.
    services_.pose_reports.Report(*std::exchange(waiting_pose_, {}), call_.context().actor,
                                  [self = shared_from_this()](const absl::Status& stored) {
                                    self->call_.Continue([self, stored] { self->OnPoseStored(stored); });
                                  });
  }

  void OnPoseStored(const absl::Status& stored) {
    MutexLock lock(mutex_);
    storing_pose_ = false;
    if (!stored.ok()) RefusePose(stored);
    StorePose();
  }

  void RefusePose(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (finished_) return;
    v1::StreamRecordsResponse response;
    response.mutable_pose_report_refused()->set_message(std::string(status.message()));
    responses_.push_back(std::move(response));
    WriteNext();
  }

  void Offer(IngestItem item, std::size_t bytes) {
    std::shared_ptr<Ingest::Stream> stream;
    {
      MutexLock lock(mutex_);
      stream = stream_;
      if (stream) {
        if (!std::holds_alternative<IngestBlob>(item)) ++unanswered_;
        waiting_for_room_ = true;  // before Offer returns: RoomAgain may come earlier
      }
    }
    if (!stream) return EndReading(InvalidArgument("the first message must be open"));
    if (!services_.ingest.Offer(stream, std::move(item), bytes)) return;
    bool read_on = false;
    {
      MutexLock lock(mutex_);
      read_on = std::exchange(waiting_for_room_, false);
    }
    if (read_on) ReadOn();
  }

  void OnEvent(const IngestEvent& event) {
    if (const auto* stored = std::get_if<Stored>(&event)) {
      MutexLock lock(mutex_);
      --unanswered_;
      Acknowledge(stored->acknowledged_sequence);
      WriteNext();
    } else if (const auto* refusal = std::get_if<Refusal>(&event)) {
      MutexLock lock(mutex_);
      --unanswered_;
      responses_.push_back(ToResponse(*refusal));
      WriteNext();
    } else if (const auto* failed = std::get_if<Failed>(&event)) {
      EndReading(failed->status);
    } else if (std::holds_alternative<Drained>(event)) {
      EndReading(absl::UnavailableError("the server is shutting down: try again"));
    } else {
      bool read_on = false;
      {
        MutexLock lock(mutex_);
        read_on = std::exchange(waiting_for_room_, false);
      }
      if (read_on) ReadOn();
    }
  }

  // Acknowledgements are cumulative: one that still waits to be written is updated.
  void Acknowledge(std::int64_t sequence) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (responses_.empty() || !responses_.back().has_acknowledgement()) responses_.emplace_back();
    responses_.back().mutable_acknowledgement()->set_acknowledged_sequence(sequence);
  }

  void ReadOn() {
    MutexLock lock(mutex_);
    reading_paused_ = responses_.size() >= kMaxWaitingResponses;
    if (!ending_ && !reading_paused_) StartRead(&request_);
  }

  // Reads no more. OK: pending batches are answered first.
  void EndReading(absl::Status status) {
    MutexLock lock(mutex_);
    if (ending_ && (!status_.ok() || status.ok())) return;
    ending_ = true;
    status_ = std::move(status);
    WriteNext();
  }

  void WriteNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (writing_ || finished_) return;
    if (!responses_.empty() && !absl::IsCancelled(status_)) {
      response_ = std::move(responses_.front());
      responses_.pop_front();
      writing_ = true;
      StartWrite(&response_);
    } else if (ending_ && (unanswered_ == 0 || !status_.ok())) {
      finished_ = true;
      Finish(FinishCall(call_, context_, status_));
    }
  }

  const Services& services_;
  grpc::CallbackServerContext& context_;
  Call call_;
  std::shared_ptr<StreamRecordsReactor> self_;  // until OnDone()

  v1::StreamRecordsRequest request_;  // of the read in progress
  // Used by the reading side only.
  BlobAssembly blob_;
  bool opening_ = false;

  Mutex mutex_;
  std::shared_ptr<Ingest::Stream> stream_ ABSL_GUARDED_BY(mutex_);
  convert::RobotName robot_ ABSL_GUARDED_BY(mutex_);  // of the session
  SessionId session_ ABSL_GUARDED_BY(mutex_);
  std::optional<storage::RobotPose> waiting_pose_ ABSL_GUARDED_BY(mutex_);
  bool storing_pose_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<v1::StreamRecordsResponse> responses_ ABSL_GUARDED_BY(mutex_);
  v1::StreamRecordsResponse response_;  // of the write in progress
  std::int64_t unanswered_ ABSL_GUARDED_BY(mutex_) = 0;
  bool waiting_for_room_ ABSL_GUARDED_BY(mutex_) = false;
  bool reading_paused_ ABSL_GUARDED_BY(mutex_) = false;  // until most responses are written
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool ending_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

grpc::ServerBidiReactor<v1::StreamRecordsRequest, v1::StreamRecordsResponse>* StreamRecords(const Services& services,
                                                                                            const CallEntry& entry) {
  const auto reactor = std::make_shared<StreamRecordsReactor>(services, entry);
  reactor->Begin();
  return reactor.get();
}

}  // namespace enfilade::server
