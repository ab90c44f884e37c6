// SPDX-License-Identifier: Apache-2.0
#include "tests/support/server_process.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "grpcpp/generic/generic_stub.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

// HealthCheckResponse, of which only field 1, the status, is used: 1 is SERVING. The health protocol's own sources are
// not among the distribution's packages.
Health ParseHealth(const grpc::ByteBuffer& response) {
  grpc::Slice slice;
  if (!response.DumpToSingleSlice(&slice).ok() || slice.size() != 2) return Health::kNotServing;
  return slice.begin()[0] == 0x08 && slice.begin()[1] == 0x01 ? Health::kServing : Health::kNotServing;
}

}  // namespace

Health HealthOf(const client::Connection& connection) {
  grpc::GenericStub stub(connection.channel());
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(5));
  grpc::ByteBuffer request(nullptr, 0);  // an empty HealthCheckRequest: the server as a whole
  grpc::ByteBuffer response;
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return status.ok() ? ParseHealth(response) : Health::kUnreachable;
}

ServerProcess::ServerProcess(const std::filesystem::path& directory, const std::string& name, std::string database_url,
                             std::vector<std::string> settings)
    : address_("unix:" + (directory / (name + ".sock")).string()), log_(directory / (name + ".log")) {
  settings.push_back("listen.address=" + address_);
  settings.push_back("metrics.address=");
  settings.push_back("transfers.cache_directory=" + directory.string());
  command_ = {Program("enfilade-server")};
  for (const std::string& setting : settings) {
    command_.emplace_back("--set");
    command_.push_back(setting);
  }
  environment_ = {"ENFILADE_SERVER_DATABASE_URL=" + std::move(database_url)};
}

void ServerProcess::Start() {
  if (process_ && process_->running()) return;
  process_ = std::make_unique<Process>(command_, log_, environment_);
}

void ServerProcess::StartAndWait() {
  Start();
  const client::Connection connection = Connect();
  const bool serving = Eventually([&] { return !process_->running() || HealthOf(connection) == Health::kServing; });
  if (!serving || !process_->running()) throw std::runtime_error("no server:\n" + TailOf(log_));
}

std::string TailOf(const std::filesystem::path& file) {
  constexpr std::size_t kBytes = 4000;
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  return text.size() > kBytes ? text.substr(text.size() - kBytes) : text;
}

}  // namespace enfilade::testing
