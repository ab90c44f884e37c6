// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_server/cutting_proxy.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace enfilade::testing {
namespace {

sockaddr_un AddressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) throw std::runtime_error("the socket's path is too long: " + path);
  std::memcpy(address.sun_path, path.c_str(), path.size());
  return address;
}

}  // namespace

CuttingProxy::CuttingProxy(std::string listen_path, std::string server_path, std::vector<Cut> cuts)
    : listen_path_(std::move(listen_path)),
      server_path_(std::move(server_path)),
      listener_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)),
      cuts_(cuts.begin(), cuts.end()) {
  const sockaddr_un address = AddressOf(listen_path_);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 || listen(listener_, 8) != 0 ||
      pipe(stop_pipe_) != 0) {
    throw std::runtime_error("the proxy cannot listen at " + listen_path_);
  }
  acceptor_ = std::thread([this] { Accept(); });
}

CuttingProxy::~CuttingProxy() {
  close(stop_pipe_[1]);  // every poll sees the hang-up
  acceptor_.join();
  std::vector<std::thread> connections;
  {
    MutexLock lock(mutex_);
    connections.swap(connections_);
  }
  for (std::thread& connection : connections) connection.join();
  close(stop_pipe_[0]);
  close(listener_);
}

int CuttingProxy::connections() {
  MutexLock lock(mutex_);
  return static_cast<int>(connections_.size());
}

int CuttingProxy::cuts_made() {
  MutexLock lock(mutex_);
  return cuts_made_;
}

void CuttingProxy::Accept() {
  while (true) {
    pollfd polled[2] = {{listener_, POLLIN, 0}, {stop_pipe_[0], POLLIN, 0}};
    poll(polled, 2, -1);
    if (polled[1].revents != 0) return;
    const int client = accept(listener_, nullptr, nullptr);
    if (client < 0) continue;
    const int server = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = AddressOf(server_path_);
    if (connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      close(client);
      close(server);
      continue;
    }
    MutexLock lock(mutex_);
    Cut cut;
    if (!cuts_.empty()) {
      cut = cuts_.front();
      cuts_.pop_front();
    }
    connections_.emplace_back([this, client, server, cut] { Serve(client, server, cut); });
  }
}

void CuttingProxy::Serve(int client, int server, Cut cut) {
  pollfd stopped = {stop_pipe_[0], POLLIN, 0};
  bool open = poll(&stopped, 1, static_cast<int>(cut.delay.count())) == 0;
  while (open) {
    pollfd polled[3] = {{client, POLLIN, 0}, {server, POLLIN, 0}, {stop_pipe_[0], POLLIN, 0}};
    poll(polled, 3, -1);
    if (polled[2].revents != 0) break;
    if (polled[0].revents != 0) open = Forward(client, server, cut.upstream_bytes);
    if (open && polled[1].revents != 0) open = Forward(server, client, cut.downstream_bytes);
  }
  close(client);
  close(server);
}

bool CuttingProxy::Forward(int from, int to, std::int64_t& left) {
  std::array<char, 16384> buffer{};
  const ssize_t got = read(from, buffer.data(), buffer.size());
  if (got <= 0) return false;
  const std::int64_t forwarded = left < 0 ? got : std::min<std::int64_t>(got, left);
  for (std::int64_t sent = 0; sent < forwarded;) {
    const ssize_t wrote = send(to, buffer.data() + sent, static_cast<std::size_t>(forwarded - sent), MSG_NOSIGNAL);
    if (wrote <= 0) return false;
    sent += wrote;
  }
  if (left < 0) return true;
  left -= forwarded;
  if (left > 0) return true;
  MutexLock lock(mutex_);
  ++cuts_made_;
  return false;
}

}  // namespace enfilade::testing
