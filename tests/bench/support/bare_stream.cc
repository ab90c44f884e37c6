// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/bare_stream.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "enfilade/v1/map_service.grpc.pb.h"
#include "grpcpp/server_builder.h"

namespace enfilade::bench {
namespace {

constexpr std::size_t kMessageBytes = 1U << 20;

class BareService final : public v1::MapService::Service {
 public:
  explicit BareService(std::string bytes) : bytes_(std::move(bytes)) {}

  grpc::Status ExportMap(grpc::ServerContext*, const v1::ExportMapRequest*,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override {
    v1::ExportMapResponse message;
    for (std::size_t offset = 0; offset < bytes_.size(); offset += kMessageBytes) {
      message.mutable_chunk()->mutable_data()->assign(bytes_, offset, kMessageBytes);
      if (!writer->Write(message)) break;
    }
    return grpc::Status::OK;
  }

 private:
  const std::string bytes_;
};

}  // namespace

void ServeBareStream(const std::string& address, const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  BareService service(std::string(std::istreambuf_iterator<char>(in), {}));
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials());
  builder.RegisterService(&service);
  builder.BuildAndStart()->Wait();
}

}  // namespace enfilade::bench
