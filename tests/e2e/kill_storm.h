// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/e2e/whole_system.h"

namespace enfilade::testing {

// What is killed (kill -9).
enum class Victim : std::uint8_t { kServer, kRobot, kDatabase, kDatabaseBackend };
constexpr std::array<const char*, 4> kVictimNames = {"server", "robot", "database", "database backend"};

// At least `kills`, server and robot twice as often as the database and its backends, in random order.
std::vector<Victim> VictimsInRandomOrder(int kills, std::mt19937_64& random);

struct StormCounts {
  std::array<int, kVictimNames.size()> kills{};  // by Victim
  int amid_mapping = 0;                          // of server or database with a checkpoint to continue from

  int total() const;
  StormCounts& operator+=(const StormCounts& other);
};

// A drive that is uploaded while everything that takes part in it is killed and restarted.
class KillStorm {
 public:
  // Starts the upload. `records`: how many the drive has.
  KillStorm(WholeSystem& system, Replay replay, std::int64_t records, std::mt19937_64& random);

  // Kills one after the other at random moments, until all are done or the robot has finished. Most kills wait until
  // records flow again after the previous one. What was killed restarts immediately or a moment later; the next kill
  // may come while it is still starting. Throws if something ended on its own or does not recover.
  StormCounts Run(const std::vector<Victim>& victims);
  // Uploads the rest without pauses and waits until it is mapped. Throws if that fails.
  void Finish();

 private:
  std::chrono::milliseconds RandomTime(int max_ms);
  bool Finished() const;
  void AwaitProgress();
  void ExpectAlive();
  void KillBackend();
  void KillAndRestart(Victim victim);

  WholeSystem& system_;
  Replay replay_;
  std::int64_t records_;
  std::mt19937_64& random_;
  std::unique_ptr<Process> robot_;
};

// One record as "KIND SHA-256 of its payload", by its place in the log.
std::vector<std::string> RecordsOfLog(const std::filesystem::path& log);

// Stored records compared with those sent.
struct StoredRecords {
  std::int64_t lost = 0;
  std::int64_t doubled = 0;  // stored twice, or never sent
  std::int64_t changed = 0;

  bool intact() const { return lost == 0 && doubled == 0 && changed == 0; }
};

StoredRecords CompareStored(const WholeSystem& system, const Replay& replay, const std::vector<std::string>& sent);

}  // namespace enfilade::testing
