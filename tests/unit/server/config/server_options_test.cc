// SPDX-License-Identifier: Apache-2.0
#include "server/config/server_options.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ServerOptions, DefaultsAreValidAndEveryKeyTakesItsOwnValueBack) {
  ServerOptions options;
  EXPECT_OK(options.Validate());
  for (const Setting& setting : Describe(options)) EXPECT_OK(Apply(setting, options)) << setting.key;
  EXPECT_OK(options.Validate());
}

TEST(ServerOptions, TheWaitForAVersionIsBounded) {
  for (const char* value : {"-0.1", "60.1", "nan"}) {
    ServerOptions options;
    ASSERT_OK(Apply({"graph.version_wait_s", value}, options));
    EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("graph.version_wait_s"));
  }
}

TEST(ServerOptions, WatchersAreLimitedWithinReason) {
  for (const char* key : {"watches.max_per_site", "watches.max_in_all"}) {
    for (const char* value : {"0", "-1", "100001"}) {
      ServerOptions options;
      ASSERT_OK(Apply({key, value}, options));
      EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr(key));
    }
  }
}

TEST(ServerOptions, YamlIsNestedAndLeavesTheRest) {
  ServerOptions options;
  ASSERT_OK(ApplyYaml("listen:\n  address: unix:/run/s\nmapping:\n  workers: 3\n", "server.yaml", options));
  EXPECT_EQ(options.listen.address, "unix:/run/s");
  EXPECT_EQ(options.mapping.workers, 3);
  EXPECT_EQ(options.ingest.writers, ServerOptions().ingest.writers);
  EXPECT_OK(ApplyYaml("", "empty.yaml", options));
}

TEST(ServerOptions, UnknownKeysAndWrongTypesAreRefusedWithFileLineAndAProposal) {
  ServerOptions options;
  EXPECT_STATUS(ApplyYaml("listen:\n  adress: x\n", "server.yaml", options), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("server.yaml, line 2"), HasSubstr("listen.adress"), HasSubstr("listen.address")));
  EXPECT_STATUS(ApplyYaml("mapping:\n  workers: many\n", "server.yaml", options), absl::StatusCode::kInvalidArgument,
                HasSubstr("mapping.workers"));
  EXPECT_STATUS(ApplyYaml("mapping: [1, 2]\n", "server.yaml", options), absl::StatusCode::kInvalidArgument,
                HasSubstr("mapping"));
  EXPECT_STATUS(ApplyYaml("a: b: c", "server.yaml", options), absl::StatusCode::kInvalidArgument,
                HasSubstr("server.yaml, line 1"));
  EXPECT_CODE(Apply({"mapping.workers", "1x"}, options), absl::StatusCode::kInvalidArgument);
}

TEST(ServerOptions, EnvironmentNamesKeysAndRefusesOthersOfItsPrefix) {
  ServerOptions options;
  ASSERT_OK(ApplyEnvironment(
      {"PATH=/bin", "ENFILADE_SITE=x", "ENFILADE_SERVER=host:1", "ENFILADE_SERVER_DATABASE_URL=postgresql:///a=b"},
      options));
  EXPECT_EQ(options.database.url, "postgresql:///a=b");
  EXPECT_STATUS(ApplyEnvironment({"ENFILADE_SERVER_DATABASE_URI=x"}, options), absl::StatusCode::kInvalidArgument,
                HasSubstr("ENFILADE_SERVER_DATABASE_URI"));
}

TEST(ServerOptions, ValidationNamesTheKey) {
  const auto refused = [](auto change, const char* key) {
    ServerOptions options;
    change(options);
    EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr(key));
  };
  refused([](ServerOptions& o) { o.listen.workers = 0; }, "listen.workers");
  refused([](ServerOptions& o) { o.listen.max_message_bytes = 3LL << 30; }, "listen.max_message_bytes");
  refused([](ServerOptions& o) { o.database.max_connections = 2; }, "database.max_connections");
  refused([](ServerOptions& o) { o.ingest.stream_buffer_bytes = 0; }, "ingest.stream_buffer_bytes");
  refused([](ServerOptions& o) { o.mapping.lease_s = 0.5; }, "mapping.lease_s");
  refused([](ServerOptions& o) { o.log.level = "loud"; }, "log.level");
  refused([](ServerOptions& o) { o.log.format = "xml"; }, "log.format");
}

// The environment's name of a key must lead back to that key alone.
TEST(ServerOptions, EveryKeyCanBeSetByTheEnvironmentAndByYaml) {
  for (const Setting& setting : Describe(ServerOptions())) {
    std::string name = "ENFILADE_SERVER_";
    for (const char c : setting.key) name += c == '.' ? '_' : static_cast<char>(std::toupper(c));
    ServerOptions by_environment;
    EXPECT_OK(ApplyEnvironment({name + "=" + setting.value}, by_environment)) << name;
    const std::size_t dot = setting.key.find('.');
    const std::string yaml =
        setting.key.substr(0, dot) + ": {" + setting.key.substr(dot + 1) + ": \"" + setting.value + "\"}";
    ServerOptions by_yaml;
    EXPECT_OK(ApplyYaml(yaml, "server.yaml", by_yaml)) << yaml;
  }
}

TEST(ServerOptions, LaterSourcesWin) {
  ServerOptions options;
  ASSERT_OK(ApplyYaml("listen: {workers: 2}\nlog: {level: warn}\n", "server.yaml", options));
  ASSERT_OK(ApplyEnvironment({"ENFILADE_SERVER_LISTEN_WORKERS=3"}, options));
  EXPECT_EQ(options.listen.workers, 3);
  ASSERT_OK(Apply({"listen.workers", "4"}, options));
  EXPECT_EQ(options.listen.workers, 4);
  EXPECT_EQ(options.log.level, "warn") << "what later sources do not name stays";
}

TEST(ServerOptions, ProposesTheNearestKey) {
  ServerOptions options;
  for (const auto& [wrong, right] :
       {std::pair{"listen.adress", "listen.address"}, std::pair{"database.uri", "database.url"},
        std::pair{"mapping.worker", "mapping.workers"}, std::pair{"log.levels", "log.level"}}) {
    EXPECT_STATUS(Apply({wrong, "1"}, options), absl::StatusCode::kInvalidArgument,
                  AllOf(HasSubstr(wrong), HasSubstr("did you mean " + std::string(right))));
  }
}

TEST(ServerOptions, RefusesNumbersThatAreNot) {
  ServerOptions options;
  for (const char* value : {"", " 1", "1 ", "1.5", "0x10", "one", "99999999999999999999", "+1"}) {
    EXPECT_STATUS(Apply({"listen.workers", value}, options), absl::StatusCode::kInvalidArgument,
                  HasSubstr("listen.workers"))
        << value;
  }
  EXPECT_EQ(options.listen.workers, ServerOptions().listen.workers);
  EXPECT_OK(Apply({"listen.grace_s", "1.5"}, options));
  EXPECT_EQ(options.listen.grace_s, 1.5);
}

TEST(ServerOptions, BoundsEveryNumberAndItsEffectOnConnections) {
  struct Case {
    const char* key;
    void (*change)(ServerOptions&);
  };
  for (const Case& test :
       {Case{"listen.grace_s", [](ServerOptions& o) { o.listen.grace_s = -0.1; }},
        Case{"listen.grace_s", [](ServerOptions& o) { o.listen.grace_s = std::nan(""); }},
        Case{"listen.max_message_bytes", [](ServerOptions& o) { o.listen.max_message_bytes = 1; }},
        Case{"database.default_deadline_s", [](ServerOptions& o) { o.database.default_deadline_s = 0.0; }},
        Case{"database.default_deadline_s",
             [](ServerOptions& o) { o.database.default_deadline_s = std::numeric_limits<double>::infinity(); }},
        Case{"ingest.writers", [](ServerOptions& o) { o.ingest.writers = 0; }},
        Case{"ingest.total_buffer_bytes", [](ServerOptions& o) { o.ingest.total_buffer_bytes = 1; }},
        Case{"ingest.transaction_bytes", [](ServerOptions& o) { o.ingest.transaction_bytes = -1; }},
        Case{"mapping.workers", [](ServerOptions& o) { o.mapping.workers = -1; }},
        Case{"mapping.checkpoint_interval_s", [](ServerOptions& o) { o.mapping.checkpoint_interval_s = -1.0; }},
        Case{"mapping.revision_interval_s", [](ServerOptions& o) { o.mapping.revision_interval_s = -1.0; }},
        Case{"mapping.pairing_window_s", [](ServerOptions& o) { o.mapping.pairing_window_s = -1.0; }},
        Case{"mapping.parked_bytes", [](ServerOptions& o) { o.mapping.parked_bytes = 0; }},
        Case{"transfers.cache_bytes", [](ServerOptions& o) { o.transfers.cache_bytes = 0; }},
        Case{"transfers.max_import_bytes", [](ServerOptions& o) { o.transfers.max_import_bytes = 0; }},
        Case{"survey.share", [](ServerOptions& o) { o.survey.share = 1.5; }},
        Case{"prior_maps.realign_s", [](ServerOptions& o) { o.prior_maps.realign_s = 0.5; }},
        Case{"retention.interval_s", [](ServerOptions& o) { o.retention.interval_s = 0.0; }},
        Case{"retention.undo_s", [](ServerOptions& o) { o.retention.undo_s = -1.0; }},
        Case{"retention.undo_s", [](ServerOptions& o) { o.retention.undo_s = 1e18; }},
        Case{"retention.idle_session_s", [](ServerOptions& o) { o.retention.idle_session_s = 59.0; }},
        Case{"retention.idle_session_s", [](ServerOptions& o) { o.retention.idle_session_s = 1e18; }},
        Case{"retention.deleted_session_s", [](ServerOptions& o) { o.retention.deleted_session_s = 59.0; }},
        Case{"retention.unused_blob_s", [](ServerOptions& o) { o.retention.unused_blob_s = 59.0; }},
        // Ten mappers need twenty connections.
        Case{"database.max_connections", [](ServerOptions& o) { o.mapping.workers = 10; }}}) {
    ServerOptions options;
    test.change(options);
    EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr(test.key)) << test.key;
  }
  ServerOptions other_replica_maps;
  other_replica_maps.mapping.workers = 0;
  EXPECT_OK(other_replica_maps.Validate());
}

TEST(ServerOptions, OtherMachinesAreServedByTlsOnlyUnlessToldOtherwise) {
  for (const char* address :
       {"127.0.0.1:50051", "127.8.9.1:1", "localhost:0", "[::1]:50051", "unix:/run/enfilade/socket"}) {
    ServerOptions options;
    options.listen.address = address;
    EXPECT_OK(options.Validate()) << address;
    EXPECT_TRUE(options.Warnings().empty()) << address;
  }
  for (const char* address : {"0.0.0.0:50051", "[::]:50051", "192.168.1.7:50051", "robots.example:50051"}) {
    ServerOptions options;
    options.listen.address = address;
    EXPECT_THAT(std::string(options.Validate().message()),
                AllOf(HasSubstr(address), HasSubstr("listen.tls_certificate")));
    options.listen.insecure = true;
    EXPECT_OK(options.Validate());
    EXPECT_THAT(options.Warnings(), ElementsAre(AllOf(HasSubstr(address), HasSubstr("without TLS"))));
    options.listen.insecure = false;
    options.listen.tls_certificate = "server.pem";
    EXPECT_THAT(std::string(options.Validate().message()), HasSubstr("only the certificate is set"));
    options.listen.tls_key = "server.key";
    EXPECT_OK(options.Validate());
    EXPECT_TRUE(options.Warnings().empty());
  }
  ServerOptions options;
  options.metrics.address = "0.0.0.0:9464";
  EXPECT_THAT(std::string(options.Validate().message()), HasSubstr("metrics.address"));
  options.metrics.address = "";
  EXPECT_OK(options.Validate());
}

}  // namespace
}  // namespace enfilade::server
