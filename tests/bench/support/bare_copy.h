// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/sensor/record.h"

struct pg_conn;

namespace enfilade::bench {

// The yardstick of ingest: the rows that the server would store, into a table of the same shape, by nothing but libpq's
// COPY BINARY in one transaction.
class BareCopy {
 public:
  explicit BareCopy(const std::string& database_url);

  // Empties the table and fills it with `records` once per session (resource names); seconds from the COPY's first byte
  // to the answer of its commit. The rows' bytes are made before.
  double Run(const std::vector<std::string>& sessions, const std::vector<sensor::Record>& records);

 private:
  struct Disconnect {
    void operator()(pg_conn* connection) const;
  };

  void Execute(const char* sql);

  std::unique_ptr<pg_conn, Disconnect> connection_;
};

}  // namespace enfilade::bench
