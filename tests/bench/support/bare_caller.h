// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "google/protobuf/message_lite.h"

namespace enfilade::bench {

// Calls one unary method again and again, one call after the other on a connection of its own, with as little work as
// libpq has: gRPC's framing over HTTP/2 (RFC 9113, RFC 7541) without gRPC's client, which costs as much of a processor
// as the server that it measures. It reads no metadata; a call without a response has failed. Throws where it does.
class BareCaller {
 public:
  // `address`: unix:/path. `method`: /package.Service/Method.
  BareCaller(const std::string& address, const std::string& method);
  ~BareCaller();
  BareCaller(const BareCaller&) = delete;
  BareCaller& operator=(const BareCaller&) = delete;

  // Returns the response as it travels, valid until the next call.
  std::string_view Call(const google::protobuf::MessageLite& request);

 private:
  struct Frame {
    std::uint8_t type = 0;
    std::uint8_t flags = 0;
    std::uint32_t stream = 0;
    std::string_view payload;  // valid until the next one is read
  };

  void Send(std::string_view bytes);
  Frame Read();
  // Makes `bytes_` hold that many unread bytes.
  void Fill(std::size_t count);
  // What belongs to the connection and to no call.
  void Answer(const Frame& frame);

  const int socket_;
  const std::string method_;
  std::uint32_t stream_ = 0;  // of the last call
  std::uint32_t unacknowledged_ = 0;
  std::vector<char> bytes_;
  std::size_t begin_ = 0;  // of what is unread
  std::size_t end_ = 0;
  std::string out_;
  std::string response_;
};

}  // namespace enfilade::bench
