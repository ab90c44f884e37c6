// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "fmt/format.h"
#include "tests/rpc/server_test.h"
#include "tests/support/authority.h"
#include "tests/support/eventually.h"
#include "tests/support/scrape.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::chrono::duration<double> kCallTime = std::chrono::seconds(60);

// A second server beside the one of ServerTest, at a TCP port by TLS, over the same database.
class TlsTest : public ServerTest {
 protected:
  void Serve(const io::TlsParts& files, const std::string& revoked = "") {
    server::ServerOptions options = Options();
    options.database.url = database_.url();
    options.listen.address = "127.0.0.1:0";
    options.listen.tls_certificate = files.certificate;
    options.listen.tls_key = files.key;
    options.listen.tls_client_authorities = files.authorities;
    options.listen.tls_revoked_directory = revoked;
    options.transfers.cache_directory = (directory_.path() / "cache").string();
    options.metrics.address = fmt::format("127.0.0.1:{}", metrics_port_);
    secure_.reset();
    auto server = server::Server::Start(options, slam::SlamOptions());
    ASSERT_OK(server);
    secure_ = *std::move(server);
  }

  // The value of a counter in the metrics; -1: there is none.
  double Counter(const std::string& name) const {
    const std::string page = Scrape(metrics_port_);
    const auto found = page.find("\n" + name + " ");
    return found == std::string::npos ? -1.0 : std::stod(page.substr(found + name.size() + 2));
  }

  io::TlsParts Write(const std::string& name, const io::TlsParts& content) const {
    return WriteTls(directory_.path(), name, content);
  }

  // A client with a connection of its own.
  client::Connection Client(const io::TlsParts& content, const std::string& actor = "") {
    const io::TlsParts files = Write("client-" + std::to_string(++clients_), content);
    auto credentials = client::Credentials::Tls(files);
    EXPECT_OK(credentials);
    return {secure_->address(), kCallTime, actor, *credentials};
  }
  static absl::Status Ask(const client::Connection& connection) {
    return connection.Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest()).status();
  }
  // Whether a new connection of such a client is accepted.
  bool IsAccepted(const io::TlsParts& content) { return Ask(Client(content)).ok(); }

  const int metrics_port_ = FreePort();
  Authority authority_{"authority"};
  Authority other_{"other authority"};
  std::unique_ptr<server::Server> secure_;
  int clients_ = 0;
};

io::TlsParts Trusting(const Authority& authority, io::TlsParts own = {}) {
  own.authorities = authority.pem();
  return own;
}

TEST_F(TlsTest, ServesThoseWhoTrustItsAuthorityAndSpeakTls) {
  ASSERT_NO_FATAL_FAILURE(Serve(Write("server", authority_.Issue("server"))));
  EXPECT_OK(Ask(Client(Trusting(authority_))));
  EXPECT_EQ(Ask(Client(Trusting(other_))).code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(Ask(client::Connection(secure_->address(), kCallTime)).code(), absl::StatusCode::kUnavailable);
}

TEST_F(TlsTest, WhoIsAskedForACertificateIsKnownByItsName) {
  io::TlsParts files = authority_.Issue("server");
  files.authorities = authority_.pem();
  ASSERT_NO_FATAL_FAILURE(Serve(Write("server", files)));
  EXPECT_FALSE(IsAccepted(Trusting(authority_))) << "without a certificate";
  EXPECT_FALSE(IsAccepted(Trusting(authority_, other_.Issue("robot-7")))) << "of another authority";
  const client::Connection robot = Client(Trusting(authority_, authority_.Issue("robot-7")), "root");
  v1::CreateMapRequest map;
  map.set_parent("sites/s");
  map.set_map_id("made-by-robot");
  map.mutable_map()->set_display_name("Made by a robot");
  ASSERT_OK(robot.Call(&v1::MapService::Stub::CreateMap, map));
  v1::ListAuditEntriesRequest audit;
  audit.set_parent("sites/s");
  audit.set_resource("sites/s/maps/made-by-robot");
  const auto trail = robot.Call(&v1::SiteService::Stub::ListAuditEntries, audit);
  ASSERT_OK(trail);
  ASSERT_GE(trail->entries_size(), 1);
  EXPECT_EQ(trail->entries(0).actor(), "robot-7 (says: root)");
}

TEST_F(TlsTest, CertificatesThatHaveEndedOrAreRevokedAreRefused) {
  const io::TlsParts good = authority_.Issue("robot-1");
  const io::TlsParts revoked = authority_.Issue("robot-2");
  authority_.RevokeLast();
  const std::filesystem::path lists = directory_.path() / "revoked";
  std::filesystem::create_directory(lists);
  authority_.WriteRevoked(lists);
  io::TlsParts files = authority_.Issue("server");
  files.authorities = authority_.pem();
  ASSERT_NO_FATAL_FAILURE(Serve(Write("server", files), lists));
  EXPECT_TRUE(IsAccepted(Trusting(authority_, good)));
  EXPECT_FALSE(IsAccepted(Trusting(authority_, revoked)));
  // Our own client does not begin with a certificate that has ended.
  const io::TlsParts ended = authority_.Issue("robot-3", std::chrono::seconds(-60));
  EXPECT_EQ(client::Credentials::Tls(Write("ended", Trusting(authority_, ended))).status().code(),
            absl::StatusCode::kInvalidArgument);
  grpc::SslCredentialsOptions plain{authority_.pem(), ended.key, ended.certificate};
  const auto channel = grpc::CreateChannel(secure_->address(), grpc::SslCredentials(plain));
  grpc::ClientContext context;
  v1::GetServerStatusResponse response;
  EXPECT_EQ(v1::ServerService::NewStub(channel)->GetServerStatus(&context, {}, &response).error_code(),
            grpc::StatusCode::UNAVAILABLE);
}

TEST_F(TlsTest, RevocationCountsWhileTheServerRuns) {
  const io::TlsParts robot = authority_.Issue("robot-1");
  const std::filesystem::path lists = directory_.path() / "revoked";
  std::filesystem::create_directory(lists);
  authority_.WriteRevoked(lists);  // none
  io::TlsParts files = authority_.Issue("server");
  files.authorities = authority_.pem();
  ASSERT_NO_FATAL_FAILURE(Serve(Write("server", files), lists));
  ASSERT_TRUE(IsAccepted(Trusting(authority_, robot)));
  const io::TlsParts lost = authority_.Issue("robot-2");
  ASSERT_TRUE(IsAccepted(Trusting(authority_, lost)));
  authority_.RevokeLast();
  authority_.WriteRevoked(lists);
  EXPECT_TRUE(Eventually([&] { return !IsAccepted(Trusting(authority_, lost)); }));
  EXPECT_TRUE(IsAccepted(Trusting(authority_, robot)));
}

TEST_F(TlsTest, NewFilesAreServedWhileStreamsGoOn) {
  const io::TlsParts paths = Write("server", authority_.Issue("server"));
  ASSERT_NO_FATAL_FAILURE(Serve(paths));
  constexpr int kStreams = 100;
  std::vector<client::Connection> robots;
  std::vector<std::unique_ptr<TestStream>> streams;
  for (int i = 0; i < kStreams; ++i) {
    robots.push_back(Client(Trusting(authority_)));
    streams.push_back(std::make_unique<TestStream>(robots.back(), CreateSession(false)));
    ASSERT_TRUE(streams.back()->SendBatch(ScanRecords(1, 1)));
    ASSERT_TRUE(streams.back()->AwaitAcknowledged(1));
  }
  const auto begin = std::chrono::steady_clock::now();
  Write("server", other_.Issue("server"));
  EXPECT_TRUE(Eventually([&] { return IsAccepted(Trusting(other_)); }));
  std::printf("the new certificate was served after %.2f s\n",
              std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  EXPECT_TRUE(Eventually([&] { return !IsAccepted(Trusting(authority_)); }));
  for (auto& stream : streams) {
    ASSERT_TRUE(stream->SendBatch(ScanRecords(2, 1)));
    ASSERT_TRUE(stream->AwaitAcknowledged(2));
    EXPECT_OK(stream->Finish());
  }
}

TEST_F(TlsTest, FilesThatAreWrongChangeNothing) {
  const io::TlsParts good = authority_.Issue("server");
  const io::TlsParts paths = Write("server", good);
  ASSERT_NO_FATAL_FAILURE(Serve(paths));
  const auto failures = [&] { return Counter("enfilade_tls_reload_failures_total"); };
  EXPECT_EQ(failures(), 0.0);
  std::ofstream(paths.key) << "no key";
  EXPECT_TRUE(Eventually([&] { return failures() >= 1.0; }));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(IsAccepted(Trusting(authority_)));
  const double before = failures();
  io::TlsParts wrong;
  wrong.key = other_.Issue("server").key;  // of another certificate
  Write("server", wrong);
  EXPECT_TRUE(Eventually([&] { return failures() > before; }));
  EXPECT_TRUE(IsAccepted(Trusting(authority_)));
  // When they are whole again, they are used.
  Write("server", other_.Issue("server"));
  EXPECT_TRUE(Eventually([&] { return IsAccepted(Trusting(other_)); }));
}

TEST_F(TlsTest, ItDoesNotBeginWithFilesThatAreWrong) {
  server::ServerOptions options = Options();
  options.database.url = database_.url();
  options.listen.address = "127.0.0.1:0";
  const io::TlsParts paths = Write("server", authority_.Issue("server"));
  options.listen.tls_certificate = paths.certificate;
  options.listen.tls_key = Write("other", other_.Issue("server")).key;
  const auto server = server::Server::Start(options, slam::SlamOptions());
  EXPECT_EQ(server.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("is not that of the certificate in"));
}

TEST_F(TlsTest, ServingOthersWithoutTlsIsSaidInTheStatus) {
  server::ServerOptions options = Options();
  options.database.url = database_.url();
  options.listen.address = "0.0.0.0:0";
  options.transfers.cache_directory = (directory_.path() / "cache").string();
  EXPECT_THAT(std::string(server::Server::Start(options, slam::SlamOptions()).status().message()),
              HasSubstr("listen.insecure=true"));
  options.listen.insecure = true;
  auto server = server::Server::Start(options, slam::SlamOptions());
  ASSERT_OK(server);
  const std::string port = (*server)->address().substr((*server)->address().rfind(':'));
  const client::Connection connection("127.0.0.1" + port, kCallTime);
  const auto status = connection.Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest());
  ASSERT_OK(status);
  EXPECT_THAT(status->warnings(), Contains(HasSubstr("without TLS")));
}

}  // namespace
}  // namespace enfilade::testing
