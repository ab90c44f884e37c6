// SPDX-License-Identifier: Apache-2.0
#include "client/cli/interrupt.h"

#include <csignal>

namespace enfilade::cli {
namespace {

volatile std::sig_atomic_t signalled = 0;

void Remember(int) { signalled = 1; }

void Handle(void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  signalled = 0;
  Handle(Remember, static_cast<int>(SA_RESETHAND));
}

InterruptGuard::~InterruptGuard() { Handle(SIG_DFL, 0); }

bool InterruptGuard::interrupted() const { return signalled != 0; }

}  // namespace enfilade::cli
