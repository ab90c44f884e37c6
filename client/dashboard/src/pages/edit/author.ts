// SPDX-License-Identifier: Apache-2.0
import { TextSetting } from '../../ui/setting';

// Under which name this person edits.
export const author = new TextSetting('enfilade.author');
