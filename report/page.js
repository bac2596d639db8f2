// SPDX-License-Identifier: Apache-2.0
// Reads the data that page.cpp embeds (its layout is described there) and brings the plots to life. Text from the
// data reaches the document through textContent alone, except dygraphs' y label, which is escaped first.

(function () {
  'use strict';
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const root = document.documentElement;
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const spoken = document.getElementById('spoken');
  let printing = false;

  // ---- colours, numbers, ticks ----

  const in_the_dark = {
    '#000000': '#e4e5e7', '#0072b2': '#4a9fdb', '#d55e00': '#ee7a2c', '#009e73': '#1fb88c',
    '#cc79a7': '#dd93ba', '#e69f00': '#e9ac28', '#56b4e9': '#8ed0f5', '#f0e442': '#f0e442'
  };
  const tints = ['86,180,233', '230,159,0', '0,158,115', '204,121,167', '140,140,140'];

  function themed(color) { return (dark.matches && !printing && in_the_dark[color.toLowerCase()]) || color; }
  function css(name) { return getComputedStyle(root).getPropertyValue(name).trim(); }
  function with_minus(text) { return text.replace(/^-/, '\u2212'); }

  function number(value, decimals) {
    if (value === null || value === undefined || !isFinite(value)) return '\u2013';
    const text = decimals < 0 ? value.toExponential(3) : value.toFixed(decimals);
    return with_minus(/[1-9]/.test(text) ? text : text.replace(/^-/, ''));
  }

  function tick_step(low, high, at_most) {
    const span = high - low;
    if (!(span > 0) || !isFinite(span)) return 1;
    let exponent = Math.floor(Math.log10(span / Math.max(at_most, 2)));
    for (;; ++exponent) {
      for (const mantissa of [1, 2, 5]) {
        const step = mantissa * Math.pow(10, exponent);
        const count = Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1;
        if (count <= Math.max(at_most, 2)) return step;
      }
    }
  }

  function ticks(low, high, at_most) {
    const step = tick_step(low, high, at_most);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k <= Math.floor(high / step + 1e-9) && found.length < 100; ++k) {
      const v = k * step;
      let label;
      if (Math.abs(v) >= 1e6 || (step < 1e-5 && v !== 0)) {
        label = with_minus(v.toExponential(Math.min(15, Math.max(0,
            Math.floor(Math.log10(Math.abs(v) / step) + 1e-9)))).replace('e+', 'e'));
      } else {
        label = number(v, step < 1e-5 ? 0 : decimals);
      }
      found.push({v: v, label: label});
    }
    return found;
  }

  function ticker(pixels_per_tick, unit) {
    return function (low, high, pixels) {
      return ticks(low, high, Math.floor(pixels / pixels_per_tick)).map(function (tick) {
        return {v: tick.v, label: tick.label + unit};
      });
    };
  }

  // Gives a plot the keys without the ring that shows where the keyboard is.
  function focus_by_mouse(chart) {
    chart.classList.add('by-mouse');
    chart.focus({preventScroll: true});
  }
  document.addEventListener('keydown', function () {
    for (const chart of document.querySelectorAll('.by-mouse')) chart.classList.remove('by-mouse');
  }, true);

  // The index of the value nearest to x in an ascending array.
  function nearest(values, x) {
    let low = 0, high = values.length - 1;
    if (high < 0) return -1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (values[middle] < x) low = middle; else high = middle;
    }
    return Math.abs(values[low] - x) <= Math.abs(values[high] - x) ? low : high;
  }

  // ---- time axes: what the plots of one axis share ----

  const axes = data.axes.map(function (axis) {
    return {full: axis.full, window: axis.full.slice(), decimals: axis.decimals, cursor: null, plots: [], scatters: [],
            applying: false, pending: null};
  });

  function is_zoomed(axis) {
    const slack = 1e-6 * (axis.full[1] - axis.full[0]);
    return axis.window[0] > axis.full[0] + slack || axis.window[1] < axis.full[1] - slack;
  }

  // Shows [from, to], kept inside the full range, in every plot of the axis at the next frame.
  function show(axis, from, to) {
    const full = axis.full[1] - axis.full[0];
    const width = Math.min(Math.max(to - from, full * 1e-6), full);
    from = Math.min(Math.max(from, axis.full[0]), axis.full[1] - width);
    axis.window = [from, from + width];
    if (axis.pending === null) axis.pending = requestAnimationFrame(function () { apply(axis); });
  }

  function apply(axis) {
    axis.pending = null;
    axis.applying = true;
    for (const plot of axis.plots) {
      const now = plot.graph.xAxisRange();
      if (now[0] !== axis.window[0] || now[1] !== axis.window[1]) {
        plot.graph.updateOptions({dateWindow: axis.window.slice()});
      }
      mark_zoom(plot);
    }
    axis.applying = false;
    for (const scatter of axis.scatters) scatter.draw();
    point(axis, axis.cursor, null);
  }

  function mark_zoom(plot) {
    plot.figure.classList.toggle('zoomed', is_zoomed(plot.axis) || plot.is_stretched());
  }

  function reset(axis) {
    axis.applying = true;
    for (const plot of axis.plots) plot.reset();
    axis.applying = false;
    axis.window = axis.full.slice();
    apply(axis);
  }

  function zoom_about(axis, t, factor) {
    const share = (t - axis.window[0]) / (axis.window[1] - axis.window[0]);
    const width = (axis.window[1] - axis.window[0]) * factor;
    show(axis, t - share * width, t + (1 - share) * width);
  }

  function pan(axis, seconds) { show(axis, axis.window[0] + seconds, axis.window[1] + seconds); }

  // Moves the shared cursor to time t (null: away). `source` has marked its own points already.
  function point(axis, t, source) {
    axis.cursor = t;
    for (const plot of axis.plots) plot.point(t, plot === source);
    for (const scatter of axis.scatters) scatter.point(t);
  }

  // ---- time plots ----

  function escaped(text) {
    const span = document.createElement('span');
    span.textContent = text;
    return span.innerHTML;
  }

  function look() {
    return {
      gridLineColor: css('--grid'), axisLineColor: css('--axis'),
      rangeSelectorPlotFillColor: css('--selector'), rangeSelectorPlotFillGradientColor: css('--selector'),
      rangeSelectorPlotStrokeColor: css('--selector-line'), rangeSelectorBackgroundStrokeColor: css('--rule'),
      rangeSelectorForegroundStrokeColor: css('--axis')
    };
  }

  function time_plot(spec, figure) {
    const axis = axes[spec.axis];
    const chart = figure.querySelector('.chart');
    const strip = figure.querySelector('.bands');
    const when = figure.querySelector('.when');
    const readings = figure.querySelectorAll('.value');
    const plot = {figure: figure, axis: axis, graph: null};

    // Columns of the table that dygraphs draws: every series, and the edges of its area.
    const columns = [];
    const options = {};
    const colors = function () { return columns.map(function (c) { return themed(c.series.color); }); };
    spec.series.forEach(function (series, i) {
      series.columns = [];
      for (const part of ['lower', 'upper', 'y']) {
        if (!series[part]) continue;
        const name = 's' + i + part;
        series.columns.push(columns.length);
        series[part + '_column'] = columns.length + 1;
        columns.push({name: name, series: series, values: series[part]});
        const points = series.style === 'points';
        options[name] = part === 'y' ? {
          strokeWidth: points ? 0 : 1.3,
          strokePattern: series.style === 'dashed' ? [6, 4] : null,
          drawPoints: points, pointSize: 1.6, highlightCircleSize: 3.5,
          stepPlot: series.style === 'steps', showInRangeSelector: i === 0
        } : {strokeWidth: 0, highlightCircleSize: 0, drawPoints: false, showInRangeSelector: false};
      }
    });
    if (columns.length === 0) {
      columns.push({name: 'none', series: {color: '#000000', columns: []}, values: []});
    }
    const times = data.times[spec.time].slice();
    const rows = times.map(function (t, row) {
      return [t].concat(columns.map(function (c) { return c.values.length ? c.values[row] : null; }));
    });
    // All plots of an axis reach over its whole range, so that none of them limits zoom and pan.
    const nothing = columns.map(function () { return null; });
    if (!times.length || times[0] > axis.full[0]) {
      times.unshift(axis.full[0]);
      rows.unshift([axis.full[0]].concat(nothing));
    }
    if (times[times.length - 1] < axis.full[1]) {
      times.push(axis.full[1]);
      rows.push([axis.full[1]].concat(nothing));
    }
    const lead = rows.length && times[0] < data.times[spec.time][0] ? 1 : 0;  // rows before the data's own
    let resting = -1;  // the row that is read out while nothing is pointed at; -1: none
    const has_data = spec.series.some(function (s) { return s.y.some(function (y) { return y !== null; }); });

    function draw_under(context, area, graph) {
      context.save();
      context.beginPath();
      context.rect(area.x, area.y, area.w, area.h);
      context.clip();
      for (const band of spec.bands) {
        const left = graph.toDomXCoord(band.from), right = graph.toDomXCoord(band.to);
        context.fillStyle = 'rgba(' + tints[band.tint % tints.length] + ',.12)';
        context.fillRect(left, area.y, Math.max(right - left, 1), area.h);
      }
      spec.series.forEach(function (series) {
        if (series.lower && graph.visibility()[series.columns[0]]) draw_area(context, graph, series);
      });
      const range = graph.yAxisRange();
      if (range[0] < 0 && range[1] > 0) {
        const y = Math.round(graph.toDomYCoord(0)) - .5;
        context.strokeStyle = css('--zero');
        context.lineWidth = 1;
        context.beginPath();
        context.moveTo(area.x, y);
        context.lineTo(area.x + area.w, y);
        context.stroke();
      }
      context.restore();
    }

    function draw_area(context, graph, series) {
      const window = graph.xAxisRange();
      const first = Math.max(0, nearest(times, window[0]) - 1);
      const last = Math.min(rows.length - 1, nearest(times, window[1]) + 1);
      context.fillStyle = themed(series.color);
      context.globalAlpha = .25;
      let start = first;
      for (let row = first; row <= last + 1; ++row) {
        const gap = row > last || rows[row][series.lower_column] === null || rows[row][series.upper_column] === null;
        if (!gap) continue;
        if (row - start > 1) {
          context.beginPath();
          for (let r = start; r < row; ++r) {
            context.lineTo(graph.toDomXCoord(times[r]), graph.toDomYCoord(rows[r][series.upper_column]));
          }
          for (let r = row - 1; r >= start; --r) {
            context.lineTo(graph.toDomXCoord(times[r]), graph.toDomYCoord(rows[r][series.lower_column]));
          }
          context.fill();
        }
        start = row + 1;
      }
      context.globalAlpha = 1;
    }

    // Names of bands stand above the plot area, in lanes where bands overlap, and use the room up to the next name.
    function name_bands(graph) {
      if (!strip) return;
      const area = graph.getArea();
      strip.textContent = '';
      spec.bands.forEach(function (band) {
        if (band.label === '' || band.to < axis.window[0] || band.from > axis.window[1]) return;
        const left = Math.max(graph.toDomXCoord(band.from), area.x);
        let right = area.x + area.w;
        for (const other of spec.bands) {
          if (other.lane === band.lane && other !== band && other.from >= band.from && other.label !== '') {
            right = Math.min(right, graph.toDomXCoord(other.from));
          }
        }
        if (right - left < 14) return;
        const name = document.createElement('span');
        name.textContent = band.label;
        name.style.left = left + 'px';
        name.style.top = 16 * band.lane + 'px';
        name.style.maxWidth = right - left - 3 + 'px';
        name.style.borderLeftColor = 'rgba(' + tints[band.tint % tints.length] + ',.9)';
        strip.appendChild(name);
      });
    }

    function drawn(graph, initial) {
      if (initial) plot.graph = graph;
      name_bands(graph);
      if (axis.applying) return;
      const range = graph.xAxisRange();
      if (range[0] !== axis.window[0] || range[1] !== axis.window[1]) show(axis, range[0], range[1]);
      if (!initial) mark_zoom(plot);
    }

    plot.point = function (t, marked) {
      const graph = plot.graph;
      const inside = t !== null && t >= axis.window[0] && t <= axis.window[1];
      const row = t === null ? resting : nearest(times, t);
      cursor.style.display = inside ? 'block' : 'none';
      if (inside) {
        const area = graph.getArea();
        cursor.style.left = Math.round(graph.toDomXCoord(t)) + 'px';
        cursor.style.top = area.y + 'px';
        cursor.style.height = area.h + 'px';
      }
      if (!marked) {
        if (inside) graph.setSelection(row); else graph.clearSelection();
      }
      when.textContent = t === null ? '' : 't\u2009=\u2009' + number(t, axis.decimals) + '\u2009s';
      spec.series.forEach(function (series, i) {
        readings[i].textContent = row < 0 ? '' : number(rows[row][series.y_column], series.digits);
      });
      plot.row = row;
    };

    // A range of values that the report fixes is where zooming starts and ends.
    let home = null;
    plot.is_stretched = function () {
      if (!spec.range) return plot.graph.isZoomed('y');
      const range = plot.graph.yAxisRange();
      return home !== null && (range[0] !== home[0] || range[1] !== home[1]);
    };
    plot.reset = function () {
      plot.graph.resetZoom();
      if (spec.range) plot.graph.updateOptions({valueRange: spec.range.slice()});
    };

    const model = Object.assign({}, Dygraph.defaultInteractionModel);
    model.mousedown = function (event, graph, context) {
      if (event.button === 2) return;
      focus_by_mouse(chart);
      if (!event.shiftKey && !event.altKey) return Dygraph.defaultInteractionModel.mousedown(event, graph, context);
      event.preventDefault();
      const start = axis.window.slice();
      const seconds_per_pixel = (start[1] - start[0]) / graph.getArea().w;
      const x = event.clientX;
      chart.style.cursor = 'grabbing';
      const move = function (e) {
        const seconds = (x - e.clientX) * seconds_per_pixel;
        show(axis, start[0] + seconds, start[1] + seconds);
      };
      const up = function () {
        chart.style.cursor = '';
        document.removeEventListener('mousemove', move);
        document.removeEventListener('mouseup', up);
      };
      document.addEventListener('mousemove', move);
      document.addEventListener('mouseup', up);
    };
    model.dblclick = function (event, graph, context) {
      if (context.cancelNextDblclick) context.cancelNextDblclick = false; else reset(axis);
    };
    // One finger scrolls the page; two zoom and pan the plot.
    let pinching = false;
    model.touchstart = function (event, graph, context) {
      pinching = event.touches.length > 1;
      if (pinching) Dygraph.defaultInteractionModel.touchstart(event, graph, context);
    };
    model.touchmove = function (event, graph, context) {
      if (!pinching) return;
      event.preventDefault();
      context.touchDirections.y = false;
      Dygraph.defaultInteractionModel.touchmove(event, graph, context);
    };
    model.touchend = function (event) { pinching = pinching && event.touches.length > 1; };

    const base = {
      labels: ['t'].concat(columns.map(function (c) { return c.name; })),
      colors: colors(), series: options, legend: 'never', ylabel: escaped(spec.y_label), yLabelWidth: 17,
      dateWindow: axis.full.slice(), valueRange: spec.range || null, yRangePad: 8, xRangePad: 0, rightGap: 8,
      axisLabelFontSize: 12, axisLineWidth: 1, gridLineWidth: 1, highlightCircleSize: 3.5,
      axes: {
        x: {ticker: ticker(80, '\u2009s'), axisLabelWidth: 76, drawGrid: true},
        y: {ticker: ticker(27, ''), axisLabelWidth: 52, drawGrid: true}
      },
      underlayCallback: draw_under, drawCallback: drawn, interactionModel: model,
      highlightCallback: function (event, t) { if (!axis.applying) point(axis, t, plot); },
      unhighlightCallback: function () { if (!axis.applying) point(axis, null, plot); },
      showRangeSelector: spec.selector, rangeSelectorHeight: 34, rangeSelectorPlotLineWidth: 1, panEdgeFraction: 1e-4
    };
    const cursor = document.createElement('div');
    cursor.className = 'cursor';
    plot.graph = new Dygraph(chart, rows, Object.assign(base, look()));
    chart.dygraph = plot.graph;
    home = plot.graph.yAxisRange();
    chart.appendChild(cursor);
    const note = document.createElement('div');
    if (!has_data) {
      note.className = 'empty';
      note.textContent = 'no data';
      note.style.left = '50%';
      note.style.top = '35%';
      chart.appendChild(note);
    }
    axis.plots.push(plot);

    // Every slider at a share from 0 to 1: a parabola through the values at 0, a half and 1, and the sum of what all do.
    plot.slide = function (shares) {
      const moving = spec.series.filter(function (series) { return series.moves; });
      if (!moving.length) return;
      const names = figure.querySelectorAll('.legend .name');
      spec.series.forEach(function (series, i) {
        const moved = series.moves && series.moves.some(function (move) { return shares[move.slider] !== 1; });
        names[i].textContent = series.name + (moved ? ', sliders moved' : '');
      });
      for (const series of moving) {
        series.y.forEach(function (y, k) {
          if (y === null) return;
          for (const move of series.moves) {
            const s = shares[move.slider];
            y += move.low[k] * (1 - s) * (1 - 2 * s) + move.half_way[k] * 4 * s * (1 - s);
          }
          rows[k + lead][series.y_column] = y;
        });
      }
      axis.applying = true;
      plot.graph.updateOptions({file: rows});
      axis.applying = false;
      plot.point(axis.cursor, false);
    };

    // For a page that goes on (live.js). The first and the last row hold the range open, and stay.
    chart.plot = plot;
    plot.begin = function (full) {
      axis.full = full.slice();
      axis.window = full.slice();
      resting = -1;
      times.length = rows.length = 0;
      for (const t of full) {
        times.push(t);
        rows.push([t].concat(nothing));
      }
      draw_anew();
    };
    // Rows of time and the values of the columns, later than those that are there. What is zoomed to stays.
    plot.extend = function (more) {
      if (more.length === 0) return;
      note.remove();
      const zoomed = is_zoomed(axis);
      const end = Math.max(times.pop(), more[more.length - 1][0]);
      rows.pop();
      for (const row of more) {
        times.push(row[0]);
        rows.push(row);
      }
      resting = rows.length - 1;
      times.push(end);
      rows.push([end].concat(nothing));
      axis.full[1] = Math.max(axis.full[1], end);
      if (!zoomed) axis.window = axis.full.slice();
      draw_anew();
    };
    function draw_anew() {
      axis.applying = true;
      plot.graph.updateOptions({file: rows, dateWindow: axis.window.slice()});
      axis.applying = false;
      plot.point(axis.cursor, false);
    }

    plot.redraw = function () {
      plot.graph.updateOptions(Object.assign({colors: colors(), pixelRatio: printing ? 3 : null}, look()));
      paint_swatches(spec, figure);
    };
    paint_swatches(spec, figure);

    figure.querySelectorAll('.legend input').forEach(function (box, i) {
      // A reloading browser may restore what was ticked.
      const set = function () {
        const shown = {};
        for (const column of spec.series[i].columns) shown[column] = box.checked;
        plot.graph.setVisibility(shown);
      };
      box.addEventListener('change', set);
      if (!box.checked) set();
    });
    figure.querySelector('.reset').addEventListener('click', function () { reset(axis); chart.focus(); });

    chart.addEventListener('wheel', function (event) {
      const sideways = event.shiftKey && event.deltaX === 0 ? event.deltaY : event.deltaX;
      const graph = plot.graph;
      if (event.ctrlKey || event.metaKey) {
        event.preventDefault();
        const x = event.clientX - chart.getBoundingClientRect().left;
        zoom_about(axis, graph.toDataXCoord(x), Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * .004));
      } else if (sideways !== 0 && (event.shiftKey || Math.abs(sideways) > Math.abs(event.deltaY))) {
        event.preventDefault();
        pan(axis, sideways * (axis.window[1] - axis.window[0]) / graph.getArea().w);
      }
    }, {passive: false});

    chart.addEventListener('keydown', function (event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const width = axis.window[1] - axis.window[0];
      const middle = axis.cursor === null ? (axis.window[0] + axis.window[1]) / 2 : axis.cursor;
      const sign = event.key === 'ArrowLeft' ? -1 : 1;
      switch (event.key) {
        case 'ArrowLeft':
        case 'ArrowRight':
          if (event.shiftKey) {
            pan(axis, sign * width / 10);
          } else {
            // One sample a key press, or one pixel where samples lie closer than that.
            let row = Math.min(Math.max(nearest(times, middle) + sign, 0), times.length - 1);
            const pixel = width / plot.graph.getArea().w;
            if (Math.abs(times[row] - middle) < pixel) row = nearest(times, middle + sign * pixel);
            const t = times[row];
            point(axis, t, null);
            if (t < axis.window[0] || t > axis.window[1]) pan(axis, sign * width / 4);
            spoken.textContent = 't ' + number(t, axis.decimals) + ' s; ' + spec.series.map(function (s) {
              return s.name + ' ' + number(rows[row][s.y_column], s.digits);
            }).join('; ');
          }
          break;
        case '+': case '=': zoom_about(axis, middle, .5); break;
        case '-': case '_': zoom_about(axis, middle, 2); break;
        case '0': case 'Escape': reset(axis); break;
        default: return;
      }
      event.preventDefault();
    });
    new ResizeObserver(function () { plot.graph.resize(); }).observe(chart);
    return plot;
  }

  function paint_swatches(spec, figure) {
    figure.querySelectorAll('.legend svg').forEach(function (swatch, i) {
      swatch.style.color = themed(spec.series[i].color);
    });
  }

  // ---- scatter plots ----

  function scatter_plot(spec, figure) {
    const axis = spec.axis === null ? null : axes[spec.axis];
    const chart = figure.querySelector('.chart');
    const boxes = figure.querySelectorAll('.legend input');
    const canvas = document.createElement('canvas');
    const over = document.createElement('canvas');
    const tip = document.createElement('div');
    tip.className = 'tip';
    chart.append(canvas, over, tip);
    const scatter = {};
    let view = null;   // what was zoomed to: {x: [low, high], y: [low, high]}
    let drag = null;   // where a zoom was begun and where it is now, in pixels
    let frame = null;  // the scales of the last drawing

    function shown(i) { return boxes[i].checked; }

    function data_range(key) {
      let low = Infinity, high = -Infinity;
      spec.series.forEach(function (series, i) {
        if (!shown(i)) return;
        for (let k = 0; k < series.x.length; ++k) {
          if (series.x[k] === null || series.y[k] === null) continue;
          low = Math.min(low, series[key][k]);
          high = Math.max(high, series[key][k]);
        }
      });
      if (low > high) return [0, 1];
      const room = high > low ? .04 * (high - low) : (low === 0 ? 1 : .1 * Math.abs(low));
      return [low - room, high + room];
    }

    function prepare(target, width, height) {
      const ratio = printing ? 3 : window.devicePixelRatio || 1;
      target.width = Math.round(width * ratio);
      target.height = Math.round(height * ratio);
      const context = target.getContext('2d');
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      return context;
    }

    function draw() {
      const width = chart.clientWidth, height = chart.clientHeight;
      if (width < 120) return;
      const context = prepare(canvas, width, height);
      const x = view ? view.x : data_range('x'), y = view ? view.y : data_range('y');
      const font = getComputedStyle(chart).fontFamily;
      context.font = '12px ' + font;
      const area = {x: 0, y: 8, w: 0, h: height - 8 - 46};
      const y_ticks = ticks(y[0], y[1], Math.floor(area.h / 30));
      area.x = 30 + Math.ceil(Math.max.apply(null, y_ticks.map(function (tick) {
        return context.measureText(tick.label).width;
      })));
      area.w = width - area.x - 12;
      frame = {area: area, x: x, y: y,
               px: function (v) { return area.x + (v - x[0]) / (x[1] - x[0]) * area.w; },
               py: function (v) { return area.y + area.h - (v - y[0]) / (y[1] - y[0]) * area.h; }};
      context.lineWidth = 1;
      context.textBaseline = 'middle';
      context.textAlign = 'center';
      for (const tick of ticks(x[0], x[1], Math.floor(area.w / 62))) {
        const at = Math.round(frame.px(tick.v)) + .5;
        context.strokeStyle = css('--grid');
        line(context, at, area.y, at, area.y + area.h);
        context.fillStyle = css('--soft');
        context.fillText(tick.label, at, area.y + area.h + 13);
      }
      context.textAlign = 'right';
      for (const tick of y_ticks) {
        const at = Math.round(frame.py(tick.v)) - .5;
        context.strokeStyle = css('--grid');
        line(context, area.x, at, area.x + area.w, at);
        context.fillStyle = css('--soft');
        context.fillText(tick.label, area.x - 6, at);
      }
      context.save();
      context.beginPath();
      context.rect(area.x, area.y, area.w, area.h);
      context.clip();
      context.strokeStyle = css('--zero');
      if (x[0] < 0 && x[1] > 0) {
        const at = Math.round(frame.px(0)) + .5;
        line(context, at, area.y, at, area.y + area.h);
      }
      if (y[0] < 0 && y[1] > 0) {
        const at = Math.round(frame.py(0)) - .5;
        line(context, area.x, at, area.x + area.w, at);
      }
      spec.series.forEach(function (series, i) { if (shown(i)) draw_series(context, series); });
      context.restore();
      context.strokeStyle = css('--axis');
      line(context, area.x + .5, area.y, area.x + .5, area.y + area.h);
      line(context, area.x, area.y + area.h - .5, area.x + area.w, area.y + area.h - .5);
      context.fillStyle = css('--ink');
      context.font = '12.5px ' + font;
      context.textAlign = 'center';
      context.fillText(spec.x_label, area.x + area.w / 2, height - 9, area.w);
      context.save();
      context.translate(9, area.y + area.h / 2);
      context.rotate(-Math.PI / 2);
      context.fillText(spec.y_label, 0, 0, area.h);
      context.restore();
      figure.classList.toggle('zoomed', view !== null);
      prepare(over, width, height);
      if (axis) scatter.point(axis.cursor);
    }

    function line(context, x0, y0, x1, y1) {
      context.beginPath();
      context.moveTo(x0, y0);
      context.lineTo(x1, y1);
      context.stroke();
    }

    // Where the time plots show a part of the time, the rest recedes.
    function draw_series(context, series) {
      context.strokeStyle = context.fillStyle = themed(series.color);
      const part = axis && series.t && is_zoomed(axis) ? axis.window : null;
      const is_in = function (k) { return !part || (series.t[k] >= part[0] && series.t[k] <= part[1]); };
      const passes = part ? [false, true] : [true];
      for (const inside of passes) {
        if (series.style === 'points') {
          context.globalAlpha = inside ? (series.x.length > 400 ? .55 : .85) : .1;
          const radius = series.x.length > 2000 ? 1.5 : 2;
          for (let k = 0; k < series.x.length; ++k) {
            if (series.x[k] === null || series.y[k] === null || is_in(k) !== inside) continue;
            const px = frame.px(series.x[k]), py = frame.py(series.y[k]);
            if (series.x.length > 6000) {
              context.fillRect(px - radius, py - radius, 2 * radius, 2 * radius);
            } else {
              context.beginPath();
              context.arc(px, py, radius, 0, 2 * Math.PI);
              context.fill();
            }
          }
        } else {
          context.globalAlpha = inside ? 1 : .15;
          context.lineWidth = 1.3;
          context.lineJoin = 'round';
          context.setLineDash(series.style === 'dashed' ? [6, 4] : []);
          context.beginPath();
          let open = false;
          for (let k = 0; k < series.x.length; ++k) {
            const here = series.x[k] !== null && series.y[k] !== null && (!inside || is_in(k));
            if (here) {
              const px = frame.px(series.x[k]), py = frame.py(series.y[k]);
              if (open) context.lineTo(px, py); else context.moveTo(px, py);
            }
            open = here;
          }
          context.stroke();
          context.setLineDash([]);
          if (inside && series.arrows) draw_arrows(context, series, is_in);
        }
      }
      context.globalAlpha = 1;
    }

    // Four arrows, evenly spaced along the path; each looks some pixels back for its direction, past the noise.
    function draw_arrows(context, series, is_in) {
      const path = [];
      let length = 0;
      for (let k = 0; k < series.x.length; ++k) {
        if (series.x[k] === null || series.y[k] === null || !is_in(k)) continue;
        const p = [frame.px(series.x[k]), frame.py(series.y[k]), 0];
        if (path.length) {
          const q = path[path.length - 1];
          const step = Math.hypot(p[0] - q[0], p[1] - q[1]);
          if (step < 4) continue;
          length += step;
        }
        p[2] = length;
        path.push(p);
      }
      let next = 1;
      for (let k = 4; k < path.length && next <= 4; ++k) {
        if (path[k][2] < length * (next - .5) / 4) continue;
        ++next;
        const p = path[k], q = path[k - 4];
        const turn = Math.atan2(p[1] - q[1], p[0] - q[0]);
        context.save();
        context.translate(p[0], p[1]);
        context.rotate(turn);
        context.beginPath();
        context.moveTo(5, 0);
        context.lineTo(-5, 4.2);
        context.lineTo(-5, -4.2);
        context.fill();
        context.restore();
      }
    }

    function ring(context, series, k) {
      const area = frame.area, px = frame.px(series.x[k]), py = frame.py(series.y[k]);
      if (px < area.x || px > area.x + area.w || py < area.y || py > area.y + area.h) return;
      context.beginPath();
      context.arc(px, py, 4.5, 0, 2 * Math.PI);
      context.fillStyle = themed(series.color);
      context.fill();
      context.strokeStyle = css('--paper');
      context.lineWidth = 1.5;
      context.stroke();
    }

    scatter.point = function (t) {
      if (!frame || drag) return;
      const context = prepare(over, chart.clientWidth, chart.clientHeight);
      if (t === null) return;
      spec.series.forEach(function (series, i) {
        if (!series.t || !shown(i)) return;
        const k = nearest(series.t, t);
        const slack = (series.t[series.t.length - 1] - series.t[0]) / series.t.length;
        if (k < 0 || Math.abs(series.t[k] - t) > slack || series.x[k] === null || series.y[k] === null) return;
        ring(context, series, k);
      });
    };

    function position(event) {
      const box = chart.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    }

    function hover(at) {
      let best = null, distance = 20 * 20;
      spec.series.forEach(function (series, i) {
        if (!shown(i)) return;
        for (let k = 0; k < series.x.length; ++k) {
          if (series.x[k] === null || series.y[k] === null) continue;
          const dx = frame.px(series.x[k]) - at[0], dy = frame.py(series.y[k]) - at[1];
          if (dx * dx + dy * dy < distance) {
            distance = dx * dx + dy * dy;
            best = {series: series, k: k};
          }
        }
      });
      tip.style.display = best ? 'block' : 'none';
      if (!best) {
        if (axis && axis.cursor !== null) point(axis, null, null);
        prepare(over, chart.clientWidth, chart.clientHeight);
        return;
      }
      const series = best.series, k = best.k;
      tip.textContent = '';
      const add = function (text, bold) {
        const row = document.createElement('div');
        row.textContent = text;
        if (bold) row.style.fontWeight = 600;
        tip.appendChild(row);
      };
      add(series.name, true);
      add(spec.x_label + ': ' + number(series.x[k], series.x_digits));
      add(spec.y_label + ': ' + number(series.y[k], series.y_digits));
      if (series.t) add('t\u2009=\u2009' + number(series.t[k], axis.decimals) + '\u2009s');
      const px = frame.px(series.x[k]), py = frame.py(series.y[k]);
      const left = px + 14 + tip.offsetWidth > chart.clientWidth ? px - 14 - tip.offsetWidth : px + 14;
      tip.style.left = Math.max(0, left) + 'px';
      tip.style.top = Math.max(0, Math.min(py - tip.offsetHeight / 2, chart.clientHeight - tip.offsetHeight)) + 'px';
      if (series.t) {
        point(axis, series.t[k], null);
      } else {
        ring(prepare(over, chart.clientWidth, chart.clientHeight), series, k);
      }
    }

    function inverse(at) {
      const area = frame.area;
      return [frame.x[0] + (Math.min(Math.max(at[0], area.x), area.x + area.w) - area.x) / area.w *
                  (frame.x[1] - frame.x[0]),
              frame.y[0] + (area.y + area.h - Math.min(Math.max(at[1], area.y), area.y + area.h)) / area.h *
                  (frame.y[1] - frame.y[0])];
    }

    over.addEventListener('mousemove', function (event) {
      if (!drag && frame && !event.buttons) hover(position(event));
    });
    over.addEventListener('mouseleave', function () {
      tip.style.display = 'none';
      if (drag) return;
      if (axis) point(axis, null, null); else prepare(over, chart.clientWidth, chart.clientHeight);
    });
    over.addEventListener('mousedown', function (event) {
      if (event.button !== 0 || !frame) return;
      event.preventDefault();
      focus_by_mouse(chart);
      tip.style.display = 'none';
      drag = {from: position(event), to: position(event)};
      const move = function (e) {
        drag.to = position(e);
        const context = prepare(over, chart.clientWidth, chart.clientHeight);
        context.fillStyle = css('--grid');
        context.fillRect(drag.from[0], drag.from[1], drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]);
      };
      const up = function () {
        document.removeEventListener('mousemove', move);
        document.removeEventListener('mouseup', up);
        const a = inverse(drag.from), b = inverse(drag.to);
        const far = Math.abs(drag.to[0] - drag.from[0]) > 8 && Math.abs(drag.to[1] - drag.from[1]) > 8;
        drag = null;
        if (far) {
          view = {x: [Math.min(a[0], b[0]), Math.max(a[0], b[0])], y: [Math.min(a[1], b[1]), Math.max(a[1], b[1])]};
        }
        draw();
      };
      document.addEventListener('mousemove', move);
      document.addEventListener('mouseup', up);
    });
    function unzoom() { view = null; draw(); }
    over.addEventListener('dblclick', unzoom);
    figure.querySelector('.reset').addEventListener('click', function () { unzoom(); chart.focus(); });
    chart.addEventListener('keydown', function (event) {
      if (event.key === '0' || event.key === 'Escape') unzoom();
    });
    boxes.forEach(function (box) { box.addEventListener('change', draw); });
    scatter.draw = draw;
    scatter.redraw = function () { paint_swatches(spec, figure); draw(); };
    chart.view = function () { return frame && {x: frame.x, y: frame.y}; };
    if (axis) axis.scatters.push(scatter);
    paint_swatches(spec, figure);
    new ResizeObserver(draw).observe(chart);
    draw();
    return scatter;
  }

  // ---- the page ----

  const plots = data.plots.map(function (spec, i) {
    const figure = document.getElementById('plot-' + i);
    return spec.kind === 'time' ? time_plot(spec, figure) : scatter_plot(spec, figure);
  });
  const sliders = Array.from(document.querySelectorAll('.slider input'));
  function slide(shares) { for (const plot of plots) if (plot.slide) plot.slide(shares); }
  function slide_as_set() { slide(sliders.map(function (one) { return Number(one.value); })); }
  for (const slider of sliders) {
    slider.addEventListener('input', function () {
      const share = Number(slider.value);
      const words = share === 0 ? slider.dataset.low : share === 1 ? slider.dataset.high : Math.round(100 * share) + '\u2009%';
      slider.setAttribute('aria-valuetext', words);
      slider.parentNode.querySelector('output').textContent = words;
      slide_as_set();
    });
  }
  function redraw() { for (const plot of plots) plot.redraw(); }
  dark.addEventListener('change', redraw);

  // On paper the plots are drawn anew: at the paper's width, in light colours, finely enough for print.
  function print(on) {
    printing = on;
    root.classList.toggle('printing', on);
    for (const plot of plots) if (plot.graph) plot.graph.resize();
    if (on) slide(sliders.map(function () { return 1; })); else slide_as_set();  // no slider says on paper what was moved
    redraw();
  }
  addEventListener('beforeprint', function () { print(true); });
  addEventListener('afterprint', function () { print(false); });
})();
