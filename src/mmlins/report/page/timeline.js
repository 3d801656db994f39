// SPDX-License-Identifier: MIT
// States, maps, closures and merges over time, and the evidence of whatever is selected.

const rowHeight = 19;
let timelineMark = null;
let timelineScale = null;
let chosen = null;

/** Stretches too short for a pixel of their own are drawn as one, in the colour of the worst. */
function visibleStretches(scale) {
  const gravity = [1, 0, 2, 3, 4, 5];
  const result = [];
  for (const s of stretches) {
    const last = result[result.length - 1];
    if (last && scale.at(s.to) - scale.at(last.from) < 1) {
      last.to = s.to;
      if (gravity[s.state] > gravity[last.item.state]) last.item = s;
    } else {
      result.push({from: s.from, to: s.to, item: s});
    }
  }
  return result;
}

function pressable(node, selection, label) {
  node.classList.add('hit');
  node.setAttribute('tabindex', '0');
  node.setAttribute('role', 'button');
  node.setAttribute('aria-label', label);
  node.append(svg('title', {}, label));
  node.addEventListener('click', () => showEvidence(selection, node));
  node.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    showEvidence(selection, node);
  });
  return node;
}

function rowLabel(root, y, text, colour) {
  root.append(svg('text', {x: margin.left - 7, y: y + 13, 'text-anchor': 'end', class: 'strong', style: colour ? `fill:${colour}` : ''}, text));
}

function drawStates(root, scale, y) {
  rowLabel(root, y, 'state');
  for (const s of visibleStretches(scale)) {
    const width = Math.max(1, scale.at(s.to) - scale.at(s.from));
    const label = `${momentText(s.from, 2)}, ${fixed(s.to - s.from, 2)} s: ${stateText(s.item)}`;
    root.append(pressable(svg('rect', {x: scale.at(s.from), y: y + 1, width, height: rowHeight - 4, style: `fill:${stateColour(s.item.state)}`}), {kind: 'stretch', item: s.item}, label));
    const text = width > 150 ? stateText(s.item) : data.states[s.item.state];
    if (width > 7.6 * text.length + 8) root.append(svg('text', {class: 'inside', x: scale.at(s.from) + 6, y: y + 12.5, 'pointer-events': 'none', style: 'font-size:10.5px'}, text));
  }
}

function drawMapRow(root, scale, map, y) {
  const colour = mapColour(map.id);
  rowLabel(root, y, data.maps.length > 1 ? `map ${map.id}` : 'map', colour);
  const middle = y + rowHeight / 2 - 1;
  const joined = map.world === data.maps[0].world;
  root.append(svg('line', {x1: scale.at(map.begin_s), x2: scale.at(duration), y1: middle, y2: middle, style: `stroke:${colour}`, 'stroke-width': 2, 'stroke-dasharray': joined ? 'none' : '3 4', opacity: 0.55}));
  for (const s of activeStretches(map)) {
    const label = `Map ${map.id}: ${momentText(s.from)} to ${momentText(s.to)}`;
    root.append(pressable(svg('rect', {x: scale.at(s.from), y: y + 2, width: Math.max(2, scale.at(s.to) - scale.at(s.from)), height: rowHeight - 6, rx: 2, style: `fill:${colour}`}), {kind: 'map', item: map}, label));
  }
}

/** When scans were placed in the map; short interruptions do not split it. */
function activeStretches(map) {
  const result = [];
  for (const s of stretches) {
    if (s.map !== map.id || !placedStates.has(s.state)) continue;
    const last = result[result.length - 1];
    if (last && s.from - last.to < duration / 400) last.to = s.to; else result.push({from: s.from, to: s.to});
  }
  return result;
}

function drawGaps(root, scale, rows) {
  for (const map of data.maps) {
    if (!map.gap || rows[map.gap.from_map] === undefined) continue;
    const [x1, x2] = [scale.at(Math.max(0, map.gap.from_s)), scale.at(map.gap.to_s)];
    const [y1, y2] = [rows[map.gap.from_map] + rowHeight / 2 - 1, rows[map.id] + rowHeight / 2 - 1];
    const d = `M${x1} ${y1}C${(x1 + x2) / 2} ${y1} ${(x1 + x2) / 2} ${y2} ${x2} ${y2}`;
    const group = svg('g', {}, svg('path', {d, fill: 'none', stroke: 'transparent', 'stroke-width': 10}),
      svg('path', {d, fill: 'none', style: 'stroke:var(--soft)', 'stroke-width': 1.5, 'stroke-dasharray': '3 3'}));
    root.append(pressable(group, {kind: 'gap', item: map}, `Gap of ${fixed(map.gap.seconds, 1)} s before map ${map.id}`));
  }
}

function drawMerges(root, scale, rows) {
  for (const merge of data.merges) {
    const x = scale.at(merge.t);
    const [y1, y2] = [rows[merge.map] + rowHeight / 2 - 1, rows[merge.into] + rowHeight / 2 - 1];
    const diamond = (y, r) => `M${x} ${y - r}l${r} ${r}l${-r} ${r}l${-r} ${-r}z`;
    const group = svg('g', {}, svg('line', {x1: x, x2: x, y1, y2, stroke: 'transparent', 'stroke-width': 12}),
      svg('line', {x1: x, x2: x, y1, y2, style: 'stroke:var(--merge)', 'stroke-width': 2}),
      svg('path', {d: diamond(y1, 5) + diamond(y2, 6.5), style: 'fill:var(--merge);stroke:var(--card)', 'stroke-width': 1}));
    root.append(pressable(group, {kind: 'merge', item: merge}, `Merge ${merge.id}: map ${merge.map} into map ${merge.into}`));
  }
}

function drawClosureRow(root, scale, y) {
  rowLabel(root, y, 'closures');
  const order = ['refused', 'confirmed', 'waiting', 'rejected', 'counts'];
  for (const c of [...data.closures].sort((a, b) => order.indexOf(a.state) - order.indexOf(b.state))) {
    const idle = c.state === 'refused' || c.state === 'confirmed';
    const colour = mergeClosures.has(c.id) ? 'var(--merge)' : closureLook[c.state].colour;
    const x = scale.at(c.t);
    const tick = svg('rect', {x: x - 1, width: 2, y: y + (idle ? 7 : 2), height: rowHeight - (idle ? 11 : 6), style: `fill:${colour}`, opacity: idle ? 0.55 : 1});
    const label = `Closure ${c.id} at ${momentText(c.t)}: ${c.state}`;
    root.append(pressable(tick, {kind: 'closure', item: c}, label));
    if (idle) tick.setAttribute('tabindex', '-1');
  }
}

function drawTimeline() {
  const container = byId('timeline');
  const width = widthOf(container);
  const scale = timeScale(width);
  timelineScale = scale;
  const rows = {};
  let y = 6;
  const stateRow = y;
  y += rowHeight + 4;
  for (const map of data.maps) { rows[map.id] = y; y += rowHeight; }
  const closureRow = y + 3;
  if (data.closures.length > 0) y += rowHeight + 3;
  const bottom = y + 2;
  const root = svg('svg', {viewBox: `0 0 ${width} ${bottom + margin.bottom}`, role: 'group', 'aria-label': 'States, maps, closures and merges over time'});
  timeAxis(root, scale, bottom, 4);
  drawStates(root, scale, stateRow);
  for (const map of data.maps) drawMapRow(root, scale, map, rows[map.id]);
  drawGaps(root, scale, rows);
  if (data.closures.length > 0) drawClosureRow(root, scale, closureRow);
  drawMerges(root, scale, rows);
  timelineMark = svg('line', {class: 'cursor', y1: 4, y2: bottom, visibility: 'hidden'});
  root.append(timelineMark);
  followPointer(root, scale);
  container.replaceChildren(root);
}

function followOnTimeline(t) {
  timelineMark.setAttribute('visibility', t === null ? 'hidden' : 'visible');
  if (t === null) { byId('time-readout').textContent = '\u00a0'; return; }
  timelineMark.setAttribute('x1', timelineScale.at(t));
  timelineMark.setAttribute('x2', timelineScale.at(t));
  const s = stretchAt(t);
  byId('time-readout').textContent = `${momentText(t, 2)} \u00b7 ${stateText(s)} \u00b7 map ${s.map}`;
}

function timelineLegend() {
  const keys = data.states.map((state, i) => (figures.scans_by_state[state] > 0 ? key(stateColour(i), state, plural(figures.scans_by_state[state], 'scan')) : null));
  if (data.maps.length > 1) keys.push(key('var(--soft)', 'gap that the IMU carried', '', '3 3'));
  if (data.merges.length > 0) keys.push(key('var(--merge)', 'merge'));
  if (data.maps.length > 1) keys.push(el('span', {}, 'Maps: thick awake, thin asleep, dashed not joined.'));
  append(byId('timeline-legend'), keys);
}

// Evidence

function facts(pairs) {
  return el('dl', {class: 'facts'}, ...pairs.filter((pair) => pair && pair[1] !== null && pair[1] !== '').map(([name, value]) => [el('dt', {}, name), el('dd', {}, value)]).flat());
}

function closureFacts(c) {
  return [['verdict', `${c.state} (${closureLook[c.state].text})`], ['reason', c.reason],
    ['places', `${c.source ? momentText(c.source.t) : '?'} in map ${c.source_map}, ${c.target ? momentText(c.target.t) : '?'} in map ${c.target_map}`],
    ['found', `at ${momentText(c.t)}, ${c.origin}${c.score > 0 ? `, score ${fixed(c.score, 2)}` : ''}`],
    ['overlap', `${fixed(100 * c.overlap, 0)} %`], ['residual', `${fixed(100 * c.residual_rms_m, 1)} cm`],
    ['moved', c.moved_m < 0 ? 'the graph had no idea where it was' : `${significant(c.moved_m)} m, ${significant(c.turned_deg)}\u00b0 from where the graph had it`]];
}

function gapFacts(gap) {
  return [['length', `${fixed(gap.seconds, 2)} s, from ${momentText(gap.from_s)} to ${momentText(gap.to_s)}`],
    ['motion by the IMU', gap.motion_is_known ? `${significant(gap.metres)} m, to about \u00b1${significant(gap.std_position_m, 2)} m and \u00b1${significant(gap.std_rotation_deg, 2)}\u00b0` : 'unknown: the IMU was silent'],
    ['from map', String(gap.from_map)]];
}

function mapFacts(map) {
  return [['began', `${map.began}, at ${momentText(map.begin_s)}`], ['last scan in it', momentText(map.last_believed_s)],
    ['fell asleep', map.fell_asleep || 'no: it is awake at the end'],
    ['joined', map.world === map.id ? (data.maps.some((m) => m.world === map.world && m.id !== map.id) ? 'others were joined to it' : map.id === data.maps[0].world ? '' : 'to no other') : `to map ${map.world}`]];
}

const undoneText = (merge) => (merge.undone ? `, taken back at ${momentText(merge.undone.t)}: ${merge.undone.why}` : '');

function mergeEvidence(merge) {
  const all = new Map(data.closures.map((c) => [c.id, c]));
  const list = [...merge.closures.map((id) => [id, 'reason']), ...merge.enhancing.map((id) => [id, 'found afterwards'])].filter(([id]) => all.has(id));
  return el('div', {class: 'scroll'}, table(['closure', 'role', 'verdict', 'overlap', 'residual', {text: 'in one line'}],
    list.map(([id, role]) => { const c = all.get(id); return [String(id), role, c.state, `${fixed(100 * c.overlap, 0)} %`, `${fixed(100 * c.residual_rms_m, 1)} cm`, {text: c.reason}]; })));
}

function evidenceOf({kind, item}) {
  if (kind === 'closure') return [el('h3', {}, `Closure ${item.id}`), facts(closureFacts(item))];
  if (kind === 'gap') return [el('h3', {}, `Gap before map ${item.id}`), facts(gapFacts(item.gap))];
  if (kind === 'map') return [el('h3', {}, `Map ${item.id}`), facts([...mapFacts(item), ...(item.gap ? [['gap before', `${fixed(item.gap.seconds, 1)} s`]] : [])])];
  if (kind === 'merge') {
    return [el('h3', {}, `Map ${item.map} joined to map ${item.into} at ${momentText(item.t)}${undoneText(item)}`),
      facts([['moved by', `${significant(item.moved_m)} m, ${significant(item.turned_deg)}\u00b0`], ['motion between', item.motion_between_was_known ? 'carried by the IMU' : 'unknown'],
        ['evidence', `${plural(item.closures.length, 'closure')} that agree, ${item.enhancing.length} found afterwards`]]), mergeEvidence(item)];
  }
  return [el('h3', {}, stateText(item)), facts([['time', `${momentText(item.from, 2)} to ${momentText(item.to, 2)}, ${plural(item.scans, 'scan')}`], ['map', String(item.map)], ['means', stateMeaning[data.states[item.state]]]])];
}

const stateMeaning = {
  INITIALIZING: 'part of the window from which the start was found',
  TRACKING: 'matched against the map, in all six directions',
  DEGRADED: 'matched, but the scan leaves directions to the IMU',
  BRIDGING: 'not matched or not believed: the IMU carried the pose, within its budget of drift',
  LOST: 'the budget is spent and the map sleeps; the IMU goes on carrying the pose',
  RELOCATING: 'the map sleeps, but the LiDAR sees again: a new map is on trial',
};

function showEvidence(selection, node) {
  if (chosen) chosen.classList.remove('chosen');
  chosen = node || null;
  if (chosen) chosen.classList.add('chosen');
  byId('evidence').replaceChildren(...evidenceOf(selection));
  const {kind, item} = selection;
  mapView.highlight = new Set(kind === 'closure' ? [item.id] : kind === 'merge' ? [...item.closures, ...item.enhancing] : []);
  drawMap();
  if (!node) byId('evidence').scrollIntoView({block: 'nearest', behavior: 'smooth'});
}
