// SPDX-License-Identifier: Apache-2.0
// A picture of a whole page (or, with 'top', of its first screen; with a selector, of what it selects), or of a figure alone:
//   node screenshot.mjs page.html|figure.svg out.png [width] [height] [light|dark] [whole|top|SELECTOR]

import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {with_report} from './browser.mjs';

const [path, out, width, height, scheme, extent] = process.argv.slice(2);
if (!out) {
  console.error('usage: node screenshot.mjs page.html|figure.svg out.png [width] [height] [light|dark] [whole|top|SELECTOR]');
  process.exit(2);
}
const options = {width: Number(width ?? 1280), height: Number(height ?? 900), colorScheme: scheme ?? 'light'};
// The smallest box around all that a selector selects. Runs in the page.
function box_of_all(selector) {
  const boxes = [...document.querySelectorAll(selector)].map((one) => one.getBoundingClientRect());
  const x = Math.min(...boxes.map((b) => b.left)), y = Math.min(...boxes.map((b) => b.top));
  const right = Math.max(...boxes.map((b) => b.right)), bottom = Math.max(...boxes.map((b) => b.bottom));
  return {x: x + window.scrollX, y: y + window.scrollY, width: right - x, height: bottom - y};
}
const folder = mkdtempSync(join(tmpdir(), 'sinew-screenshot-'));
try {
  let shown = path;
  if (path.endsWith('.svg')) {
    shown = join(folder, 'figure.html');
    writeFileSync(shown, `<!DOCTYPE html><meta charset="utf-8"><body style="margin:0">${readFileSync(path, 'utf8')}`);
  }
  await with_report(shown, options, async ({page, complaints}) => {
    await page.waitForTimeout(200);
    const is_part = extent && extent !== 'whole' && extent !== 'top';
    const clip = is_part ? await page.evaluate(box_of_all, extent) : undefined;
    await page.screenshot({path: out, fullPage: extent !== 'top', clip});
    for (const complaint of complaints) console.error(complaint);
  });
} finally {
  rmSync(folder, {recursive: true, force: true});
}
