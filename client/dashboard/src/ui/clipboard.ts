// SPDX-License-Identifier: Apache-2.0

export const NOT_COPIED = 'The browser does not allow copying';

// Plain http has no clipboard: there the text is selected in a field of its own and copied the old way.
export async function copy(text: string): Promise<boolean> {
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
