// SPDX-License-Identifier: Apache-2.0
// A page that goes on: takes what its server sends and hands it to the plots of page.js. Events, their data in JSON:
//
//   begin   {"name", "duration_s"}      a session begins; the plots begin anew
//   sample  {"t", "plots", "state"}     a row: time, for each plot the values of its series (null: none), and words for the state
//   said    "a line"                    that is worth keeping
//   end     "words"                     nothing will follow
//
// Drawing is at the browser's leisure: what has come meanwhile is drawn at once.

(function () {
  'use strict';
  const place = document.getElementById('live');
  const state = place.querySelector('.state');
  const said = place.querySelector('ul');
  const plots = Array.from(document.querySelectorAll('.plot.time .chart'), function (chart) { return chart.plot; });
  const events = new EventSource(place.dataset.events);
  const shortest_ms = 200;  // between two drawings
  let session = null;
  let waiting = [];
  let drawing = null;
  let ended = false;

  function draw() {
    drawing = null;
    const now = waiting;
    waiting = [];
    if (now.length === 0) return;
    plots.forEach(function (plot, i) {
      plot.extend(now.map(function (sample) { return [sample.t].concat(sample.plots[i]); }));
    });
    const last = now[now.length - 1];
    if (!ended) say_state(session.name + ': ' + last.t.toFixed(1) + '\u2009s of ' + session.duration_s + '\u2009s, ' + last.state);
  }

  function say_state(text) { state.textContent = text; }

  function keep(text) {
    const line = document.createElement('li');
    line.textContent = text;
    said.prepend(line);
    while (said.childElementCount > 50) said.lastChild.remove();
  }

  events.addEventListener('begin', function (event) {
    draw();
    session = JSON.parse(event.data);
    for (const plot of plots) plot.begin([0, session.duration_s]);
    say_state(session.name + ' begins.');
  });
  events.addEventListener('sample', function (event) {
    waiting.push(JSON.parse(event.data));
    if (drawing === null) drawing = setTimeout(draw, shortest_ms);
  });
  events.addEventListener('said', function (event) { keep(JSON.parse(event.data)); });
  events.addEventListener('end', function (event) {
    ended = true;
    events.close();
    draw();
    say_state(JSON.parse(event.data));
  });
  events.addEventListener('error', function () {
    if (!ended) say_state('The program does not answer; what is drawn is what came before.');
  });
})();
