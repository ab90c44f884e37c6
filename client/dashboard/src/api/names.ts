// SPDX-License-Identifier: Apache-2.0
// Resource names: sites/demo/maps/hall. All tables are keyed by the whole name.

export const siteName = (id: string) => `sites/${id}`;

// The last segment: hall.
export const idOf = (name: string) => name.slice(name.lastIndexOf('/') + 1);

// Without the site: maps/hall. Used in addresses of pages.
export const withoutSite = (name: string) => name.replace(/^sites\/[^/]+\//, '');

export const withSite = (site: string, rest: string) => `sites/${site}/${rest}`;

// The collection that a name ends in: maps, robots, linkPoints, ...
export function collectionOf(name: string): string {
  const parts = name.split('/');
  return parts[parts.length - 2] ?? '';
}

// "sites/s/maps/m" of "sites/s/maps/m/drafts/d".
export const mapOfDraft = (draft: string) => draft.replace(/\/drafts\/[^/]*$/, '');
