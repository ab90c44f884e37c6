// SPDX-License-Identifier: Apache-2.0
import { lazy, type ComponentType } from 'react';
import type { LiveSite } from '../live/site';
import CampusPage from '../pages/campus/CampusPage';
import type { IconName } from '../ui/Icon';

export interface Page {
  // In the address: /s/SITE/PATH.
  path: string;
  title: string;
  icon: IconName;
  component: ComponentType;
  // Beside the title in the rail.
  count?: (site: LiveSite) => number;
}

// The rail, from above. The campus is where most begin: it comes with the first script, the others when they are opened.
export const pages: Page[] = [
  { path: 'campus', title: 'Campus', icon: 'campus', component: CampusPage },
  { path: 'maps', title: 'Maps', icon: 'map', component: lazy(() => import('../pages/maps/MapsPage')), count: (site) => site.maps.size },
  { path: 'plans', title: 'Plans', icon: 'plan', component: lazy(() => import('../pages/plans/PlansPage')) },
  { path: 'linkPoints', title: 'Link points', icon: 'link', component: lazy(() => import('../pages/linkpoints/LinkPointsPage')), count: (site) => site.linkPoints.size },
  { path: 'robots', title: 'Robots', icon: 'robot', component: lazy(() => import('../pages/robots/RobotsPage')), count: (site) => site.robots.count },
  { path: 'sessions', title: 'Sessions', icon: 'session', component: lazy(() => import('../pages/sessions/SessionsPage')) },
  { path: 'history', title: 'History', icon: 'history', component: lazy(() => import('../pages/history/HistoryPage')) },
  { path: 'georeference', title: 'Georeference', icon: 'globe', component: lazy(() => import('../pages/georeference/GeoreferencePage')) },
  { path: 'health', title: 'Health', icon: 'health', component: lazy(() => import('../pages/health/HealthPage')) },
];
