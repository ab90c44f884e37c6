// SPDX-License-Identifier: Apache-2.0
import { sites } from './clients';
import { siteName } from './names';

// Who changed a resource last, and when.
export async function lastChangeOf(site: string, name: string) {
  return (await sites.listAuditEntries({ parent: siteName(site), resource: name, pageSize: 1 })).entries[0];
}
