import { defineConfig, type UserConfig } from 'vitest/config';
import { viteSingleFile } from 'vite-plugin-singlefile';

// Where the two files go: CMake gives its build folder.
const outDir = process.env['SMASERVO_PAGE_OUT'] ?? 'dist';

// The whole page as one file.
const page: UserConfig = {
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
  build: {
    outDir,
    emptyOutDir: false,
    target: 'es2021',
    rollupOptions: { input: 'page.html' },
  },
};

// What makes the panels of a report interactive: one script, with its style inside.
const report: UserConfig = {
  build: {
    outDir,
    emptyOutDir: false,
    target: 'es2021',
    lib: { entry: 'src/report/main.ts', formats: ['iife'], name: 'smaservoReport', fileName: () => 'report.js' },
  },
};

export default defineConfig(({ mode }) => ({
  ...(mode === 'report' ? report : page),
  // No test is judged by its time: a machine may be busy.
  test: { testTimeout: 120_000, environment: 'node', include: ['tests/**/*.test.ts'] },
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  // A bridge that runs already, for `npm run dev`.
  server: { proxy: { '/ws': { target: process.env['SMASERVO_BRIDGE'] ?? 'http://127.0.0.1:8765', ws: true } } },
}));
