// SPDX-License-Identifier: MIT
'use strict';
// The data, and small helpers: elements, numbers in words, the moment under the pointer.

const data = JSON.parse(document.getElementById('data').textContent);
const figures = data.figures;
const duration = Math.max(figures.duration_s, 1e-6);
const infinite = 1e9;
const placedStates = new Set([0, 1, 2]);  // INITIALIZING, TRACKING, DEGRADED

function byId(id) { return document.getElementById(id); }

function append(node, children) {
  for (const child of children.flat()) {
    if (child !== null && child !== undefined && child !== false) node.append(child);
  }
  return node;
}

function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
  return append(node, children);
}

function svg(tag, attributes, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
  return append(node, children);
}

// Numbers

const minus = '\u2212';

/** With so many significant digits, and no exponent where people would not write one. */
function significant(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return '\u2013';
  if (Math.abs(value) >= infinite) return value < 0 ? minus + '\u221e' : '\u221e';
  if (value === 0) return '0';
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size < -4 || size > 6) return value.toExponential(digits - 1).replace('-', minus).replace('e+', 'e');
  return value.toFixed(Math.max(0, digits - 1 - size)).replace('-', minus);
}

function fixed(value, decimals) {
  return value === null || value === undefined ? '\u2013' : value.toFixed(decimals).replace('-', minus);
}

function grouped(count) { return String(Math.round(count)).replace(/\B(?=(\d{3})+(?!\d))/g, '\u202f'); }

function plural(count, word) { return `${grouped(count)} ${word}${count === 1 ? '' : 's'}`; }

/** A length of time with its unit. */
function timeText(seconds) {
  if (seconds < 120) return `${fixed(seconds, 1)} s`;
  const whole = Math.round(seconds);
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return parts[0] > 0 ? `${parts[0]} h ${String(parts[1]).padStart(2, '0')} min` : `${parts[1]} min ${String(parts[2]).padStart(2, '0')} s`;
}

/** A moment of the recording, as on its axis. */
function momentText(seconds, decimals = 1) {
  if (duration < 180) return `${fixed(seconds, decimals)} s`;
  const rest = seconds % 60;
  return `${Math.floor(seconds / 60)}:${rest.toFixed(decimals).padStart(decimals > 0 ? 3 + decimals : 2, '0')} min`;
}

/** The same beside a tick: as short as it can be. */
function axisText(seconds, marks) {
  if (duration < 180) return momentText(seconds, marks.decimals);
  const whole = marks.values.every((t) => t % 60 === 0);
  return whole ? `${seconds / 60} min` : `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')}`;
}

function lengthText(metres) { return metres >= 10000 ? `${significant(metres / 1000, 4)} km` : `${significant(metres, 3)} m`; }

// Round ticks

function ticks(low, high, count) {
  const least = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(least || 1));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= least * 0.999) || 10 * power;
  const result = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) result.push(k * step);
  return {values: result, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

function timeTicks(length, count) {
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 18000];
  const step = steps.find((s) => s >= length / Math.max(1, count)) || 36000;
  const result = [];
  for (let k = 0; k * step <= length + 1e-9; ++k) result.push(k * step);
  return {values: result, decimals: step < 1 ? 1 : 0};
}

// The recording at a moment

/** Index of the last element of an increasing list that is not larger. */
function indexAt(list, value) {
  let low = 0;
  let high = list.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle; else high = middle;
  }
  return low;
}

const stretches = data.stretches.map(([from, to, state, cause, map, scans]) => ({from, to, state, cause, map, scans}));
const stretchBegins = stretches.map((s) => s.from);
function stretchAt(t) { return stretches[indexAt(stretchBegins, t)]; }

function stateText(stretch) {
  const cause = data.causes[stretch.cause];
  return data.states[stretch.state] + (cause ? `: ${cause}` : '');
}

/** Stretches in which the IMU alone carried the pose, whatever the state is called. */
const carried = [];
for (const s of stretches) {
  if (placedStates.has(s.state)) continue;
  const last = carried[carried.length - 1];
  if (last && Math.abs(last.to - s.from) < 1e-9) {
    last.to = s.to;
    if (s.cause) last.causes.add(data.causes[s.cause]);
  } else {
    carried.push({from: s.from, to: s.to, causes: new Set(s.cause ? [data.causes[s.cause]] : [])});
  }
}

function mapColour(id) { return `var(--m${id % 8})`; }
function stateColour(state) { return `var(--s${state})`; }

// Everything that shows a moment, and everything that must be drawn again when there is more or less room.

const cursorFollowers = [];
let cursorTime = null;
function setCursor(t) {
  cursorTime = t === null ? null : Math.min(duration, Math.max(0, t));
  for (const follow of cursorFollowers) follow(cursorTime);
}

const drawings = [];
function drawing(draw) {
  drawings.push(draw);
  draw();
}
function redraw() {
  for (const draw of drawings) draw();
  setCursor(cursorTime);
}
let printing = false;
/** Room for a drawing [px]; on paper that of a page, since pages are laid out only after everything is drawn. */
function widthOf(node, share = 1) { return printing ? 690 * share : Math.max(240, node.clientWidth); }
