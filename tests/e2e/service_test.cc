// SPDX-License-Identifier: Apache-2.0
// The server as a service of systemd: what it tells by sd_notify(3), and what SIGHUP does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <string>

#include "tests/support/process.h"
#include "tests/support/server_process.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Where systemd would listen.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : path_(path), socket_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    const timeval patience{.tv_sec = 60, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) std::abort();
  }
  ~NotifySocket() { ::close(socket_); }

  const std::string& path() const { return path_; }
  // "" if none comes.
  std::string Next() const {
    std::array<char, 256> buffer{};
    const ssize_t size = ::recv(socket_, buffer.data(), buffer.size(), 0);
    return size < 0 ? "" : std::string(buffer.data(), static_cast<std::size_t>(size));
  }

 private:
  std::string path_;
  int socket_;
};

// No database answers: the service is up, and its health says that it is not ready.
class ServiceTest : public ::testing::Test {
 protected:
  ServiceTest() { Configure("info", 8); }

  void Configure(const std::string& level, int workers) const {
    std::ofstream(config_)
        << "listen:\n  address: unix:" << folder_.path().string() << "/s.sock\n  workers: " << workers
        << "\nmetrics:\n  address: ''\ndatabase:\n  url: postgresql:///none?host=/nowhere\nlog:\n  level: " << level
        << "\n";
  }

  const TemporaryDirectory folder_;
  const std::string config_ = folder_.path() / "server.yaml";
  const std::string log_ = folder_.path() / "log";
  const NotifySocket manager_{folder_.path() / "notify"};
  Process server_{{Program("enfilade-server"), "--config", config_}, log_, {"NOTIFY_SOCKET=" + manager_.path()}};
};

TEST_F(ServiceTest, TellsWhenItListensAndWhenItStops) {
  EXPECT_EQ(manager_.Next(), "READY=1");
  EXPECT_NE(HealthOf(client::Connection("unix:" + (folder_.path() / "s.sock").string(), std::chrono::seconds(30))),
            Health::kUnreachable);
  server_.Signal(SIGTERM);
  EXPECT_EQ(manager_.Next(), "STOPPING=1");
  EXPECT_EQ(server_.Wait(std::chrono::seconds(60)), 0);
}

TEST_F(ServiceTest, ReloadsWhatCanChangeAndNamesTheRest) {
  ASSERT_EQ(manager_.Next(), "READY=1");
  Configure("warn", 9);
  server_.Signal(SIGHUP);
  EXPECT_EQ(manager_.Next(), "RELOADING=1");
  EXPECT_EQ(manager_.Next(), "READY=1");
  EXPECT_THAT(TailOf(log_), HasSubstr("listen.workers has changed: restart the server to use it"));
  EXPECT_THAT(TailOf(log_), Not(HasSubstr("log.level has changed")));
  EXPECT_THAT(TailOf(log_), Not(HasSubstr("the configuration is reloaded")));  // told at "info", which is off by now
}

TEST_F(ServiceTest, KeepsWhatItHasIfTheFileIsWrong) {
  ASSERT_EQ(manager_.Next(), "READY=1");
  std::ofstream(config_) << "listen: [";
  server_.Signal(SIGHUP);
  EXPECT_EQ(manager_.Next(), "RELOADING=1");
  EXPECT_EQ(manager_.Next(), "READY=1");
  EXPECT_THAT(TailOf(log_), HasSubstr("the configuration is not reloaded: "));
  EXPECT_TRUE(server_.running());
}

}  // namespace
}  // namespace enfilade::testing
