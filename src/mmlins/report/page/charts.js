// SPDX-License-Identifier: MIT
// Lines over time, with axes, limits, the stretches that the IMU carried, and a readout.

const margin = {left: 62, right: 12, top: 8, bottom: 22};

function timeScale(width) {
  const room = width - margin.left - margin.right;
  return {
    at: (t) => margin.left + room * t / duration,
    to: (x) => duration * (x - margin.left) / room,
    room,
  };
}

function timeAxis(picture, scale, bottom, top) {
  const marks = timeTicks(duration, scale.room / 74);
  for (const t of marks.values) {
    const x = scale.at(t);
    if (top !== null) picture.append(svg('line', {class: 'grid', x1: x, x2: x, y1: top, y2: bottom}));
    picture.append(svg('text', {x, y: bottom + 15, 'text-anchor': t === 0 ? 'start' : x > scale.at(duration) - 24 ? 'end' : 'middle'},
      axisText(t, marks)));
  }
  picture.append(svg('line', {class: 'axis', x1: margin.left, x2: scale.at(duration), y1: bottom, y2: bottom}));
}

/** Moves the common moment while the pointer is over a drawing whose x is time. */
function followPointer(picture, scale) {
  const move = (event) => {
    const box = picture.getBoundingClientRect();
    setCursor(scale.to((event.clientX - box.left) * picture.viewBox.baseVal.width / box.width));
  };
  picture.addEventListener('pointermove', move);
  picture.addEventListener('pointerdown', move);
  picture.addEventListener('pointerleave', (event) => { if (event.pointerType === 'mouse') setCursor(null); });
}

function extent(series, log) {
  let low = Infinity;
  let high = -Infinity;
  for (const s of series) {
    for (const y of s.curve.y) {
      if (y === null || y >= infinite || (log && y <= 0)) continue;
      low = Math.min(low, y * s.factor);
      high = Math.max(high, y * s.factor);
    }
  }
  return low > high ? null : [low, high];
}

function logScale(found, limits, bottom) {
  const all = [...found, ...limits.map((limit) => limit.value)];
  const from = Math.log10(Math.min(...all)) - 0.08;
  const to = Math.max(Math.log10(Math.max(...all)) + 0.08, from + 1);
  const values = [];
  for (let k = Math.ceil(from); k <= Math.floor(to); ++k) values.push(10 ** k);
  const share = (y) => Math.min(1, Math.max(0, (Math.log10(Math.max(y, 1e-12)) - from) / (to - from)));
  return {at: (y) => bottom - (bottom - margin.top) * share(y), values, text: (y) => significant(y, 1), bottom};
}

function valueScale(options, height) {
  const bottom = height - margin.bottom;
  const limits = options.limits || [];
  if (options.log) return logScale(extent(options.series, true) || [0.1, 1], limits, bottom);
  const found = extent(options.series, false) || [0, 1];
  // A limit that is far away would flatten what there is to see.
  const near = limits.map((limit) => limit.value).filter((value) => value < 3 * found[1]);
  const low = Math.min(0, found[0]);
  const most = Math.max(found[1], ...near);
  const high = options.high !== undefined ? options.high : most + 0.06 * (most - low || 1);
  const marks = ticks(low, high, (bottom - margin.top) / 34);
  const share = (y) => Math.min(1, Math.max(0, (y - low) / (high - low)));
  const text = (y) => (high >= 10000 ? `${fixed(y / 1000, 0)}k` : fixed(y, marks.decimals));
  return {at: (y) => bottom - (bottom - margin.top) * share(y), values: marks.values, text, bottom, limits: near};
}

function linePath(curve, factor, x, y) {
  let path = '';
  let down = false;
  for (let i = 0; i < curve.t.length; ++i) {
    const value = curve.y[i];
    if (value === null) { down = false; continue; }
    const alone = !down && (i + 1 >= curve.t.length || curve.y[i + 1] === null);
    path += `${down ? 'L' : 'M'}${x(curve.t[i]).toFixed(1)} ${y(value * factor).toFixed(1)}${alone ? 'h0.1' : ''}`;
    down = true;
  }
  return path;
}

function key(colour, label, value, dash) {
  return el('span', {class: 'key'},
    svg('svg', {viewBox: '0 0 22 10', 'aria-hidden': 'true'},
      svg('line', {x1: 1, x2: 21, y1: 5, y2: 5, style: `stroke:${colour}`, 'stroke-width': 2.5, 'stroke-dasharray': dash || 'none'})),
    el('span', {}, label, value ? ' ' : '', value ? el('b', {}, value) : null));
}

/**
 * @param options  title, unit, series [{label, curve, colour, factor}], log, limits [{value, label}], high, height
 */
function lineChart(container, options) {
  for (const s of options.series) s.factor = s.factor || 1;
  const legend = el('div', {class: 'legend'});
  const plot = el('div', {class: 'plot'});
  container.append(el('div', {class: 'chart'}, el('div', {class: options.series.length > 1 ? 'head several' : 'head'}, el('h3', {}, options.unit ? `${options.title} [${options.unit}]` : options.title), legend), plot));
  const alone = options.series.length === 1;
  let scale = null;
  let mark = null;
  drawing(() => {
    const wide = container.classList.contains('wide') || window.innerWidth <= 760;
    const width = widthOf(plot, wide ? 1 : 0.48);
    const height = options.height || 150;
    const y = valueScale(options, height);
    scale = timeScale(width);
    const picture = svg('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${options.title} over time`});
    for (const c of carried) {
      picture.append(svg('rect', {class: 'band', x: scale.at(c.from), width: Math.max(1, scale.at(c.to) - scale.at(c.from)), y: margin.top, height: y.bottom - margin.top}));
    }
    for (const value of y.values) {
      picture.append(svg('line', {class: 'grid', x1: margin.left, x2: width - margin.right, y1: y.at(value), y2: y.at(value)}),
        svg('text', {x: margin.left - 6, y: y.at(value) + 4, 'text-anchor': 'end'}, y.text(value)));
    }
    timeAxis(picture, scale, y.bottom, null);
    for (const limit of options.limits || []) {
      if (y.limits && !y.limits.includes(limit.value)) continue;
      picture.append(svg('line', {class: 'limit', x1: margin.left, x2: width - margin.right, y1: y.at(limit.value), y2: y.at(limit.value)}),
        svg('text', {x: width - margin.right, y: y.at(limit.value) - 4, 'text-anchor': 'end'}, limit.label));
    }
    for (const s of [...options.series].reverse()) {
      picture.append(svg('path', {class: 'line', d: linePath(s.curve, s.factor, scale.at, y.at), style: `stroke:${s.colour}`}));
    }
    mark = svg('line', {class: 'cursor', y1: margin.top, y2: y.bottom, visibility: 'hidden'});
    picture.append(mark);
    followPointer(picture, scale);
    plot.replaceChildren(picture);
  });
  cursorFollowers.push((t) => {
    legend.replaceChildren(...options.series.map((s) => (alone && t === null ? '' : key(s.colour, alone ? '' : s.label, t === null ? '' : readout(s, t)))));
    if (t === null) { mark.setAttribute('visibility', 'hidden'); return; }
    mark.setAttribute('visibility', 'visible');
    mark.setAttribute('x1', scale.at(t));
    mark.setAttribute('x2', scale.at(t));
  });
}

function readout(s, t) {
  if (s.curve.t.length === 0) return '\u2013';
  let i = indexAt(s.curve.t, t);
  if (i + 1 < s.curve.t.length && s.curve.t[i + 1] - t < t - s.curve.t[i]) ++i;
  const value = s.curve.y[i];
  return value === null ? '\u2013' : significant(value >= infinite ? infinite : value * s.factor);
}

/** Bars of equal steps from 0 on. */
function histogramChart(container, histogram, marks) {
  drawing(() => {
    const width = widthOf(container, 0.46);
    const height = 220;
    const bottom = height - 36;
    const room = width - margin.left - margin.right;
    const most = Math.max(1, ...histogram.counts);
    const reach = histogram.counts.length * histogram.step_ms;
    const x = (ms) => margin.left + room * Math.min(ms, reach) / reach;
    const y = (count) => bottom - (bottom - 24) * count / most;
    const picture = svg('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'Histogram of the time of work per scan'});
    for (const value of ticks(0, most, 4).values.filter(Number.isInteger)) {
      picture.append(svg('line', {class: 'grid', x1: margin.left, x2: width - margin.right, y1: y(value), y2: y(value)}),
        svg('text', {x: margin.left - 6, y: y(value) + 4, 'text-anchor': 'end'}, grouped(value)));
    }
    histogram.counts.forEach((count, i) => {
      const left = x(i * histogram.step_ms);
      const bar = svg('rect', {x: left + 0.5, width: Math.max(1, room / histogram.counts.length - 1), y: y(count), height: bottom - y(count), style: 'fill:var(--c3)'});
      const last = i === histogram.counts.length - 1;
      bar.append(svg('title', {}, `${last ? 'from ' : ''}${significant(i * histogram.step_ms)}${last ? ' on' : ` to ${significant((i + 1) * histogram.step_ms)}`} ms: ${plural(count, 'scan')}`));
      picture.append(bar);
    });
    const axis = ticks(0, reach, room / 60);
    for (const value of axis.values) picture.append(svg('text', {x: x(value), y: bottom + 15, 'text-anchor': 'middle'}, fixed(value, axis.decimals)));
    picture.append(svg('line', {class: 'axis', x1: margin.left, x2: width - margin.right, y1: bottom, y2: bottom}),
      svg('text', {x: width - margin.right, y: bottom + 31, 'text-anchor': 'end'}, 'ms of work per scan'),
      svg('text', {x: margin.left, y: 12}, 'scans'));
    marks.forEach((mark, i) => {
      picture.append(svg('line', {class: 'limit', x1: x(mark.value), x2: x(mark.value), y1: 18 + 12 * i, y2: bottom}),
        svg('text', {class: 'strong', x: x(mark.value) + (x(mark.value) > width - 110 ? -4 : 4), y: 24 + 12 * i, 'text-anchor': x(mark.value) > width - 110 ? 'end' : 'start'}, mark.label));
    });
    container.replaceChildren(picture);
  });
}
