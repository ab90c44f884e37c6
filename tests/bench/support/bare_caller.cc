// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/bare_caller.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace enfilade::bench {
namespace {

enum FrameType : std::uint8_t {
  kData = 0,
  kHeaders = 1,
  kReset = 3,
  kSettings = 4,
  kPing = 6,
  kGoAway = 7,
  kWindowUpdate = 8
};
constexpr std::uint8_t kAck = 1;
constexpr std::uint8_t kEndStream = 1;
constexpr std::uint8_t kEndHeaders = 4;
constexpr std::size_t kFrameHeader = 9;
constexpr std::size_t kMessageHeader = 5;  // gRPC's, before each message
constexpr std::uint32_t kWindow = 1U << 30;
constexpr std::uint32_t kInitialWindow = 65535;  // of HTTP/2
constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

int Connect(const std::string& address) {
  constexpr std::string_view kScheme = "unix:";
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (!address.starts_with(kScheme) || address.size() - kScheme.size() >= sizeof(name.sun_path)) {
    throw std::runtime_error(address + ": expected unix:/path");
  }
  std::copy(address.begin() + kScheme.size(), address.end(), name.sun_path);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket >= 0 && connect(socket, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0) return socket;
  if (socket >= 0) close(socket);
  throw std::runtime_error(address + ": " + std::strerror(errno));
}

void AppendBigEndian(std::string& out, std::uint32_t value, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) out.push_back(static_cast<char>(value >> shift & 0xFF));
}

std::uint32_t ReadBigEndian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

void AppendFrame(std::string& out, FrameType type, std::uint8_t flags, std::uint32_t stream, std::string_view payload) {
  AppendBigEndian(out, static_cast<std::uint32_t>(payload.size()), 3);
  out.push_back(static_cast<char>(type));
  out.push_back(static_cast<char>(flags));
  AppendBigEndian(out, stream, 4);
  out += payload;
}

void AppendWindowUpdate(std::string& out, std::uint32_t bytes) {
  std::string payload;
  AppendBigEndian(payload, bytes, 4);
  AppendFrame(out, kWindowUpdate, 0, 0, payload);
}

// At most 126 bytes, as they are (RFC 7541, 5.2).
void AppendText(std::string& out, std::string_view text) {
  out.push_back(static_cast<char>(text.size()));
  out += text;
}

// The first call's headers enter the connection's table, from which those that follow take them (RFC 7541, 6.1, 6.2.1).
std::string HeadersOf(std::string_view method, bool first) {
  std::string block = "\x83\x86";  // :method POST, :scheme http
  if (!first) return block + "\xC1\xC0\xBF\xBE";
  block += '\x44';  // :path
  AppendText(block, method);
  block += '\x41';  // :authority
  AppendText(block, "localhost");
  block += '\x5F';  // content-type
  AppendText(block, "application/grpc");
  block += '\x40';
  AppendText(block, "te");
  AppendText(block, "trailers");
  return block;
}

}  // namespace

BareCaller::BareCaller(const std::string& address, const std::string& method)
    : socket_(Connect(address)), method_(method), bytes_(1 << 16) {
  std::string settings;
  AppendBigEndian(settings, 4, 2);  // SETTINGS_INITIAL_WINDOW_SIZE
  AppendBigEndian(settings, kWindow, 4);
  out_ = kPreface;
  AppendFrame(out_, kSettings, 0, 0, settings);
  AppendWindowUpdate(out_, kWindow - kInitialWindow);
  Send(out_);
}

BareCaller::~BareCaller() { close(socket_); }

std::string_view BareCaller::Call(const google::protobuf::MessageLite& request) {
  const bool first = stream_ == 0;
  stream_ += first ? 1 : 2;
  out_.clear();
  AppendFrame(out_, kHeaders, kEndHeaders, stream_, HeadersOf(method_, first));
  const std::size_t size = request.ByteSizeLong();
  std::string message(1, '\0');  // not compressed
  AppendBigEndian(message, static_cast<std::uint32_t>(size), 4);
  request.AppendToString(&message);
  AppendFrame(out_, kData, kEndStream, stream_, message);
  Send(out_);
  response_.clear();
  while (true) {
    const Frame frame = Read();
    if (frame.stream != stream_) {
      Answer(frame);
      continue;
    }
    if (frame.type == kReset) throw std::runtime_error(method_ + " was reset");
    if (frame.type == kData) {
      response_ += frame.payload;
      unacknowledged_ += static_cast<std::uint32_t>(frame.payload.size());
    }
    if ((frame.type == kData || frame.type == kHeaders) && (frame.flags & kEndStream) != 0) break;
  }
  if (response_.size() < kMessageHeader) throw std::runtime_error(method_ + " failed");
  return std::string_view(response_).substr(kMessageHeader);
}

void BareCaller::Answer(const Frame& frame) {
  if (frame.type == kGoAway) throw std::runtime_error("the server ends the connection");
  if ((frame.flags & kAck) != 0 || (frame.type != kSettings && frame.type != kPing)) return;
  std::string answer;
  if (frame.type == kSettings) AppendFrame(answer, kSettings, kAck, 0, {});
  if (frame.type == kPing) AppendFrame(answer, kPing, kAck, 0, frame.payload);
  Send(answer);
}

void BareCaller::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) throw std::runtime_error(std::string("sending: ") + std::strerror(errno));
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

BareCaller::Frame BareCaller::Read() {
  if (unacknowledged_ > kWindow / 4) {
    std::string update;
    AppendWindowUpdate(update, unacknowledged_);
    unacknowledged_ = 0;
    Send(update);
  }
  Fill(kFrameHeader);
  const std::string_view header(bytes_.data() + begin_, kFrameHeader);
  const std::size_t size = ReadBigEndian(header.substr(0, 3));
  Frame frame{static_cast<std::uint8_t>(header[3]),
              static_cast<std::uint8_t>(header[4]),
              ReadBigEndian(header.substr(5)) & 0x7FFFFFFFU,
              {}};
  Fill(kFrameHeader + size);
  frame.payload = std::string_view(bytes_.data() + begin_ + kFrameHeader, size);
  begin_ += kFrameHeader + size;
  return frame;
}

void BareCaller::Fill(std::size_t count) {
  if (bytes_.size() - begin_ < count) {
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_), bytes_.begin() + static_cast<std::ptrdiff_t>(end_),
              bytes_.begin());
    end_ -= begin_;
    begin_ = 0;
    if (bytes_.size() < count) bytes_.resize(count);
  }
  while (end_ - begin_ < count) {
    if (begin_ == end_) begin_ = end_ = 0;
    const ssize_t got = recv(socket_, bytes_.data() + end_, bytes_.size() - end_, 0);
    if (got <= 0) throw std::runtime_error(got == 0 ? "the server has gone" : std::strerror(errno));
    end_ += static_cast<std::size_t>(got);
  }
}

}  // namespace enfilade::bench
