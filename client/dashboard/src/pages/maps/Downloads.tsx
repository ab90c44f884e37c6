// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { errorOfResponse, problemOf } from '../../api/errors';
import type { MapRevision } from '../../gen/enfilade/v1/map_pb';
import { bytes } from '../../ui/format';
import { Icon } from '../../ui/Icon';

interface FileLink {
  name: string;
  // A 64-bit integer.
  sizeBytes: string;
  path: string;
}

const formats = [
  ['pgm', 'PGM and YAML, for Nav2'],
  ['png', 'PNG and YAML'],
  ['json', 'JSON'],
] as const;

// The server renders the files when they are asked for, so they are listed only then.
function Format({ revision, format, title }: { revision: string; format: string; title: string }) {
  const [open, setOpen] = useState(false);
  const { data, error, isFetching } = useQuery({
    queryKey: ['files', revision, format],
    enabled: open,
    staleTime: Infinity,
    queryFn: async () => {
      const response = await fetch(`/v1/${revision}/files?format=${format}`);
      if (!response.ok) throw await errorOfResponse(response);
      return ((await response.json()) as { files: FileLink[] }).files;
    },
  });
  return (
    <details className="download" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {isFetching && <p className="sub">Rendering …</p>}
      {error && <p className="sub">{problemOf(error).text}</p>}
      <ul>
        {data?.map(({ name, sizeBytes, path }) => (
          <li key={path}>
            <a className="download-file" href={path} download={name}>
              <Icon name="download" />
              <span>{name}</span>
              <span className="sub">{bytes(Number(sizeBytes))}</span>
            </a>
          </li>
        ))}
      </ul>
    </details>
  );
}

export function Downloads({ revision }: { revision: MapRevision }) {
  return (
    <section>
      <h2>Download</h2>
      {formats.map(([format, title]) => (
        <Format key={`${revision.name} ${format}`} revision={revision.name} format={format} title={title} />
      ))}
    </section>
  );
}
