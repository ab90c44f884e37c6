// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_server/fake_server.h"

#include <chrono>
#include <stdexcept>
#include <utility>

#include "grpcpp/security/server_credentials.h"
#include "grpcpp/server_builder.h"
#include "tests/support/fake_server/fake_ingest_service.h"

namespace enfilade::testing {
namespace {

grpc::Status NotFound(const std::string& what) { return {grpc::StatusCode::NOT_FOUND, what + " does not exist"}; }

}  // namespace

class FakeServer::Sessions final : public v1::SessionService::Service {
 public:
  explicit Sessions(FakeServer& owner) : owner_(owner) {}

  grpc::Status CreateSession(grpc::ServerContext*, const v1::CreateSessionRequest* request,
                             v1::CreateSessionResponse* response) override {
    if (auto status = owner_.At(Moment::kCreateSession); !status.ok()) return status;
    MutexLock lock(owner_.mutex_);
    if (!owner_.robots_.contains(request->session().robot())) return NotFound(request->session().robot());
    const std::string& map = request->session().map();
    if (!map.empty() && !owner_.maps_.contains(map) && !owner_.redirects_.contains(map)) return NotFound(map);
    const std::string name = request->parent() + "/sessions/" + request->session_id();
    const auto found = owner_.sessions_.find(name);
    if (found != owner_.sessions_.end() && found->second.request_id != request->request_id()) {
      return {grpc::StatusCode::ALREADY_EXISTS, name + " is taken"};
    }
    Session& session = owner_.sessions_[name];
    session.request_id = request->request_id();
    session.session = request->session();
    session.session.set_name(name);
    *response->mutable_session() = session.session;
    return grpc::Status::OK;
  }

  grpc::Status GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                          v1::GetSessionResponse* response) override {
    MutexLock lock(owner_.mutex_);
    const auto session = owner_.sessions_.find(request->name());
    if (session == owner_.sessions_.end()) return NotFound(request->name());
    ++session->second.asked;
    *response->mutable_session() = session->second.session;
    return grpc::Status::OK;
  }

  grpc::Status ListDoorVerdicts(grpc::ServerContext*, const v1::ListDoorVerdictsRequest* request,
                                v1::ListDoorVerdictsResponse* response) override {
    MutexLock lock(owner_.mutex_);
    const auto session = owner_.sessions_.find(request->parent());
    if (session == owner_.sessions_.end()) return NotFound(request->parent());
    response->mutable_verdicts()->Assign(session->second.verdicts.begin(), session->second.verdicts.end());
    return grpc::Status::OK;
  }

  grpc::Status FinishSession(grpc::ServerContext*, const v1::FinishSessionRequest* request,
                             v1::FinishSessionResponse* response) override {
    if (auto status = owner_.At(Moment::kFinishRequested); !status.ok()) return status;
    {
      MutexLock lock(owner_.mutex_);
      const auto session = owner_.sessions_.find(request->name());
      if (session == owner_.sessions_.end()) return NotFound(request->name());
      if (AcknowledgedOf(session->second) != request->last_sequence()) {
        return {grpc::StatusCode::FAILED_PRECONDITION, "the log has gaps or ends too early"};
      }
      session->second.finished = true;
      *response->mutable_session() = session->second.session;
    }
    return owner_.At(Moment::kFinished);
  }

 private:
  FakeServer& owner_;
};

class FakeServer::Robots final : public v1::RobotService::Service {
 public:
  explicit Robots(FakeServer& owner) : owner_(owner) {}

  grpc::Status CreateRobot(grpc::ServerContext*, const v1::CreateRobotRequest* request,
                           v1::CreateRobotResponse* response) override {
    const std::string name = request->parent() + "/robots/" + request->robot_id();
    MutexLock lock(owner_.mutex_);
    if (!owner_.robots_.insert(name).second) return {grpc::StatusCode::ALREADY_EXISTS, name};
    response->mutable_robot()->set_name(name);
    return grpc::Status::OK;
  }

 private:
  FakeServer& owner_;
};

class FakeServer::Maps final : public v1::MapService::Service {
 public:
  explicit Maps(FakeServer& owner) : owner_(owner) {}

  grpc::Status CreateMap(grpc::ServerContext*, const v1::CreateMapRequest* request,
                         v1::CreateMapResponse* response) override {
    MutexLock lock(owner_.mutex_);
    const std::string id = request->map_id().empty() ? "map-" + std::to_string(owner_.maps_.size()) : request->map_id();
    const std::string name = request->parent() + "/maps/" + id;
    if (!owner_.maps_.emplace(name, request->map().display_name()).second) {
      return {grpc::StatusCode::ALREADY_EXISTS, name};
    }
    response->mutable_map()->set_name(name);
    return grpc::Status::OK;
  }

  grpc::Status GetMap(grpc::ServerContext*, const v1::GetMapRequest* request, v1::GetMapResponse* response) override {
    MutexLock lock(owner_.mutex_);
    const auto redirect = owner_.redirects_.find(request->name());
    const auto map = owner_.maps_.find(redirect == owner_.redirects_.end() ? request->name() : redirect->second);
    if (map == owner_.maps_.end()) return NotFound(request->name());
    response->mutable_map()->set_name(map->first);
    response->mutable_map()->set_display_name(map->second);
    return grpc::Status::OK;
  }

  grpc::Status ListMaps(grpc::ServerContext*, const v1::ListMapsRequest* request,
                        v1::ListMapsResponse* response) override {
    MutexLock lock(owner_.mutex_);
    for (const auto& [name, display_name] : owner_.maps_) {
      if (display_name != request->display_name()) continue;
      v1::Map& map = *response->add_maps();
      map.set_name(name);
      map.set_display_name(display_name);
    }
    return grpc::Status::OK;
  }

 private:
  FakeServer& owner_;
};

class FakeServer::Status final : public v1::ServerService::Service {
 public:
  explicit Status(const FakeServer& owner) : owner_(owner) {}

  grpc::Status GetServerStatus(grpc::ServerContext*, const v1::GetServerStatusRequest*,
                               v1::GetServerStatusResponse* response) override {
    response->set_ready(true);
    response->set_surveys_sites(owner_.behaviour_.surveys_sites);
    return grpc::Status::OK;
  }

 private:
  const FakeServer& owner_;
};

FakeServer::FakeServer(std::string address, Behaviour behaviour)
    : address_(std::move(address)),
      behaviour_(std::move(behaviour)),
      ingest_(std::make_unique<Ingest>(*this)),
      sessions_service_(std::make_unique<Sessions>(*this)),
      robots_service_(std::make_unique<Robots>(*this)),
      maps_service_(std::make_unique<Maps>(*this)),
      status_service_(std::make_unique<Status>(*this)) {
  Start();
}

FakeServer::~FakeServer() { Stop(); }

void FakeServer::Start() {
  {
    MutexLock lock(mutex_);
    stopping_ = false;
  }
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
  builder.RegisterService(ingest_.get());
  builder.RegisterService(sessions_service_.get());
  builder.RegisterService(robots_service_.get());
  builder.RegisterService(maps_service_.get());
  builder.RegisterService(status_service_.get());
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("cannot listen at " + address_);
}

void FakeServer::Stop() {
  if (!server_) return;
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  server_->Shutdown(std::chrono::system_clock::now());
  server_->Wait();
  server_.reset();
}

void FakeServer::HoldAcknowledgements(bool hold) {
  MutexLock lock(mutex_);
  hold_acknowledgements_ = hold;
  changed_.NotifyAll();
}

grpc::Status FakeServer::At(Moment moment) {
  int count = 0;
  {
    MutexLock lock(mutex_);
    count = ++moments_[moment];
  }
  return behaviour_.interfere ? behaviour_.interfere(moment, count) : grpc::Status::OK;
}

std::int64_t FakeServer::AcknowledgedOf(const Session& session) {
  std::int64_t acknowledged = 0;
  for (const auto& [sequence, record] : session.records) {
    if (sequence != acknowledged + 1) break;
    acknowledged = sequence;
  }
  return acknowledged;
}

void FakeServer::Redirect(const std::string& from, const std::string& to) {
  MutexLock lock(mutex_);
  maps_.erase(from);
  redirects_[from] = to;
}

void FakeServer::Edit(const std::string& session, const std::function<void(Session&)>& change) {
  MutexLock lock(mutex_);
  change(sessions_[session]);
}

std::map<std::string, FakeServer::Session> FakeServer::sessions() {
  MutexLock lock(mutex_);
  return sessions_;
}
std::set<std::string> FakeServer::robots() {
  MutexLock lock(mutex_);
  return robots_;
}
std::map<std::string, std::string> FakeServer::maps() {
  MutexLock lock(mutex_);
  return maps_;
}
std::map<std::string, std::string> FakeServer::blobs() {
  MutexLock lock(mutex_);
  return blobs_;
}
std::int64_t FakeServer::records_received() {
  MutexLock lock(mutex_);
  return records_received_;
}
std::vector<v1::PoseReport> FakeServer::pose_reports() {
  MutexLock lock(mutex_);
  return pose_reports_;
}

int FakeServer::streams_opened() {
  MutexLock lock(mutex_);
  return streams_opened_;
}

}  // namespace enfilade::testing
