// SPDX-License-Identifier: Apache-2.0
import { fromJsonString } from '@bufbuild/protobuf';
import { maps } from '../../api/clients';
import { siteName } from '../../api/names';
import { upload, type Progress } from '../../api/upload';
import { ImportMapResponseSchema } from '../../gen/enfilade/v1/map_service_pb';

// What becomes a map: the files, and the map that they are of.
export interface Import {
  // The name of one that exists; absent: a new one of this title and level.
  map?: string;
  title: string;
  level: number;
  files: File[];
  dialect: string;
}

export interface Imported {
  map: string;
  // What of the files was ignored or changed on the way.
  warnings: string[];
}

// The server wants one .json, or one .yaml and the image that it names.
export function lacking(files: { name: string }[]): string | undefined {
  const has = (pattern: RegExp) => files.some(({ name }) => pattern.test(name));
  if (files.length === 0) return 'Choose the files of the map.';
  if (has(/\.json$/i)) return files.length === 1 ? undefined : 'A JSON file holds the whole map: choose it alone.';
  if (!has(/\.ya?ml$/i)) return 'The YAML file is missing, which tells the resolution and the origin.';
  return has(/\.(pgm|png)$/i) ? undefined : 'The image is missing: the .pgm or .png that the YAML file names.';
}

// A new map is made first, and removed if nothing comes of it, so that no empty one stays behind.
export async function importMap(site: string, { map, title, level, files, dialect }: Import, onProgress: (progress: Progress) => void, signal: AbortSignal): Promise<Imported> {
  const name = map ?? (await maps.createMap({ parent: siteName(site), map: { displayName: title, level } }, { signal })).map!.name;
  try {
    const form = new FormData();
    form.append('dialect', dialect);
    for (const file of files) form.append('file', file, file.name);
    const { warnings } = fromJsonString(ImportMapResponseSchema, await upload(`/v1/${name}:import`, form, onProgress, signal), { ignoreUnknownFields: true });
    return { map: name, warnings };
  } catch (error) {
    if (map === undefined) await maps.deleteMap({ name }).catch(() => undefined); // the first error is the one to tell
    throw error;
  }
}
