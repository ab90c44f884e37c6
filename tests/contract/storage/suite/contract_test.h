// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/contract/storage/suite/contract_stores.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {

// What holds for the stores of every backend.
class StoreContractTest : public ::testing::Test, protected ContractStores {
 protected:
  StoreContractTest() : ContractStores(MakeBackend()) {}
};

}  // namespace enfilade::testing
