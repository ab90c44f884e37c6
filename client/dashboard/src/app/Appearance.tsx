// SPDX-License-Identifier: Apache-2.0
import { Icon } from '../ui/Icon';
import type { Setting } from '../ui/setting';
import { mapColours, theme, type MapColours, type Theme } from '../ui/theme';

const themeTitles: Record<Theme, string> = { auto: 'As the system', light: 'Light', dark: 'Dark' };
const colourTitles: Record<MapColours, string> = {
  standard: 'Standard', classic: 'Grey, as robots’ tools show maps', contrast: 'High contrast', 'colour-blind': 'Safe for colour blindness',
};
const themeIcon = { auto: 'auto', light: 'sun', dark: 'moon' } as const;

function Choice<T extends string>({ title, setting, titles }: { title: string; setting: Setting<T>; titles: Record<T, string> }) {
  const chosen = setting.use();
  return (
    <fieldset>
      <legend>{title}</legend>
      {setting.choices.map((value) => (
        <label key={value}>
          <input type="radio" name={title} checked={value === chosen} onChange={() => setting.set(value)} /> {titles[value]}
        </label>
      ))}
    </fieldset>
  );
}

// Which colours the pages and the maps have.
export function Appearance() {
  const chosen = theme.use();
  return (
    <>
      <button className="button icon plain" title="Appearance" aria-label="Appearance" popoverTarget="appearance">
        <Icon name={themeIcon[chosen]} />
      </button>
      <div id="appearance" className="appearance" popover="auto" role="group" aria-label="Appearance">
        <Choice title="Theme" setting={theme} titles={themeTitles} />
        <Choice title="Colours of maps" setting={mapColours} titles={colourTitles} />
      </div>
    </>
  );
}
