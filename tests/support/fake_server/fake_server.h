// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "grpcpp/server.h"

namespace enfilade::testing {

// The points of a conversation at which a fake server can interfere.
enum class Moment {
  kCreateSession,  // before it is created
  kOpenReceived,
  kOpenedSent,
  kChunkReceived,
  kBatchReceived,  // not yet stored
  kBatchStored,    // not yet acknowledged
  kAcknowledged,
  kHalfClosed,       // the client will send no more
  kFinishRequested,  // before the session is finished
  kFinished,         // before the answer goes out
};

// An in-memory server of the ingest API behind real gRPC on a socket, for tests of clients. It follows the rules of the
// protos and can be made to misbehave. It also answers for sessions, robots, maps, and whatever else robots ask for.
class FakeServer {
 public:
  struct Behaviour {
    // Called at every moment, with the number of times that it has come (from 1): a status that is not OK ends the
    // call.
    std::function<grpc::Status(Moment, int)> interfere = {};
    // Called for every record: a reason refuses the batch.
    std::function<std::optional<std::string>(const v1::Record&)> refuse = {};
    // Sent on every stream, after `opened`.
    std::optional<v1::MapEntered> map_entered = {};
    // Called for every pose report: a reason refuses it.
    std::function<std::optional<std::string>(const v1::PoseReport&)> refuse_pose = {};
    // As it says of itself.
    bool surveys_sites = false;
  };

  // `address`: unix:/path.
  FakeServer(std::string address, Behaviour behaviour);
  explicit FakeServer(std::string address) : FakeServer(std::move(address), Behaviour{}) {}
  ~FakeServer();

  const std::string& address() const { return address_; }

  // While held, batches are received and stored but not acknowledged.
  void HoldAcknowledgements(bool hold);
  // Closes the connections and the socket. What is stored remains for the next Start.
  void Stop();
  void Start();

  struct Session {
    v1::Session session;
    std::string request_id;
    std::map<std::int64_t, v1::Record> records;
    int conflicts = 0;   // different content under a stored sequence
    int duplicates = 0;  // the same content again
    bool finished = false;
    std::vector<v1::DoorVerdict> verdicts = {};  // as ListDoorVerdicts gives them
    int asked = 0;                               // how often GetSession was called
  };
  // By resource name.
  std::map<std::string, Session> sessions();
  std::set<std::string> robots();
  std::map<std::string, std::string> maps();   // resource name -> display name
  std::map<std::string, std::string> blobs();  // SHA-256 -> bytes
  std::int64_t records_received();             // in total, with duplicates
  int streams_opened();
  std::vector<v1::PoseReport> pose_reports();  // that were accepted

  // The highest sequence without a gap before it.
  static std::int64_t AcknowledgedOf(const Session& session);

  // Merges a map into another one (resource names): its name leads there. Poses stay as they are sent.
  void Redirect(const std::string& from, const std::string& to);
  // Changes what is stored.
  void Edit(const std::string& session, const std::function<void(Session&)>& change);

 private:
  class Ingest;
  class Sessions;
  class Robots;
  class Maps;
  class Status;

  grpc::Status At(Moment moment);

  const std::string address_;
  const Behaviour behaviour_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<Sessions> sessions_service_;
  std::unique_ptr<Robots> robots_service_;
  std::unique_ptr<Maps> maps_service_;
  std::unique_ptr<Status> status_service_;
  std::unique_ptr<grpc::Server> server_;

  Mutex mutex_;
  CondVar changed_;
  bool hold_acknowledgements_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<Moment, int> moments_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> robots_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> maps_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> redirects_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> blobs_ ABSL_GUARDED_BY(mutex_);
  std::int64_t records_received_ ABSL_GUARDED_BY(mutex_) = 0;
  int streams_opened_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<v1::PoseReport> pose_reports_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::testing
