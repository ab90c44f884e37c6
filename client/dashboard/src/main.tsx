// SPDX-License-Identifier: Apache-2.0
import './ui/styles/theme.css';
import './ui/styles/controls.css';
import './ui/styles/content.css';
import './ui/styles/shell.css';
import './ui/styles/search.css';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { createRoot } from 'react-dom/client';
import { App } from './app/App';

const queries = new QueryClient({ defaultOptions: { queries: { retry: 1, staleTime: 10_000 } } });

createRoot(document.getElementById('root')!).render(
  <QueryClientProvider client={queries}>
    <App />
  </QueryClientProvider>,
);
