// SPDX-License-Identifier: Apache-2.0
// A page of a report in the system's Chromium, and what the page did that it should not.

import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

import {chromium} from 'playwright-core';

// Opens `path` from the disk, or an address of this machine, and hands {page, complaints, url} to `use`; whatever happens, the browser is
// closed and its profile removed. complaints: console errors and warnings, uncaught exceptions, and every request but the page's and, of
// an address, that for its events.
export async function with_report(path, options, use) {
  const profile = mkdtempSync(join(tmpdir(), 'sinew-browser-'));
  const url = path.startsWith('http://127.0.0.1:') ? path : pathToFileURL(resolve(path)).href;
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    headless: true,
    viewport: {width: options.width ?? 1280, height: options.height ?? 900},
    colorScheme: options.colorScheme ?? 'light',
    deviceScaleFactor: options.scale ?? 1,
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync'],
  });
  try {
    const page = context.pages()[0] ?? await context.newPage();
    const complaints = [];
    page.on('console', (message) => {
      const type = message.type();
      if (['error', 'warning'].includes(type)) complaints.push(`console ${type}: ${message.text()}`);
    });
    page.on('pageerror', (error) => complaints.push(`exception: ${error.message}`));
    page.on('request', (request) => {
      if (![url, `${url}events`].includes(request.url()) && !request.url().startsWith('data:')) complaints.push(`request: ${request.url()}`);
    });
    page.on('dialog', (dialog) => {
      complaints.push(`dialog: ${dialog.message()}`);
      dialog.dismiss();
    });
    await page.goto(url);
    return await use({page, complaints, url});
  } finally {
    await context.close();
    rmSync(profile, {recursive: true, force: true});
  }
}
