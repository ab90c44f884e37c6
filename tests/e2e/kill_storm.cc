// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/kill_storm.h"

#include <signal.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "client/sources/log_reader.h"
#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"
#include "tests/support/eventually.h"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

// A robot that has failed many times in a row waits for half a minute before the next attempt.
constexpr auto kPatience = std::chrono::seconds(300 * kSlowdown);

std::string Hex(std::string_view bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const char c : bytes) {
    hex += kDigits[static_cast<std::uint8_t>(c) >> 4];
    hex += kDigits[static_cast<std::uint8_t>(c) & 15];
  }
  return hex;
}

}  // namespace

std::vector<Victim> VictimsInRandomOrder(int kills, std::mt19937_64& random) {
  std::vector<Victim> victims;
  while (static_cast<int>(victims.size()) < kills) {
    victims.insert(victims.end(), {Victim::kServer, Victim::kServer, Victim::kRobot, Victim::kRobot, Victim::kDatabase,
                                   Victim::kDatabaseBackend});
  }
  std::shuffle(victims.begin(), victims.end(), random);
  return victims;
}

int StormCounts::total() const { return std::accumulate(kills.begin(), kills.end(), 0); }

StormCounts& StormCounts::operator+=(const StormCounts& other) {
  for (std::size_t i = 0; i < kills.size(); ++i) kills[i] += other.kills[i];
  amid_mapping += other.amid_mapping;
  return *this;
}

KillStorm::KillStorm(WholeSystem& system, Replay replay, std::int64_t records, std::mt19937_64& random)
    : system_(system), replay_(std::move(replay)), records_(records), random_(random) {
  robot_ = system_.StartReplay(replay_, system_.server());
}

std::chrono::milliseconds KillStorm::RandomTime(int max_ms) {
  return std::chrono::milliseconds(std::uniform_int_distribution<int>(0, max_ms)(random_));
}

bool KillStorm::Finished() const { return robot_->Wait(std::chrono::milliseconds(0)) == 0; }

void KillStorm::AwaitProgress() {
  const std::int64_t before = system_.AcknowledgedSequence(replay_.site);
  if (!Eventually([&] { return system_.AcknowledgedSequence(replay_.site) > before || Finished(); }, kPatience)) {
    throw std::runtime_error("no records flow:\n" + TailOf(system_.ReplayLog(replay_)) +
                             TailOf(system_.server().log()));
  }
}

// Neither robot nor server ends on its own, whatever happens to the others.
void KillStorm::ExpectAlive() {
  if (!robot_->running()) throw std::runtime_error("the robot ended:\n" + TailOf(system_.ReplayLog(replay_)));
  if (!system_.server().process().running()) {
    throw std::runtime_error("the server ended:\n" + TailOf(system_.server().log()));
  }
}

void KillStorm::KillBackend() {
  const auto backends = system_.TryQuery(
      "SELECT pid FROM pg_stat_activity WHERE backend_type = 'client backend' AND application_name LIKE 'enfilade%'"
      " AND pid <> pg_backend_pid() ORDER BY pid");
  if (!backends || backends->empty()) {
    system_.KillDatabase();  // it is recovering: kill the whole database instead
    system_.RestartDatabase();
    return;
  }
  const std::size_t which = std::uniform_int_distribution<std::size_t>(0, backends->size() - 1)(random_);
  kill(std::stoi((*backends)[which]), SIGKILL);  // the postmaster ends all others and recovers
}

void KillStorm::KillAndRestart(Victim victim) {
  switch (victim) {
    case Victim::kServer:
      system_.server().Kill();
      std::this_thread::sleep_for(RandomTime(300));
      system_.server().Start();
      break;
    case Victim::kRobot:
      robot_->Kill();
      std::this_thread::sleep_for(RandomTime(300));
      robot_ = system_.StartReplay(replay_, system_.server());
      break;
    case Victim::kDatabase:
      system_.KillDatabase();
      std::this_thread::sleep_for(RandomTime(300));
      system_.RestartDatabase();
      break;
    case Victim::kDatabaseBackend:
      KillBackend();
      break;
  }
}

StormCounts KillStorm::Run(const std::vector<Victim>& victims) {
  StormCounts counts;
  for (const Victim victim : victims) {
    if (std::uniform_int_distribution<int>(0, 3)(random_) > 0) AwaitProgress();
    std::this_thread::sleep_for(RandomTime(700));
    const std::int64_t mapped = system_.MappedSequence(replay_.site);
    if (Finished()) break;
    ExpectAlive();
    KillAndRestart(victim);
    ++counts.kills[static_cast<std::size_t>(victim)];
    if (mapped > 0 && mapped < records_ && victim != Victim::kRobot) ++counts.amid_mapping;
  }
  return counts;
}

void KillStorm::Finish() {
  robot_->Kill();
  replay_.rate = "max";  // the rest needs no pace
  robot_ = system_.StartReplay(replay_, system_.server());
  if (robot_->Wait(2 * kPatience) != 0) {
    throw std::runtime_error("the rest is not mapped:\n" + TailOf(system_.ReplayLog(replay_)) +
                             TailOf(system_.server().log()));
  }
}

std::vector<std::string> RecordsOfLog(const std::filesystem::path& log) {
  auto reader = sources::LogReader::Open(log);
  if (!reader.ok()) throw std::runtime_error(std::string(reader.status().message()));
  std::vector<std::string> records;
  for (auto entry = reader->Next(); entry.ok() && entry->has_value(); entry = reader->Next()) {
    const sensor::Record record{static_cast<std::int64_t>(records.size()) + 1, (*entry)->payload};
    records.push_back(std::to_string(static_cast<int>(sensor::KindOf(record))) + " " +
                      Hex(Sha256(sensor::EncodePayload(record))));
  }
  return records;
}

StoredRecords CompareStored(const WholeSystem& system, const Replay& replay, const std::vector<std::string>& sent) {
  const std::string mine =
      " FROM session_records WHERE site_id = '" + replay.site + "' AND session_id = '" + replay.session + "'";
  const auto rows = system.TryQuery("SELECT sequence || ' ' || kind || ' ' || encode(sha256(payload), 'hex')" + mine);
  if (!rows) throw std::runtime_error("the stored records cannot be read");
  StoredRecords result;
  std::map<std::int64_t, std::string> stored;
  for (const std::string& row : *rows) {
    const std::size_t space = row.find(' ');
    const std::int64_t sequence = std::stoll(row.substr(0, space));
    const bool was_sent = sequence >= 1 && sequence <= static_cast<std::int64_t>(sent.size());
    if (!stored.emplace(sequence, row.substr(space + 1)).second || !was_sent) ++result.doubled;
  }
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const auto found = stored.find(static_cast<std::int64_t>(i) + 1);
    if (found == stored.end()) {
      ++result.lost;
    } else if (found->second != sent[i]) {
      ++result.changed;
    }
  }
  return result;
}

}  // namespace enfilade::testing
