// SPDX-License-Identifier: Apache-2.0
// A report as its reader meets it, in a real browser:
//   node tests/browser/report_test.mjs path/to/report.html [screenshot.png] [--sliders]     the last: there must be some
// Exits with 0 when every check passes. Once, before the first run: npm ci in tests/browser.

import {with_report} from './browser.mjs';
import {check, end} from './check.mjs';

const [path, picture] = process.argv.slice(2).filter((argument) => argument !== '--sliders');
const has_sliders = process.argv.includes('--sliders');
if (!path) {
  console.error('usage: node report_test.mjs path/to/report.html [screenshot.png]');
  process.exit(2);
}

// In the page: the time plots, first those of the axis with the most plots.
const linked_plots = () => {
  const data = JSON.parse(document.getElementById('report-data')?.textContent ?? '{"plots":[]}');
  const by_axis = new Map();
  data.plots.forEach((plot, i) => {
    if (plot.kind === 'time') by_axis.set(plot.axis, [...(by_axis.get(plot.axis) ?? []), i]);
  });
  return [...by_axis.values()].sort((a, b) => b.length - a.length)[0] ?? [];
};

const close = (a, b) => Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]) < 1e-6 * Math.max(1, Math.abs(a[1]));
const width = (range) => range[1] - range[0];

try {
  await with_report(path, {}, async ({page, complaints, url}) => {
    // Two frames: one that applies a new range to all plots, one that shows it.
    const settle = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() =>
      requestAnimationFrame(() => setTimeout(done, 0)))));
    await settle();

    check('the page has a title and a heading', (await page.title()) !== '' &&
          (await page.locator('h1').count()) === 1);
    check('nothing reaches beyond the edge of the window', await page.evaluate(() =>
      document.documentElement.scrollWidth <= document.documentElement.clientWidth));
    const loose = await page.locator('body b, body script[src], body img[src^="http"], link').count();
    check('no markup from data and no outside file is in the page', loose === 0, loose);

    const plots = await page.evaluate(linked_plots);
    if (plots.length > 0) {
      const chart = (i) => page.locator(`#plot-${i} .chart`);
      const ranges = () => page.evaluate((list) => list.map((i) =>
        document.querySelector(`#plot-${i} .chart`).dygraph.xAxisRange()), plots);
      const picture_of = (i) => page.evaluate((k) =>
        [...document.querySelectorAll(`#plot-${k} canvas`)][0].toDataURL(), i);
      // Where the plot area of plot i lies in the window.
      const area = async (i) => {
        await chart(i).scrollIntoViewIfNeeded();
        const box = await chart(i).boundingBox();
        const inner = await chart(i).evaluate((element) => element.dygraph.getArea());
        return {x: box.x + inner.x, y: box.y + inner.y, w: inner.w, h: inner.h};
      };
      const drag = async (i, from, to, y = .5) => {
        const a = await area(i);
        await page.mouse.move(a.x + from * a.w, a.y + y * a.h);
        await page.mouse.down();
        await page.mouse.move(a.x + (from + to) / 2 * a.w, a.y + y * a.h, {steps: 4});
        await page.mouse.move(a.x + to * a.w, a.y + y * a.h, {steps: 4});
        await page.mouse.up();
        await settle();
      };
      const all_equal = (list) => list.every((range) => close(range, list[0]));
      const first = plots[0];
      const last = plots[plots.length - 1];

      const full = await ranges();
      check(`all ${plots.length} linked plots open on the same range`, all_equal(full), full);
      for (const i of plots) {
        const drawn = await page.evaluate((k) => {
          const canvas = document.querySelector(`#plot-${k} canvas`);
          const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
          return pixels.some((value) => value !== 0);
        }, i);
        check(`plot ${i} has drawn something`, drawn);
      }

      await drag(first, .3, .6);
      const zoomed = await ranges();
      check('dragging zooms to the time that was dragged over',
            Math.abs(width(zoomed[0]) / width(full[0]) - .3) < .02 &&
            Math.abs((zoomed[0][0] - full[0][0]) / width(full[0]) - .3) < .02, zoomed[0]);
      check('all linked plots have the new range', all_equal(zoomed), zoomed);
      check('the way back is offered', await page.locator(`#plot-${last} .reset`).isVisible());

      await page.keyboard.down('Shift');
      await drag(last, .5, .7);
      await page.keyboard.up('Shift');
      const panned = await ranges();
      check('shift-drag pans: the range moves and keeps its width',
            Math.abs(width(panned[0]) / width(zoomed[0]) - 1) < 1e-6 &&
            Math.abs((zoomed[0][0] - panned[0][0]) / width(zoomed[0]) - .2) < .02, panned[0]);
      check('all linked plots have panned', all_equal(panned), panned);

      const a = await area(first);
      await page.mouse.move(a.x + .5 * a.w, a.y + .5 * a.h);
      await page.mouse.wheel(80, 0);
      await settle();
      const scrolled = await ranges();
      check('scrolling sideways pans all linked plots',
            scrolled[0][0] > panned[0][0] && Math.abs(width(scrolled[0]) / width(panned[0]) - 1) < 1e-6 &&
            all_equal(scrolled), scrolled);
      for (let k = 0; k < 60; ++k) await page.mouse.wheel(400, 0);
      await settle();
      const edge = await ranges();
      check('panning stops at the end of the data', Math.abs(edge[0][1] - full[0][1]) < 1e-6 * width(full[0]), edge[0]);

      await page.mouse.move(a.x + .4 * a.w, a.y + .5 * a.h);
      await page.mouse.move(a.x + .41 * a.w, a.y + .5 * a.h);
      await settle();
      const readouts = await page.evaluate((list) => list.map((i) => ({
        when: document.querySelector(`#plot-${i} .when`).textContent,
        values: [...document.querySelectorAll(`#plot-${i} .value`)].every((value) => value.textContent !== ''),
        cursor: getComputedStyle(document.querySelector(`#plot-${i} .cursor`)).display})), plots);
      check('pointing at one plot shows time, cursor and every value in all of them', readouts.every((r) =>
        r.when !== '' && r.when === readouts[0].when && r.values && r.cursor === 'block'), readouts);
      await page.mouse.move(2, 2);
      await settle();
      check('the cursor leaves with the mouse', (await page.locator(`#plot-${last} .when`).textContent()) === '');

      await page.waitForTimeout(600);  // longer than a double-click: what follows belongs to nothing before it
      const b = await area(first);
      await page.mouse.dblclick(b.x + .5 * b.w, b.y + .4 * b.h);
      await settle();
      const after = await ranges();
      check('double-click resets all linked plots', after.every((range, k) => close(range, full[k])), after);
      check('and the way back is no longer offered', !(await page.locator(`#plot-${last} .reset`).isVisible()));

      const box = page.locator(`#plot-${first} .legend input`).first();
      const before = await picture_of(first);
      await box.click();
      await settle();
      const without = await picture_of(first);
      check('unticking a series changes the picture', without !== before);
      await box.focus();
      await page.keyboard.press('Space');
      await settle();
      check('ticking it again from the keyboard brings it back', (await picture_of(first)) === before);

      await chart(first).focus();
      await page.keyboard.press('+');
      await settle();
      const nearer = await ranges();
      check('the + key zooms all linked plots',
            all_equal(nearer) && Math.abs(width(nearer[0]) / width(full[0]) - .5) < .01, nearer);
      await page.keyboard.press('ArrowRight');
      await settle();
      check('the arrow key moves the cursor', (await page.locator(`#plot-${last} .when`).textContent()) !== '');
      await page.keyboard.press('0');
      await settle();
      check('the 0 key resets', (await ranges()).every((range, k) => close(range, full[k])));

      const handles = page.locator(`#plot-${last} .dygraph-rangesel-zoomhandle`);
      check('the last linked plot has a range selector, and it alone', (await handles.count()) === 2 &&
            (await page.locator(plots.map((i) => `#plot-${i} .dygraph-rangesel-zoomhandle`).join(','))
              .count()) === 2, await handles.count());
      await handles.first().scrollIntoViewIfNeeded();
      const handle = await handles.first().boundingBox();
      await page.mouse.move(handle.x + handle.width / 2, handle.y + handle.height / 2);
      await page.mouse.down();
      await page.mouse.move(handle.x + 100, handle.y + handle.height / 2, {steps: 5});
      await page.mouse.move(handle.x + 200, handle.y + handle.height / 2, {steps: 5});
      await page.mouse.up();
      await settle();
      const selected = await ranges();
      check('its handle narrows all linked plots', all_equal(selected) && selected[0][0] > full[0][0] &&
            close([0, selected[0][1]], [0, full[0][1]]), selected);
      await page.locator(`#plot-${last} .reset`).click();
      await settle();
      check('the button resets', (await ranges()).every((range, k) => close(range, full[k])));
    } else {
      check('a page without time plots carries no plotting library', (await page.evaluate(() => typeof Dygraph)) ===
            'undefined');
    }

    // Of every series that sliders move: the largest difference between what is drawn and what it should be, with slider i at `share`.
    const off_by = (which, at) => page.evaluate(({slider, share}) => {
      const data = JSON.parse(document.getElementById('report-data').textContent);
      let worst = 0, moved = 0, farthest = 0;
      data.plots.forEach((plot, i) => {
        if (plot.kind !== 'time') return;
        const graph = document.querySelector(`#plot-${i} .chart`).dygraph;
        const lead = graph.getValue(0, 0) < data.times[plot.time][0] ? 1 : 0;
        let column = 0;
        for (const series of plot.series) {
          column += series.lower ? 3 : 1;
          const move = (series.moves ?? []).find((one) => one.slider === slider);
          if (!move) continue;
          ++moved;
          series.y.forEach((y, k) => {
            if (y === null) return;
            const change = share === 0 ? move.low[k] : share === 0.5 ? move.half_way[k] : 0;
            worst = Math.max(worst, Math.abs(graph.getValue(k + lead, column) - y - change));
            farthest = Math.max(farthest, Math.abs(change));
          });
        }
      });
      return {worst, moved, farthest};
    }, {slider: which, share: at});
    const count = await page.locator('.slider input').count();
    if (has_sliders) check('the page has a slider', count > 0, count);
    for (let i = 0; i < count; ++i) {
      const slide = async (share) => {
        await page.locator(`#slider-${i}`).fill(String(share));
        await settle();
        return {...await off_by(i, share), words: await page.locator('.slider output').nth(i).textContent()};
      };
      for (const [share, words] of [[0, 'none'], [0.5, '50\u2009%']]) {
        const at = await slide(share);
        check(`slider ${i} at ${share}: its curves are as simulated`, at.moved > 0 && at.worst < 1e-9 && at.farthest > 0, at);
        check(`slider ${i} at ${share} says so`, at.words === words, at.words);
        check(`slider ${i} at ${share}: the legend says that it was moved`,
              await page.locator('.legend .name', {hasText: 'sliders moved'}).count() === at.moved);
      }
      await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
      const printed = await off_by(i, 1);
      check('what is printed is as fitted, wherever sliders stand', printed.worst < 1e-9, printed);
      await page.evaluate(() => dispatchEvent(new Event('afterprint')));
      const after_print = await off_by(i, 0.5);
      check('after printing the curves are where sliders stand', after_print.worst < 1e-9, after_print);
      const back = await slide(1);
      check(`slider ${i} back at its end: the curves as they were`, back.worst < 1e-9 && back.words === 'as fitted', back);
    }

    const scatters = page.locator('.plot.scatter .chart');
    if (await scatters.count() > 0) {
      const scatter = scatters.first();
      await scatter.scrollIntoViewIfNeeded();
      const box = await scatter.boundingBox();
      const view = () => scatter.evaluate((element) => element.view());
      const before = await view();
      await page.mouse.move(box.x + .4 * box.width, box.y + .3 * box.height);
      await page.mouse.down();
      await page.mouse.move(box.x + .7 * box.width, box.y + .6 * box.height, {steps: 4});
      await page.mouse.up();
      const nearer = await view();
      check('dragging zooms a scatter plot',
            width(nearer.x) < width(before.x) && width(nearer.y) < width(before.y), nearer);
      await page.waitForTimeout(600);
      await page.mouse.dblclick(box.x + .5 * box.width, box.y + .5 * box.height);
      check('double-click resets it', JSON.stringify(await view()) === JSON.stringify(before), await view());
      let tip = false;
      for (let k = 2; k < 20 && !tip; ++k) {
        for (let m = 2; m < 18 && !tip; ++m) {
          await page.mouse.move(box.x + k / 20 * box.width, box.y + m / 20 * box.height);
          tip = await scatter.locator('.tip').isVisible();
        }
      }
      check('pointing at a scatter plot reads out a point', tip);
      await page.mouse.move(2, 2);
    }

    await page.setViewportSize({width: 700, height: 900});
    await settle();
    await page.waitForTimeout(100);
    check('at 700 px, too, nothing reaches beyond the edge', await page.evaluate(() =>
      document.documentElement.scrollWidth <= document.documentElement.clientWidth));
    await page.setViewportSize({width: 420, height: 900});
    await settle();
    await page.waitForTimeout(100);
    check('at 420 px nothing reaches beyond the edge', await page.evaluate(() =>
      document.documentElement.scrollWidth <= document.documentElement.clientWidth));
    const tables = await page.evaluate(() => [...document.querySelectorAll('.table')].map((table) => {
      const before = table.previousElementSibling;
      const one_word_a_line = [...table.querySelectorAll('th, td')].filter((cell) => {
        const words = cell.textContent.trim().split(/\s+/).length;
        const range = document.createRange();
        range.selectNodeContents(cell);
        return words > 2 && new Set([...range.getClientRects()].map((box) => Math.round(box.top))).size >= words;
      }).map((cell) => cell.textContent);
      return {scrolls: table.scrollWidth > table.clientWidth + 1,
              says_so: before?.className.startsWith('scrolls') && getComputedStyle(before).display !== 'none', one_word_a_line};
    }));
    check('at 420 px a table says that it scrolls where it does, and only there', tables.every((t) => t.scrolls === !!t.says_so), tables);
    check('at 420 px no column has one word a line', tables.every((t) => t.one_word_a_line.length === 0), tables);
    await page.setViewportSize({width: 1280, height: 900});
    await settle();
    const on_paper = (await page.pdf({preferCSSPageSize: true})).toString('latin1').match(/\/Type\s*\/Page\b/g).length;
    check('in print it has at most 8 pages', on_paper <= 8, on_paper);
    await settle();

    if (picture) {
      await page.evaluate(() => scrollTo(0, 0));
      await page.screenshot({path: picture, fullPage: true});
    }
    check('the page was opened from the disk', url.startsWith('file://'));
    const requests = complaints.filter((complaint) => complaint.startsWith('request'));
    check('no request left the page', requests.length === 0, requests);
    const errors = complaints.filter((complaint) => !complaint.startsWith('request'));
    check('the console stayed silent', errors.length === 0, errors);
  });
} catch (error) {
  check('the browser came to the end of the test', false, String(error));
}
end();
