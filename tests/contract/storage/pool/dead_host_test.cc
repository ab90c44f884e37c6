// SPDX-License-Identifier: Apache-2.0
// A database URL with several hosts, of which one is dead.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>

#include "fmt/format.h"
#include "storage/postgres/driver/host_list.h"
#include "storage/postgres/driver/pool.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::storage::postgres {
namespace {

using ::testing::ElementsAre;

TEST(HostsOf, AreThoseOfTheUrlInTheirOrder) {
  EXPECT_THAT(HostsOf("postgresql://u@a:1,b:2/db"), ElementsAre(Host{"a", "", "1"}, Host{"b", "", "2"}));
  EXPECT_THAT(HostsOf("host=a,b,/run/db port=7"),
              ElementsAre(Host{"a", "", "7"}, Host{"b", "", "7"}, Host{"/run/db", "", "7"}));
  EXPECT_THAT(HostsOf("host=a,b hostaddr=1.2.3.4,5.6.7.8"),
              ElementsAre(Host{"a", "1.2.3.4", ""}, Host{"b", "5.6.7.8", ""}));
  // One, or what libpq has to decide or to refuse.
  for (const char* url : {"", "postgresql:///db?host=/run/db", "host=a", "host=a,b port=1,2,3",
                          "host=a,b hostaddr=1.2.3.4", "host=a,b target_session_attrs=prefer-standby", "no=url"}) {
    EXPECT_THAT(HostsOf(url), ElementsAre(Host{})) << url;
  }
}

// A network in which packets to 10.77.0.9 vanish: that of a TUN device that nobody reads. Only for the calling thread.
// Returns why it cannot be made; empty: it has been.
std::string EnterNetworkThatSwallows(int& tun) {
  if (unshare(CLONE_NEWNET) != 0) return "network namespaces cannot be made here";
  tun = open("/dev/net/tun", O_RDWR | O_CLOEXEC);
  if (tun < 0) return "there is no /dev/net/tun";
  ifreq request = {};
  std::strncpy(request.ifr_name, "swallow", IFNAMSIZ - 1);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  if (ioctl(tun, TUNSETIFF, &request) != 0) return "a TUN device cannot be made here";
  const int control = socket(AF_INET, SOCK_DGRAM, 0);
  auto* address = reinterpret_cast<sockaddr_in*>(&request.ifr_addr);
  *address = {};
  address->sin_family = AF_INET;
  inet_pton(AF_INET, "10.77.0.1", &address->sin_addr);
  bool made = ioctl(control, SIOCSIFADDR, &request) == 0;
  inet_pton(AF_INET, "255.255.255.0", &address->sin_addr);
  made = made && ioctl(control, SIOCSIFNETMASK, &request) == 0;
  made = made && ioctl(control, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  made = made && ioctl(control, SIOCSIFFLAGS, &request) == 0;
  close(control);
  return made ? "" : "a TUN device cannot be set up here";
}

// Runs `test` in a thread of such a network; skips it where there can be none.
void RunWhereAHostIsDead(const std::function<void()>& test) {
  std::string hindrance;
  std::thread thread([&] {
    int tun = -1;
    hindrance = EnterNetworkThatSwallows(tun);
    if (hindrance.empty()) test();
    if (tun >= 0) close(tun);
  });
  thread.join();
  if (!hindrance.empty()) GTEST_SKIP() << hindrance;
}

class DeadHostTest : public enfilade::testing::DatabaseTest {};

// The first host has half of the time to connect, and the next one the rest.
TEST_F(DeadHostTest, AFirstHostThatSwallowsPacketsIsLeft) {
  if (std::getenv("ENFILADE_TEST_DATABASE")) GTEST_SKIP() << "the server is not this test's own";
  const std::string url = database_.url();
  RunWhereAHostIsDead([&] {
    // host= of the URL is the folder of the live server's socket.
    const auto at = url.find("host=");
    ASSERT_NE(at, std::string::npos) << url;
    std::string with_dead = url;
    with_dead.insert(at + 5, "10.77.0.9,");
    auto pool = Pool::Create({.url = with_dead, .connect_timeout = std::chrono::seconds(4)});
    ASSERT_OK(pool);
    EXPECT_OK((*pool)->Acquire(CallContext::WithTimeout(std::chrono::seconds(60))).status());
    EXPECT_EQ((*pool)->stats().failures, 0) << "one attempt has found the live one";
  });
}

}  // namespace
}  // namespace enfilade::storage::postgres
