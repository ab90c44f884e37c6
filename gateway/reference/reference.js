// SPDX-License-Identifier: Apache-2.0
'use strict';

const dark = matchMedia('(prefers-color-scheme: dark)');
const setTheme = () => document.documentElement.classList.toggle('dark-mode', dark.matches);
dark.addEventListener('change', setTheme);
setTheme();

SwaggerUIBundle({
  url: '/openapi.json',
  dom_id: '#reference',
  deepLinking: true,
  docExpansion: 'none',
  filter: true,
  defaultModelsExpandDepth: 0,
  // A reference is for reading: nobody should change a site by a click in it.
  supportedSubmitMethods: ['get', 'head'],
  // The default asks a validator on the internet.
  validatorUrl: null,
});
