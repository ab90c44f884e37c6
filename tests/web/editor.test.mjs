// SPDX-License-Identifier: Apache-2.0
import { addAreas } from './checks/areas.mjs';
import { addEditingTogether } from './checks/editing_together.mjs';
import { addEditor } from './checks/editor.mjs';
import { addEditorAccess } from './checks/editor_access.mjs';
import { addJsonMaps } from './checks/json_maps.mjs';
import { addSurvivesMapping } from './checks/survives_mapping.mjs';
import { setStage } from './stage.mjs';

const { system, browser } = setStage((started) => started.enfilade('editing', 'site', 'create', 'editing'));

const stage = { system, browser, at: (path) => `${system.url}/s/${path}` };

for (const add of [addEditor, addEditingTogether, addAreas, addEditorAccess, addJsonMaps, addSurvivesMapping]) add(stage);
