// SPDX-License-Identifier: Apache-2.0
import { useLive } from '../live/context';
import { CopyButton } from '../ui/CopyButton';
import { pose as poseText } from '../ui/format';
import { converterOf, useGeoreference } from './georeference';
import { OnTheGlobe } from './OnTheGlobe';

// In the world, and on the globe if the site has a georeference.
export function WorldPose({ pose }: { pose: { x: number; y: number; yaw: number } }) {
  const site = useLive();
  const { data } = useGeoreference(site);
  const place = converterOf(site, data)?.(pose);
  return (
    <>
      <dd className="with-action">
        {poseText(pose)}
        <CopyButton text={`${pose.x} ${pose.y} ${pose.yaw}`} what="x y yaw (m, rad)" />
      </dd>
      {place && <OnTheGlobe place={place} />}
    </>
  );
}
