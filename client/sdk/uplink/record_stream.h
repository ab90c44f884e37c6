// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "core/base/mutex.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"

namespace enfilade::client {

struct RecordStreamOptions {
  // Sent and not yet acknowledged.
  int max_batches_in_flight = 8;
  std::int64_t max_batch_records = 2000;
  std::int64_t max_batch_bytes = 1 << 20;  // a larger record is a batch by itself
};

// One stream to the server, from `open` to its end, for one session of a spool. The caller's thread sends; a second
// thread receives.
class RecordStream {
 public:
  struct Listener {
    std::function<void(std::int64_t acknowledged_sequence)> on_acknowledged;  // also on `opened`
    std::function<void(std::int64_t sequence)> on_sent;                       // the last record sent
    std::function<void(std::int64_t sequence, const std::string& reason)> on_quarantined;
    std::function<void(const v1::MapEntered&)> on_map_entered;  // which map the session is mapped into
    // The pose to report next, once; called at least every 200 ms.
    std::function<std::optional<v1::PoseReport>()> take_pose_report;
    std::function<void(const std::string& message)> on_pose_report_refused;
  };
  enum class End {
    kComplete,   // the session is finished and all of it is acknowledged
    kAgain,      // a refused record is in quarantine: open another stream now
    kBroken,     // try again later
    kPermanent,  // trying again would fail alike
  };
  struct Outcome {
    End end = End::kComplete;
    absl::Status status;  // why, for kBroken and kPermanent
  };

  // `spool` must outlive the stream. The listener is called from both threads.
  RecordStream(const Connection& connection, Spool& spool, SessionId session, const RecordStreamOptions& options,
               Listener listener);

  // Sends until the session is finished and acknowledged, the stream breaks, or Cancel. Call once.
  Outcome Run();
  // Ends Run soon, from any thread.
  void Cancel();

 private:
  using Stream = grpc::ClientReaderWriterInterface<v1::StreamRecordsRequest, v1::StreamRecordsResponse>;

  bool Open(Stream& stream);
  // Returns when there is nothing more to send on this stream; false if it is broken.
  bool SendAll(Stream& stream);
  bool SendNext(Stream& stream, std::int64_t after_sequence);
  bool SendPoseReport(Stream& stream);
  bool SendBlob(Stream& stream, const sensor::BlobRef& blob, const std::string& content);
  void ReceiveAll(Stream& stream);
  void Receive(const v1::StreamRecordsResponse& response);
  void Opened(std::int64_t acknowledged_sequence);
  void Acknowledged(std::int64_t sequence);
  void Refused(const v1::BatchRefused& refusal);
  void Withhold(std::int64_t sequence, const std::string& reason);
  // Ends the stream from this side.
  void Fail(absl::Status status, End end);
  SpoolSession Session();
  // Waits until the receiver has an answer, or the stream ends.
  void WaitForRoom();

  const Connection& connection_;
  Spool& spool_;
  const SessionId id_;
  const RecordStreamOptions options_;
  const Listener listener_;
  grpc::ClientContext context_;

  Mutex mutex_;
  CondVar changed_;
  bool opened_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;  // nothing more will be received
  std::int64_t sent_sequence_ ABSL_GUARDED_BY(mutex_) = 0;
  // A record was refused: nothing more is sent, but what was sent is still answered. So no record is sent twice on one
  // stream, and no answer is about an older copy.
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<std::int64_t> in_flight_ ABSL_GUARDED_BY(mutex_);  // the last sequence of each batch
  Outcome failure_ ABSL_GUARDED_BY(mutex_);                     // status not OK: ended from this side
  std::set<std::string> blobs_sent_;                            // used by the sender only
};

// Whether trying again would fail alike: the request is wrong, or the caller may not make it.
bool IsPermanent(const absl::Status& status);

}  // namespace enfilade::client
