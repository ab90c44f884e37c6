// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/load_generator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <latch>
#include <memory>
#include <random>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/channel_arguments.h"
#include "proto/convert/record.h"

namespace enfilade::bench {

grpc::ByteBuffer Serialize(const google::protobuf::MessageLite& message) {
  grpc::ByteBuffer buffer;
  bool own = false;
  grpc::GenericSerialize<grpc::ProtoBufferWriter, google::protobuf::MessageLite>(message, &buffer, &own);
  return buffer;
}

namespace {

using Clock = std::chrono::steady_clock;

// One robot. A read is always under way; writes while the window has room.
class Robot final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  Robot(const std::string& address, const std::string& session, int window, const std::vector<LoadBatch>& batches,
        std::latch& opened, std::latch& done)
      : batches_(batches), window_(window), opened_(opened), done_(done) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    stub_ = std::make_unique<grpc::GenericStub>(
        grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
    stub_->PrepareBidiStreamingCall(&context_, "/enfilade.v1.IngestService/StreamRecords", {}, this);
    v1::StreamRecordsRequest open;
    open.mutable_open()->set_session(session);
    open_ = Serialize(open);
  }

  void Open() {
    StartWrite(&open_);
    StartRead(&response_);
    StartCall();
  }

  void Send() {
    MutexLock lock(mutex_);
    sending_ = true;
    WriteNext();
  }

  void OnWriteDone(bool ok) override {
    MutexLock lock(mutex_);
    writing_ = false;
    if (ok) WriteNext();
  }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    v1::StreamRecordsResponse response;
    grpc::ProtoBufferReader reader(&response_);
    response.ParseFromZeroCopyStream(&reader);
    if (response.has_opened()) CountOpened();
    if (response.has_acknowledgement()) Acknowledged(response.acknowledgement().acknowledged_sequence());
    StartRead(&response_);
  }

  void OnDone(const grpc::Status& status) override {
    CountOpened();
    {
      MutexLock lock(mutex_);
      if (!status.ok()) error_ = status.error_message();
    }
    done_.count_down();  // may end this object
  }

  // After it is done.
  std::vector<double> TakeLatencies() {
    MutexLock lock(mutex_);
    return std::move(latency_ms_);
  }
  std::int64_t acknowledged() {
    MutexLock lock(mutex_);
    return acknowledged_;
  }
  std::string error() {
    MutexLock lock(mutex_);
    return error_;
  }

 private:
  struct InFlight {
    std::int64_t last_sequence;
    Clock::time_point sent;
  };

  void CountOpened() {
    if (!std::exchange(counted_, true)) opened_.count_down();
  }

  void WriteNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!sending_ || writing_ || next_ > batches_.size()) return;
    if (next_ == batches_.size()) {
      ++next_;
      StartWritesDone();
      return;
    }
    if (window_ > 0 && in_flight_.size() >= static_cast<std::size_t>(window_)) return;
    const LoadBatch& batch = batches_[next_++];
    request_ = batch.request;  // shares the bytes
    in_flight_.push_back({batch.last_sequence, Clock::now()});
    writing_ = true;
    StartWrite(&request_);
  }

  void Acknowledged(std::int64_t sequence) {
    const Clock::time_point now = Clock::now();
    MutexLock lock(mutex_);
    acknowledged_ = sequence;
    while (!in_flight_.empty() && in_flight_.front().last_sequence <= sequence) {
      latency_ms_.push_back(std::chrono::duration<double, std::milli>(now - in_flight_.front().sent).count());
      in_flight_.pop_front();
    }
    WriteNext();
  }

  const std::vector<LoadBatch>& batches_;
  const int window_;
  std::latch& opened_;
  std::latch& done_;
  bool counted_ = false;
  std::unique_ptr<grpc::GenericStub> stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer open_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;

  Mutex mutex_;
  bool sending_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = true;  // open
  std::size_t next_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<InFlight> in_flight_ ABSL_GUARDED_BY(mutex_);
  std::int64_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;
  std::vector<double> latency_ms_ ABSL_GUARDED_BY(mutex_);
  std::string error_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::vector<sensor::Record> RandomScans(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> range(0.5F, 12.0F);
  std::vector<sensor::Record> records;
  for (int i = 0; i < count; ++i) {
    sensor::LaserScan scan;
    scan.time = 1'700'000'000 * kNsPerSecond + i * (kNsPerSecond / 10);
    scan.angle_min = -M_PI / 2;
    scan.angle_increment = M_PI / 180;
    scan.range_min = 0.05F;
    scan.range_max = 20.0F;
    scan.ranges.resize(180);
    for (float& value : scan.ranges) value = range(random);
    records.push_back({i + 1, std::move(scan)});
  }
  return records;
}

std::vector<LoadBatch> ToBatches(const std::vector<sensor::Record>& records, int batch_records) {
  std::vector<LoadBatch> batches;
  for (std::size_t begin = 0; begin < records.size(); begin += static_cast<std::size_t>(batch_records)) {
    const std::size_t end = std::min(records.size(), begin + static_cast<std::size_t>(batch_records));
    v1::StreamRecordsRequest request;
    for (std::size_t i = begin; i < end; ++i) *request.mutable_batch()->add_records() = convert::ToProto(records[i]);
    grpc::ByteBuffer bytes = Serialize(request);
    const auto size = static_cast<std::int64_t>(bytes.Length());
    batches.push_back({std::move(bytes), records[end - 1].sequence, size});
  }
  return batches;
}

LoadResult LoadGenerator::Run() const {
  const auto count = static_cast<std::ptrdiff_t>(options_.sessions.size());
  std::latch opened(count);
  std::latch done(count);
  std::vector<std::unique_ptr<Robot>> robots;
  for (const std::string& session : options_.sessions) {
    robots.push_back(std::make_unique<Robot>(options_.address, session, options_.window, batches_, opened, done));
  }
  for (const auto& robot : robots) robot->Open();
  opened.wait();
  const Clock::time_point begin = Clock::now();
  for (const auto& robot : robots) robot->Send();
  done.wait();
  LoadResult result;
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  for (const auto& robot : robots) {
    result.acknowledged += robot->acknowledged();
    const std::vector<double> latencies = robot->TakeLatencies();
    result.latency_ms.insert(result.latency_ms.end(), latencies.begin(), latencies.end());
    if (result.error.empty()) result.error = robot->error();
  }
  return result;
}

double Percentile(std::vector<double>& values, double p) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const auto index = static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5);
  return values[index];
}

}  // namespace enfilade::bench
