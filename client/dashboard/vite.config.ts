// SPDX-License-Identifier: Apache-2.0
import react from '@vitejs/plugin-react';
import { defineConfig } from 'vite';

const gateway = process.env.ENFILADE_GATEWAY ?? 'http://127.0.0.1:8080';
const proxy = { '/v1': { target: gateway, changeOrigin: true } };

// What the gateway sends with every page, so that `npm run preview` behaves as the embedded dashboard.
const policy =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; " +
  "worker-src 'self'; font-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";

export default defineConfig({
  plugins: [react()],
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    cssCodeSplit: false, // it is small, and each file is a request
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 700, // kB, not compressed
    // What pages share is one file: small ones would each be a request before the first page shows anything.
    rolldownOptions: { output: { codeSplitting: { groups: [{ name: 'shared', test: /node_modules|src\/(api|app|gen|live|scene|signal|ui)/ }] } } },
    reportCompressedSize: true,
  },
  server: { proxy },
  preview: { proxy, headers: { 'Content-Security-Policy': policy } },
  test: { include: ['src/**/*.test.ts'], testTimeout: 120_000 }, // no test is about time
} as Parameters<typeof defineConfig>[0]);
