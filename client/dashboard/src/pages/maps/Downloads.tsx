// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { problemOf } from '../../api/errors';
import type { MapRevision } from '../../gen/enfilade/v1/map_pb';
import { FileLinks, filesAt } from '../../ui/FileLinks';

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
    queryFn: () => filesAt(`/v1/${revision}/files?format=${format}`),
  });
  return (
    <details className="download" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {isFetching && <p className="sub">Rendering …</p>}
      {error && <p className="sub">{problemOf(error).text}</p>}
      <FileLinks files={data} />
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
