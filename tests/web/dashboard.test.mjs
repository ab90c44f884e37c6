// SPDX-License-Identifier: Apache-2.0
import { mapCampus } from './campus.mjs';
import { addCampus } from './checks/campus.mjs';
import { addGeoreference } from './checks/georeference.mjs';
import { addGraphEdit } from './checks/graph_edit.mjs';
import { addHistory } from './checks/history.mjs';
import { addImports } from './checks/imports.mjs';
import { addPages } from './checks/pages.mjs';
import { addPlanEdit } from './checks/plan_edit.mjs';
import { addPlans } from './checks/plans.mjs';
import { addRearranging } from './checks/rearranging.mjs';
import { addRobots } from './checks/robots.mjs';
import { addScene } from './checks/scene.mjs';
import { addSessions } from './checks/sessions.mjs';
import { addStates } from './checks/states.mjs';
import { addVersions } from './checks/versions.mjs';
import { setStage } from './stage.mjs';

const { system, browser } = setStage((started) => started.enfilade('empty', 'site', 'create', 'empty', '--name', 'Empty site'));
let mapped;

const stage = {
  system,
  browser,
  at: (path) => `${system.url}/s/${path}`,
  // Maps the campus of the site `demo`, for the first test that needs it.
  campus: () => (mapped ??= mapCampus(system)),
};

for (const add of [addScene, addCampus, addGraphEdit, addRearranging, addStates, addHistory, addSessions, addGeoreference, addImports, addPlans, addPlanEdit, addVersions, addRobots, addPages]) add(stage);
