// SPDX-License-Identifier: Apache-2.0
import { errorOfResponse } from '../api/errors';
import { bytes } from './format';
import { Icon } from './Icon';

export interface FileLink {
  name: string;
  // A 64-bit integer.
  sizeBytes: string;
  path: string;
}

// What the gateway lists at an address that ends in /files.
export async function filesAt(url: string): Promise<FileLink[]> {
  const response = await fetch(url);
  if (!response.ok) throw await errorOfResponse(response);
  return ((await response.json()) as { files: FileLink[] }).files;
}

export function FileLinks({ files }: { files: FileLink[] | undefined }) {
  return (
    <ul>
      {files?.map(({ name, sizeBytes, path }) => (
        <li key={path}>
          <a className="download-file" href={path} download={name}>
            <Icon name="download" />
            <span>{name}</span>
            <span className="sub">{bytes(Number(sizeBytes))}</span>
          </a>
        </li>
      ))}
    </ul>
  );
}
