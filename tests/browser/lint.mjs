// SPDX-License-Identifier: Apache-2.0
// ESLint over the scripts of pages and over the tests of it: node tests/browser/lint.mjs
// Exits with 0 when nothing is found. Once, before the first run: npm ci in tests/browser.

import {readFileSync} from 'node:fs';
import {fileURLToPath} from 'node:url';
import {Linter} from 'eslint';
import js from '@eslint/js';
import globals from 'globals';

const rules = {
  ...js.configs.recommended.rules,
  'eqeqeq': 'error', 'no-implicit-globals': 'error', 'no-shadow': 'error', 'no-var': 'error', 'prefer-const': 'error', 'strict': 'error'
};
const root = new URL('../../', import.meta.url);
const script = {sourceType: 'script', globals: {...globals.browser, Dygraph: 'readonly'}};
const test = {sourceType: 'module', globals: {...globals.node, ...globals.browser}};
const files = {
  'report/page.js': script, 'report/live.js': script, 'tests/browser/browser.mjs': test, 'tests/browser/report_test.mjs': test,
  'tests/browser/live_test.mjs': test, 'tests/browser/screenshot.mjs': test, 'tests/browser/lint.mjs': test
};
let failed = 0;
for (const [name, languageOptions] of Object.entries(files)) {
  const text = readFileSync(fileURLToPath(new URL(name, root)), 'utf8');
  const found = new Linter().verify(text, {files: ['**/*.js', '**/*.mjs'], languageOptions, rules}, {filename: name});
  for (const one of found) console.log(`${name}:${one.line}:${one.column}: ${one.message} (${one.ruleId})`);
  console.log(`${found.length === 0 ? 'ok  ' : 'FAIL'}  ${name} has no fault that ESLint finds`);
  failed += found.length > 0;
}
console.log(`${Object.keys(files).length - failed} passed, ${failed} failed`);
process.exit(failed > 0 ? 1 : 0);
