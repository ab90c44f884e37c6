// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/logging.h"

#include <gmock/gmock.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::MatchesRegex;

class Logging : public ::testing::Test {
 protected:
  ~Logging() override { spdlog::set_default_logger(previous_); }

  // What `log` writes to standard error with these options, by lines.
  template <typename Log>
  static std::vector<std::string> Lines(const ServerOptions::Log& options, const Log& log) {
    ::testing::internal::CaptureStderr();
    SetUpLogging(options);
    log();
    spdlog::default_logger()->flush();
    std::istringstream text(::testing::internal::GetCapturedStderr());
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

 private:
  const std::shared_ptr<spdlog::logger> previous_ = spdlog::default_logger();
};

TEST_F(Logging, TextLinesHaveTimeLevelAndMessage) {
  const auto lines = Lines({.level = "info", .format = "text"}, [] { spdlog::warn("map {} is lost", "hall"); });
  EXPECT_THAT(lines, ElementsAre(MatchesRegex("20[0-9-]+T[0-9:.]+Z warning map hall is lost")));
}

// What callers send is part of messages.
TEST_F(Logging, AMessageIsOneTextLineWhateverItHolds) {
  const auto lines = Lines({.level = "info", .format = "text"},
                           [] { spdlog::info("{}", std::string("a\nb\r\tc\0d\x1b[31m\x7f caf\xC3\xA9 \\", 22)); });
  EXPECT_THAT(lines, ElementsAre(::testing::EndsWith(R"(info a\nb\r\tc\x00d\x1b[31m\x7f caf)"
                                                     "\xC3\xA9 \\")));
}

TEST_F(Logging, EachJsonLineIsAnObjectWhateverTheMessageHolds) {
  const std::string messages[] = {"plain", "a \"quote\" and a \\", "two\nlines\tand a tab", "not UTF-8: \xff"};
  const auto lines = Lines({.level = "info", .format = "json"}, [&] {
    for (const std::string& message : messages) spdlog::error("{}", message);
  });
  ASSERT_EQ(lines.size(), std::size(messages));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const nlohmann::json object = nlohmann::json::parse(lines[i]);
    EXPECT_EQ(object.at("level"), "error");
    EXPECT_TRUE(object.at("thread").is_number());
    EXPECT_THAT(object.at("time").get<std::string>(), MatchesRegex("20[0-9-]+T[0-9:.]+Z"));
    if (i < 3) {
      EXPECT_EQ(object.at("message"), messages[i]);
    }
  }
}

TEST_F(Logging, TheLevelHoldsBackLesserMessages) {
  const auto lines = Lines({.level = "error", .format = "text"}, [] {
    spdlog::warn("held back");
    spdlog::error("written");
  });
  EXPECT_THAT(lines, ElementsAre(MatchesRegex(".* error written")));
}

}  // namespace
}  // namespace enfilade::server
