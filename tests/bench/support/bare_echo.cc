// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/bare_echo.h"

#include <fstream>
#include <iterator>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "grpcpp/server_builder.h"

namespace enfilade::bench {
namespace {

class BareService final : public v1::GraphService::CallbackService {
 public:
  explicit BareService(const std::string& bytes) { response_.ParseFromString(bytes); }

  grpc::ServerUnaryReactor* GetGlobalPose(grpc::CallbackServerContext* call, const v1::GetGlobalPoseRequest*,
                                          v1::GetGlobalPoseResponse* response) override {
    *response = response_;
    grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }

 private:
  v1::GetGlobalPoseResponse response_;
};

}  // namespace

void ServeBareEcho(const std::string& address, const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  BareService service(std::string(std::istreambuf_iterator<char>(in), {}));
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials());
  builder.RegisterService(&service);
  builder.BuildAndStart()->Wait();
}

}  // namespace enfilade::bench
