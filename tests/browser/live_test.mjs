// SPDX-License-Identifier: Apache-2.0
// The page of a session that goes on, in a real browser, while `sinew hil --page` runs on the emulated firmware:
//   node tests/browser/live_test.mjs path/to/sinew [screenshot.png]
// Exits with 0 when every check passes. Once, before the first run: npm ci in tests/browser.

import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {createServer} from 'node:net';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {with_report} from './browser.mjs';
import {check, end} from './check.mjs';

const [program, picture] = process.argv.slice(2);
if (!program) {
  console.error('usage: node live_test.mjs path/to/sinew [screenshot.png]');
  process.exit(2);
}

const port = await new Promise((done) => {
  const server = createServer().listen(0, '127.0.0.1', () => {
    const free = server.address().port;
    server.close(() => done(free));
  });
});
const folder = mkdtempSync(join(tmpdir(), 'sinew-live-'));
const scenario = join(folder, 'two_minutes.yaml');
writeFileSync(scenario, `format: 1\nseed: 5\nduration_s: 120\ninput: { babble: { lowest_deg: -45, highest_deg: 45, longest_hold_s: 8 } }\n`);
let session = null;
try {
  session = spawn(program, ['hil', scenario, '--emulate', '--page', String(port), '--out', join(folder, 'out')], {stdio: 'ignore'});
  const ended = new Promise((done) => session.on('exit', done));
  for (let k = 0; k < 500; ++k) {
    if (await fetch(`http://127.0.0.1:${port}/`).then((answer) => answer.ok, () => false)) break;
    await new Promise((done) => setTimeout(done, 20));
  }
  await with_report(`http://127.0.0.1:${port}/`, {}, async ({page, complaints}) => {
    const state = page.locator('#live .state');
    const of_plot = (i) => page.evaluate((k) => {
      const chart = document.querySelector(`#plot-${k} .chart`);
      return {rows: chart.dygraph.numRows(), range: chart.dygraph.xAxisRange(), empty: chart.querySelectorAll('.empty').length,
              value: document.querySelector(`#plot-${k} .value`).textContent};
    }, i);
    check('there are plots of temperatures, angle and duty', await page.locator('.plot.time').count() === 3);
    await page.waitForFunction(() => /s of \d+.s, armed/.test(document.querySelector('#live .state').textContent), null, {timeout: 60000});
    const early = await of_plot(0);
    await page.waitForFunction((rows) => document.querySelector('#plot-0 .chart').dygraph.numRows() > rows, early.rows, {timeout: 60000});
    check('it says how far the session is, and the plots grow while it runs', early.rows > 2, early);
    check('a value is read out while nothing is pointed at', /^[\u22120-9.]+$/.test(early.value), early.value);
    await page.evaluate(() => document.querySelector('#plot-0 .chart').dygraph.updateOptions({dateWindow: [1, 2]}));
    await page.waitForFunction(() => /has ended/.test(document.querySelector('#live .state').textContent), null, {timeout: 300000});
    await ended;
    await page.waitForTimeout(1500);
    check('it says how the session ended, and goes on saying so when the program is gone',
          (await state.textContent()) === 'The session has ended: finished', await state.textContent());
    const plots = [await of_plot(0), await of_plot(1), await of_plot(2)];
    check('all plots have all rows, and one axis', plots.every((one) => one.rows > 1000 && one.rows === plots[0].rows && one.empty === 0), plots);
    check('what was zoomed to while rows came stays', plots.every((one) => Math.abs(one.range[0] - 1) < .01 && Math.abs(one.range[1] - 2) < .01),
          plots.map((one) => one.range));
    await page.locator('#plot-0 .chart').dblclick();
    const whole = await of_plot(0);
    check('a double click shows all of it again', whole.range[0] < .01 && whole.range[1] > 100, whole.range);
    check('the page asks for itself and its events alone, and complains of nothing', complaints.length === 0, complaints);
    if (picture) await page.screenshot({path: picture});
  });
  check('the session ended as it would without', await ended === 0, await ended);
} finally {
  session?.kill();
  rmSync(folder, {recursive: true, force: true});
}
end();
