// SPDX-License-Identifier: Apache-2.0
import { useEffect, useState } from 'react';
import { copy, NOT_COPIED } from './clipboard';
import { Icon } from './Icon';

export function CopyButton({ text, what }: { text: string; what: string }) {
  const [said, setSaid] = useState('');
  useEffect(() => {
    if (said === '') return;
    const timer = setTimeout(() => setSaid(''), 1500);
    return () => clearTimeout(timer);
  }, [said]);
  const onClick = async () => setSaid((await copy(text)) ? 'Copied' : NOT_COPIED);
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
