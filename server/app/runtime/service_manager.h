// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::server {

// What the process tells systemd when it runs it as a service of Type=notify (sd_notify(3)); nothing otherwise.
void NotifyReady();
void NotifyReloading();
void NotifyStopping();

}  // namespace enfilade::server
