// SPDX-License-Identifier: Apache-2.0
import { CopyButton } from '../ui/CopyButton';
import { latLonText } from './georeference';
import type { LatLon } from './wgs84';

// A row of a list of facts: a place's latitude and longitude, to be copied.
export function OnTheGlobe({ place }: { place: LatLon }) {
  return (
    <>
      <dt>On the globe</dt>
      <dd className="with-action">
        {latLonText(place)}
        <CopyButton text={latLonText(place)} what="latitude, longitude" />
      </dd>
    </>
  );
}
