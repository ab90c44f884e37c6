// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery } from '@tanstack/react-query';
import { maps } from '../../../api/clients';
import { problemOf } from '../../../api/errors';
import { Failed } from '../../../ui/States';

// Whether surveys leave the map's sessions as people have put them.
export function MapPin({ map }: { map: string }) {
  const { data, error, refetch } = useQuery({ queryKey: ['map', map], staleTime: 0, queryFn: async () => (await maps.getMap({ name: map })).map });
  const pin = useMutation({
    mutationFn: (pinned: boolean) => maps.updateMap({ map: { name: map, etag: data!.etag, pinned }, updateMask: { paths: ['pinned'] } }),
    onSettled: () => refetch(),
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return null;
  return (
    <>
      <label className="choice" title="Surveys neither cut nor move the sessions of a map that people have merged, split or restored, until it is unpinned">
        <input type="checkbox" checked={data.pinned} disabled={pin.isPending} onChange={() => pin.mutate(!data.pinned)} /> Pinned: surveys leave it as it is
      </label>
      {pin.error && (
        <p className="refusal" role="alert">
          {problemOf(pin.error).title}: {problemOf(pin.error).text}
        </p>
      )}
    </>
  );
}
