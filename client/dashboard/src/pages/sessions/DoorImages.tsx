// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { sessions } from '../../api/clients';
import { hex } from '../../api/digests';
import { siteName } from '../../api/names';
import { Image_Camera as Camera, Image_Encoding as Encoding, type Image } from '../../gen/enfilade/v1/record_pb';
import { useLive } from '../../live/context';
import { clock } from '../../ui/format';

// Of a series, so that two of them fit side by side. The rest comes when it is asked for.
const SHOWN = 4;

const cameras: Record<Camera, string> = { [Camera.UNSPECIFIED]: 'Camera', [Camera.FRONT]: 'Front', [Camera.REAR]: 'Rear' };

// Asked for when somebody looks.
export function useDoorImages(verdict: string, wanted: boolean) {
  return useQuery({ queryKey: ['door images', verdict], enabled: wanted, queryFn: () => sessions.getDoorImages({ name: verdict }) });
}

// One image, as it was recorded.
export function Picture({ image, what }: { image: Image; what: string }) {
  const live = useLive();
  const [missing, setMissing] = useState(false);
  const name = `${cameras[image.camera]}${image.encoding === Encoding.DEPTH_PNG16 ? ' (depth)' : ''}`;
  const time = image.time ? clock(timestampMs(image.time)) : '';
  const address = `/v1/${siteName(live.id)}/blobs/${hex(image.content?.sha256 ?? new Uint8Array())}`;
  return (
    <figure className="door-image">
      {missing ? (
        <div className="door-image-none">This picture is no longer stored.</div>
      ) : (
        <a href={address} target="_blank" rel="noreferrer">
          <img src={address} alt={`${what}: ${name.toLowerCase()} at ${time}`} loading="lazy" onError={() => setMissing(true)} />
        </a>
      )}
      <figcaption className="sub">
        {name} {time}
      </figcaption>
    </figure>
  );
}

// The images of one side; `none` says why there are none.
export function Series({ title, images, what, none }: { title: string; images: Image[]; what: string; none: string }) {
  const [all, setAll] = useState(false);
  const shown = all ? images : images.slice(0, SHOWN);
  return (
    <section className="series" aria-label={title}>
      <h3>{title}</h3>
      {images.length === 0 && <p className="sub">{none}</p>}
      <div className="series-images">
        {shown.map((image, i) => (
          <Picture key={i} image={image} what={what} />
        ))}
      </div>
      {images.length > SHOWN && (
        <button className="button" onClick={() => setAll(!all)}>
          {all ? `First ${SHOWN} only` : `All ${images.length}`}
        </button>
      )}
    </section>
  );
}
