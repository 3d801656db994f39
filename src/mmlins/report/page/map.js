// SPDX-License-Identifier: MIT
// The map from above with the way on it.

const picture = data.picture;
const path = data.path;
const mapView = {highlight: new Set(), colour: data.maps.length > 1 ? 'map' : 'state', zoom: 1, x: 0, y: 0,
  layers: {points: true, height: false, closures: true, truth: true, refused: false}};
const extentX = picture.width * picture.metres_per_pixel;
const extentY = picture.height * picture.metres_per_pixel;
const drawnClosures = data.closures.filter((c) => c.source && c.target);

/** From metres to drawing units of the present view. */
let toView = null;

function pathColour(i) {
  return mapView.colour === 'map' ? mapColour(path.map[i]) : stateColour(path.state[i]);
}

/** Strokes of one colour each; what the IMU carried is a stroke of its own. */
function pathStrokes() {
  const strokes = [];
  let current = null;
  for (let i = 1; i < path.t.length; ++i) {
    const isCarried = !placedStates.has(path.state[i]);
    const colour = pathColour(i);
    if (!current || current.colour !== colour || current.isCarried !== isCarried) {
      current = {colour, isCarried, d: `M${toView.x(path.x[i - 1])} ${toView.y(path.y[i - 1])}`};
      strokes.push(current);
    }
    current.d += `L${toView.x(path.x[i])} ${toView.y(path.y[i])}`;
  }
  return strokes;
}

function positionAt(t) {
  const i = indexAt(path.t, t);
  const j = Math.min(i + 1, path.t.length - 1);
  const share = j > i ? Math.min(1, (t - path.t[i]) / (path.t[j] - path.t[i])) : 0;
  return ['x', 'y', 'z'].map((axis) => path[axis][i] + share * (path[axis][j] - path[axis][i]));
}

function chooseView(width) {
  const mostHeight = printing ? 500 : Math.max(280, Math.min(720, 0.8 * width, 0.86 * window.innerHeight));
  const scale = Math.min(width / extentX, mostHeight / extentY);
  const height = Math.max(200, Math.min(extentY * scale, mostHeight));
  const fit = {left: (width - extentX * scale) / 2, top: (height - extentY * scale) / 2};
  const view = printing ? {zoom: 1, x: 0, y: 0} : mapView;
  const zoomed = scale * view.zoom;
  const left = width / 2 + (fit.left - width / 2) * view.zoom + view.x;
  const top = height / 2 + (fit.top - height / 2) * view.zoom + view.y;
  toView = {
    x: (metres) => +(left + (metres - picture.min_x) * zoomed).toFixed(1),
    y: (metres) => +(top + (picture.max_y - metres) * zoomed).toFixed(1),
    left, top, scale: zoomed, width, height,
  };
}

function mapFilters() {
  // Viridis without its palest end, which would vanish on white.
  const table = {R: '.27 .23 .13 .20 .48', G: '.00 .32 .57 .72 .80', B: '.33 .55 .55 .47 .25'};
  return svg('defs', {},
    svg('filter', {id: 'ink', 'color-interpolation-filters': 'sRGB'}, svg('feFlood', {}), svg('feComposite', {in2: 'SourceAlpha', operator: 'in'})),
    svg('filter', {id: 'height', 'color-interpolation-filters': 'sRGB'}, svg('feComponentTransfer', {},
      ...['R', 'G', 'B'].map((c) => svg(`feFunc${c}`, {type: 'table', tableValues: table[c]})))));
}

function drawPoints(root) {
  if (!mapView.layers.points) return;
  root.append(svg('image', {href: `data:image/png;base64,${picture.png}`, x: toView.left, y: toView.top,
    width: extentX * toView.scale, height: extentY * toView.scale, preserveAspectRatio: 'none',
    filter: mapView.layers.height ? 'url(#height)' : 'url(#ink)', style: `opacity:${mapView.layers.height ? 0.9 : 'var(--points)'}`}));
}

function drawTruth(root) {
  if (!data.truth || !mapView.layers.truth) return;
  const d = data.truth.path.x.map((x, i) => `${i ? 'L' : 'M'}${toView.x(x)} ${toView.y(data.truth.path.y[i])}`).join('');
  root.append(svg('path', {class: 'line', d, style: 'stroke:var(--truth)', 'stroke-width': 1, 'stroke-dasharray': '1 3'}));
}

const closureLook = {
  counts: {colour: 'var(--closure)', dash: 'none', text: 'closure that counts'},
  confirmed: {colour: 'var(--closure)', dash: '1 3', text: 'confirmed, known before'},
  waiting: {colour: 'var(--warning)', dash: '4 3', text: 'verified, waiting for others'},
  rejected: {colour: 'var(--bad)', dash: '4 3', text: 'rejected later'},
  refused: {colour: 'var(--s0)', dash: '1 3', text: 'refused'},
};
const mergeClosures = new Map();
for (const merge of data.merges) {
  for (const id of [...merge.closures, ...merge.enhancing]) mergeClosures.set(id, merge);
}

function closureIsDrawn(c) {
  if (mapView.highlight.has(c.id)) return true;
  if (!mapView.layers.closures) return false;
  return c.state === 'refused' || c.state === 'confirmed' ? mapView.layers.refused : true;
}

function drawClosures(root) {
  for (const c of drawnClosures.filter(closureIsDrawn)) {
    const merge = mergeClosures.get(c.id);
    const look = closureLook[c.state];
    const [x1, y1, x2, y2] = [toView.x(c.source.x), toView.y(c.source.y), toView.x(c.target.x), toView.y(c.target.y)];
    const colour = merge ? 'var(--merge)' : look.colour;
    const group = svg('g', {class: 'hit', 'data-closure': c.id},
      svg('line', {x1, y1, x2, y2, stroke: 'transparent', 'stroke-width': 11}),
      svg('line', {x1, y1, x2, y2, style: `stroke:${colour}`, 'stroke-width': mapView.highlight.has(c.id) ? 3.5 : 1.3, opacity: 0.85, 'stroke-dasharray': look.dash}),
      svg('circle', {cx: x1, cy: y1, r: 2.6, style: `fill:${colour}`}), svg('circle', {cx: x2, cy: y2, r: 2.6, style: `fill:${colour}`}),
      svg('title', {}, `Closure ${c.id}: ${look.text}`));
    group.addEventListener('click', () => showEvidence(merge ? {kind: 'merge', item: merge} : {kind: 'closure', item: c}));
    root.append(group);
  }
}

function drawWay(root) {
  const strokes = pathStrokes();
  for (const s of strokes) root.append(svg('path', {class: 'line', d: s.d, style: 'stroke:var(--card)', 'stroke-width': 5, opacity: 0.75}));
  for (const s of [...strokes].sort((a, b) => a.isCarried - b.isCarried)) {
    root.append(svg('path', {class: 'line', d: s.d, style: `stroke:${s.colour}`, 'stroke-width': 2.4, 'stroke-dasharray': s.isCarried ? '5 5' : 'none'}));
  }
}

/** Cause of a stretch that the IMU carried, at its middle; short ones get a mark without words. */
function drawEvents(root) {
  const last = path.t.length - 1;
  const taken = [0, last].map((i) => [toView.x(path.x[i]) - 12, toView.y(path.y[i]) - 10, toView.x(path.x[i]) + 44, toView.y(path.y[i]) + 10]);
  for (const event of [...carried].sort((a, b) => (b.to - b.from) - (a.to - a.from))) {
    const [x, y] = positionAt((event.from + event.to) / 2);
    const at = [toView.x(x), toView.y(y)];
    const text = `${[...event.causes].join(', ') || 'carried'}, ${fixed(event.to - event.from, 1)} s`;
    if (at[0] < 0 || at[1] < 0 || at[0] > toView.width || at[1] > toView.height) continue;
    const words = toView.width < 520 ? `${fixed(event.to - event.from, 1)} s` : text;
    const half = 3.5 * words.length;
    const x0 = Math.min(Math.max(at[0], half + 4), toView.width - half - 4);
    const worthWords = event.to - event.from >= 0.5 || carried.length < 6;
    const box = [x0 - half, at[1] - 24, x0 + half, at[1] - 8];
    const group = svg('g', {class: 'hit'}, svg('circle', {cx: at[0], cy: at[1], r: 4.5, style: 'fill:var(--s3);stroke:var(--card)', 'stroke-width': 1.5}),
      svg('title', {}, text));
    if (worthWords && !taken.some((o) => box[0] < o[2] && box[2] > o[0] && box[1] < o[3] && box[3] > o[1]) && taken.length < 16) {
      taken.push(box);
      group.append(svg('text', {class: 'halo', x: x0, y: Math.max(14, at[1] - 11), 'text-anchor': 'middle'}, words));
    }
    group.addEventListener('click', () => showEvidence({kind: 'stretch', item: stretchAt((event.from + event.to) / 2)}));
    root.append(group);
  }
}

function drawEnds(root) {
  const last = path.t.length - 1;
  const ends = [[path.x[0], path.y[0], 'start'], [path.x[last], path.y[last], 'end']].map(([x, y, name]) => [toView.x(x), toView.y(y), name]);
  const close = Math.hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]) < 40;
  ends.forEach(([x, y, name], i) => {
    const shape = i === 0 ? svg('circle', {cx: x, cy: y, r: 6, style: 'fill:var(--card);stroke:var(--ink)', 'stroke-width': 2.5})
      : svg('rect', {x: x - 5, y: y - 5, width: 10, height: 10, style: 'fill:var(--ink);stroke:var(--card)', 'stroke-width': 1.5});
    const right = close && i === (ends[0][0] < ends[1][0] ? 0 : 1) ? -1 : 1;
    root.append(shape, svg('text', {class: 'halo', x: x + 10 * right, y: y + 4, 'text-anchor': right > 0 ? 'start' : 'end'}, name));
  });
}

function drawRuler(root) {
  const lengths = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];
  const length = lengths.filter((l) => l * toView.scale <= 0.22 * toView.width).pop() || 0.2;
  const [x, y] = [14, toView.height - 12];
  root.append(svg('rect', {x: x - 6, y: y - 20, width: length * toView.scale + 12, height: 26, rx: 4, style: 'fill:var(--card)', opacity: 0.8}),
    svg('path', {d: `M${x} ${y - 4}v4h${(length * toView.scale).toFixed(1)}v-4`, fill: 'none', style: 'stroke:var(--ink)', 'stroke-width': 1.5}),
    svg('text', {class: 'strong', x: x + length * toView.scale / 2, y: y - 6, 'text-anchor': 'middle'}, `${length} m`));
}

function nearestMoment(px, py) {
  let best = {distance: Infinity, i: 0};
  for (let i = 0; i < path.t.length; ++i) {
    const distance = Math.hypot(toView.x(path.x[i]) - px, toView.y(path.y[i]) - py);
    if (distance < best.distance) best = {distance, i};
  }
  return best;
}

function attachPointer(root) {
  let drag = null;
  const at = (event) => {
    const box = root.getBoundingClientRect();
    return [(event.clientX - box.left) * toView.width / box.width, (event.clientY - box.top) * toView.height / box.height];
  };
  root.addEventListener('pointerdown', (event) => { if (mapView.zoom > 1) drag = at(event); });
  root.addEventListener('pointermove', (event) => {
    const [x, y] = at(event);
    if (drag && event.buttons) {
      mapView.x += x - drag[0];
      mapView.y += y - drag[1];
      drawMap();
      drag = [x, y];
      return;
    }
    const nearest = nearestMoment(x, y);
    setCursor(nearest.distance < 40 ? path.t[nearest.i] : null);
  });
  window.addEventListener('pointerup', () => { drag = null; });
  root.addEventListener('pointerleave', (event) => { if (event.pointerType === 'mouse') setCursor(null); });
  root.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoomBy(event.deltaY < 0 ? 1.25 : 0.8, at(event));
  }, {passive: false});
}

function zoomBy(factor, centre) {
  const zoom = Math.min(40, Math.max(1, mapView.zoom * factor));
  const real = zoom / mapView.zoom;
  const [dx, dy] = centre ? [centre[0] - toView.width / 2, centre[1] - toView.height / 2] : [0, 0];
  Object.assign(mapView, {zoom, x: dx - (dx - mapView.x) * real, y: dy - (dy - mapView.y) * real});
  if (zoom === 1) Object.assign(mapView, {x: 0, y: 0});
  drawMap();
}

let mapRoot = null;
let mapMark = null;
function drawMap() {
  const container = byId('map');
  chooseView(widthOf(container));
  if (!mapRoot) {
    mapRoot = svg('svg', {role: 'img', 'aria-label': 'The map from above with the trajectory'});
    attachPointer(mapRoot);
    container.replaceChildren(mapRoot);
  }
  mapRoot.setAttribute('viewBox', `0 0 ${toView.width} ${toView.height}`);
  mapRoot.classList.toggle('zoomed', mapView.zoom > 1);
  mapRoot.replaceChildren(mapFilters());
  for (const draw of [drawPoints, drawTruth, drawWay, drawClosures, drawEvents, drawEnds, drawRuler]) draw(mapRoot);
  mapMark = svg('circle', {class: 'cursor', r: 7, style: 'fill:none;opacity:1', 'stroke-width': 2.5, visibility: 'hidden'});
  mapRoot.append(mapMark);
  drawMapLegend();
  setCursor(cursorTime);
}

function followOnMap(t) {
  if (!mapMark) return;
  mapMark.setAttribute('visibility', t === null ? 'hidden' : 'visible');
  if (t === null) { byId('map-readout').textContent = '\u00a0'; return; }
  const [x, y, z] = positionAt(t);
  mapMark.setAttribute('cx', toView.x(x));
  mapMark.setAttribute('cy', toView.y(y));
  const stretch = stretchAt(t);
  byId('map-readout').textContent = `${momentText(t, 2)} \u00b7 ${stateText(stretch)} \u00b7 map ${stretch.map} \u00b7 x ${fixed(x, 2)}, y ${fixed(y, 2)}, z ${fixed(z, 2)} m`;
}

function drawMapLegend() {
  const keys = [];
  if (mapView.colour === 'map') {
    for (const map of data.maps.slice(0, 24)) keys.push(key(mapColour(map.id), `map ${map.id}`));
    if (data.maps.length > 24) keys.push(el('span', {}, `and ${data.maps.length - 24} more`));
  } else {
    data.states.forEach((state, i) => { if (figures.scans_by_state[state] > 0) keys.push(key(stateColour(i), state, '', placedStates.has(i) ? '' : '4 3')); });
  }
  if (carried.length > 0) keys.push(key('var(--soft)', 'dashed: carried by the IMU', '', '4 3'));
  const shown = drawnClosures.filter(closureIsDrawn);
  if (shown.some((c) => mergeClosures.has(c.id))) keys.push(key('var(--merge)', 'merge of two maps'));
  for (const state of Object.keys(closureLook)) {
    if (shown.some((c) => c.state === state && !mergeClosures.has(c.id))) keys.push(key(closureLook[state].colour, closureLook[state].text, '', closureLook[state].dash));
  }
  if (data.truth && mapView.layers.truth) keys.push(key('var(--truth)', 'truth', '', '1 3'));
  if (mapView.layers.height && mapView.layers.points) keys.push(el('span', {}, `points: ${fixed(picture.low_m, 1)} m violet to ${fixed(picture.high_m, 1)} m green`));
  byId('map-legend').replaceChildren(...keys);
}

function layerBox(name, text) {
  const box = el('input', {type: 'checkbox'});
  box.checked = mapView.layers[name];
  box.addEventListener('change', () => { mapView.layers[name] = box.checked; drawMap(); });
  return el('label', {}, box, text);
}

function mapControls() {
  const buttons = [['map', 'by map'], ['state', 'by state']].map(([name, text]) => {
    const button = el('button', {type: 'button', 'aria-pressed': String(mapView.colour === name), 'data-colour': name}, text);
    button.addEventListener('click', () => {
      mapView.colour = name;
      for (const other of buttons) other.setAttribute('aria-pressed', String(other === button));
      drawMap();
    });
    return button;
  });
  const zooms = [['+', 'Zoom in', 1.6], ['\u2212', 'Zoom out', 1 / 1.6], ['fit', 'Show all', 0]].map(([text, label, factor]) => {
    const button = el('button', {type: 'button', 'aria-label': label, title: label}, text);
    button.addEventListener('click', () => zoomBy(factor || 1e-9));
    return button;
  });
  append(byId('map-controls'), [el('span', {class: 'switch', role: 'group', 'aria-label': 'Colour of the way'}, ...buttons),
    layerBox('points', 'points'), layerBox('height', 'height'),
    drawnClosures.length > 0 && layerBox('closures', 'closures'),
    drawnClosures.some((c) => c.state === 'refused' || c.state === 'confirmed') && layerBox('refused', 'without effect too'),
    data.truth && layerBox('truth', 'truth'), el('span', {class: 'switch', role: 'group', 'aria-label': 'Zoom'}, ...zooms)]);
}
