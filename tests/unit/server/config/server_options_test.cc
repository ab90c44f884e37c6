// SPDX-License-Identifier: Apache-2.0
#include "server/config/server_options.h"

#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ServerOptions, DefaultsAreValidAndEveryKeyTakesItsOwnValueBack) {
  ServerOptions options;
  EXPECT_OK(options.Validate());
  for (const Setting& setting : Describe(options)) EXPECT_OK(Apply(setting, options)) << setting.key;
  EXPECT_OK(options.Validate());
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

}  // namespace
}  // namespace enfilade::server
