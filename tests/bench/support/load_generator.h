// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/sensor/record.h"
#include "google/protobuf/message_lite.h"
#include "grpcpp/support/byte_buffer.h"

namespace enfilade::bench {

grpc::ByteBuffer Serialize(const google::protobuf::MessageLite& message);

// `count` records with scans of 180 beams at random ranges, as of a 10 Hz scanner; sequences from 1.
std::vector<sensor::Record> RandomScans(int count, std::uint64_t seed);

// Requests of StreamRecords, ready to be sent: the generator stands for many machines and must not be what is measured.
struct LoadBatch {
  grpc::ByteBuffer request;
  std::int64_t last_sequence = 0;
  std::int64_t bytes = 0;
};
std::vector<LoadBatch> ToBatches(const std::vector<sensor::Record>& records, int batch_records);

struct LoadOptions {
  std::string address;
  std::vector<std::string> sessions;  // resource names, one robot each; each robot has a connection of its own
  int window = 8;                     // batches sent before the first of them is acknowledged; 0: without limit
};

struct LoadResult {
  double seconds = 0.0;            // from the first batch sent to the last acknowledgement
  std::int64_t acknowledged = 0;   // records, over all sessions
  std::vector<double> latency_ms;  // of each batch: from its being handed to gRPC to its acknowledgement
  std::string error;               // the first stream's that failed
};

// Robots that all send the same batches, each into its own session, and end when everything is acknowledged.
class LoadGenerator {
 public:
  LoadGenerator(LoadOptions options, const std::vector<LoadBatch>& batches)
      : options_(std::move(options)), batches_(batches) {}

  // Opens all streams, then sends; returns when the last one has ended.
  LoadResult Run() const;

 private:
  const LoadOptions options_;
  const std::vector<LoadBatch>& batches_;
};

// The value below which the share `p` of `values` lies; `values` gets sorted.
double Percentile(std::vector<double>& values, double p);

}  // namespace enfilade::bench
