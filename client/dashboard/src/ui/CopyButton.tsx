// SPDX-License-Identifier: Apache-2.0
import { useEffect, useState } from 'react';
import { Icon } from './Icon';

// Plain http has no clipboard: there the text is selected in a field of its own and copied the old way.
async function copy(text: string): Promise<boolean> {
  if (navigator.clipboard !== undefined) {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch {
      // Not allowed: as without it.
    }
  }
  const field = document.createElement('textarea');
  field.value = text;
  field.className = 'hidden-text';
  document.body.append(field);
  field.select();
  const done = document.execCommand('copy');
  field.remove();
  return done;
}

export function CopyButton({ text, what }: { text: string; what: string }) {
  const [said, setSaid] = useState('');
  useEffect(() => {
    if (said === '') return;
    const timer = setTimeout(() => setSaid(''), 1500);
    return () => clearTimeout(timer);
  }, [said]);
  const onClick = async () => setSaid((await copy(text)) ? 'Copied' : 'The browser does not allow copying');
  return (
    <>
      <button className="button icon plain small" title={`Copy ${what}`} aria-label={`Copy ${what}`} onClick={() => void onClick()}>
        <Icon name="copy" />
      </button>
      <span role="status" className="sub">
        {said}
      </span>
    </>
  );
}
