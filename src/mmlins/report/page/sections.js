// SPDX-License-Identifier: MIT
// What is said in words and tables.

function cell(tag, content) {
  if (content instanceof Node) return el(tag, {}, content);
  if (content !== null && typeof content === 'object') return el(tag, {class: 'text'}, content.text);
  return el(tag, {}, content);
}

/** A cell is a text, a node, or {text} for prose. */
function table(head, rows) {
  return el('table', {}, el('thead', {}, el('tr', {}, ...head.map((h) => cell('th', h)))),
    el('tbody', {}, ...rows.map((row) => el('tr', {}, ...row.map((c) => cell('td', c))))));
}

function levelIcon(level) {
  const shapes = {
    good: [svg('circle', {cx: 8, cy: 8, r: 8}), svg('path', {d: 'M4 8.4l2.8 2.8L12 5.6', fill: 'none', style: 'stroke:var(--paper)', 'stroke-width': 2})],
    note: [svg('circle', {cx: 8, cy: 8, r: 7, fill: 'none', stroke: 'currentColor', 'stroke-width': 1.6}), svg('path', {d: 'M8 7v5M8 3.8v1.6', stroke: 'currentColor', 'stroke-width': 1.8})],
    warning: [svg('path', {d: 'M8 .8L15.8 15H.2z'}), svg('path', {d: 'M8 5.6v4.6M8 11.6v1.8', style: 'stroke:var(--paper)', 'stroke-width': 1.8})],
    bad: [svg('path', {d: 'M4.7 0h6.6L16 4.7v6.6L11.3 16H4.7L0 11.3V4.7z'}), svg('path', {d: 'M5 5l6 6M11 5l-6 6', style: 'stroke:var(--paper)', 'stroke-width': 2})],
  };
  return svg('svg', {viewBox: '0 0 16 16', class: level, fill: 'currentColor', role: 'img', 'aria-label': level}, ...shapes[level]);
}

function header() {
  const name = figures.recording.split('/').pop();
  document.title = `${name} \u2013 mmlins report`;
  byId('version').textContent = figures.mmlins;
  byId('recording-name').textContent = figures.recording;
  byId('begin').textContent = data.begin;
  byId('headline').append(levelIcon(data.findings.headline.level), el('span', {}, data.findings.headline.text));
  for (const finding of data.findings.list) byId('findings').append(el('li', {}, levelIcon(finding.level), el('span', {}, finding.text)));
}

function tile(name, value, unit, more, id) {
  return el('dl', {class: 'tile', style: 'margin:0'}, el('dt', {}, name),
    el('dd', {class: 'value', 'data-figure': id}, value, unit ? el('small', {}, unit) : null), el('dd', {class: 'more'}, more));
}

function tiles() {
  const worlds = new Set(data.maps.map((m) => m.world)).size;
  const placed = ['INITIALIZING', 'TRACKING', 'DEGRADED'].reduce((sum, s) => sum + figures.scans_by_state[s], 0);
  const total = figures.stages.total;
  const c = figures.mapping.closures;
  const factor = figures.real_time_factor;
  append(byId('tiles'), [
    data.truth ? tile('ATE', significant(data.truth.trajectory.ate_m.rmse), 'm', `odometry ${significant(data.truth.odometry.ate_m.rmse)} m`, 'ate')
      : tile('Duration', ...timeText(figures.duration_s).split(/ (.*)/).slice(0, 2), plural(figures.scans, 'scan'), 'duration'),
    tile('Scans placed', placed === figures.scans ? '100' : fixed(Math.min(99.9, 100 * placed / figures.scans), 1), '%', `${grouped(placed)} of ${grouped(figures.scans)}`, 'scans'),
    tile('Path', ...lengthText(figures.path_length_m).split(' '), data.truth ? `in ${timeText(figures.duration_s)}` : `${significant(figures.path_length_m / duration, 2)} m/s on average`, 'path'),
    tile('Maps', data.maps.length > 1 ? `${data.maps.length} \u2192 ${worlds}` : '1', '', data.maps.length > 1 ? `${plural(figures.mapping.merges, 'merge')}` : 'never lost', 'maps'),
    tile('Loop closures', grouped(c.counts), '', `of ${grouped(Object.values(c).reduce((a, b) => a + b, 0))} examined`, 'closures'),
    tile('Work per scan', significant(total.mean_ms), 'ms', `p99 ${significant(total.p99_ms)} ms`, 'work'),
    tile('Speed', factor > 0 ? significant(1 / factor, 2) : '\u2013', '\u00d7 real time', `on ${plural(figures.threads, 'thread')}`, 'speed'),
    tile('Memory', grouped(figures.peak_memory_mib), 'MiB', `${grouped(figures.map_points)} map points`, 'memory'),
  ]);
}

function tables() {
  const list = byId('table-list');
  append(list, [el('h3', {}, 'Maps'), el('div', {class: 'scroll'}, table(['map', 'world', 'began', 'from', 'last scan', 'fell asleep', 'gap before'],
    data.maps.map((m) => [String(m.id), String(m.world), m.began, momentText(m.begin_s), momentText(m.last_believed_s), m.fell_asleep || '\u2013',
      m.gap ? `${fixed(m.gap.seconds, 1)} s, ${m.gap.motion_is_known ? `\u00b1${significant(m.gap.std_position_m, 2)} m` : 'motion unknown'}` : '\u2013'])))]);
  for (const merge of data.merges) append(list, [el('h3', {}, `Merge ${merge.id}: map ${merge.map} into map ${merge.into} at ${momentText(merge.t)}${undoneText(merge)}`), mergeEvidence(merge)]);
  const effective = data.closures.filter((c) => c.state !== 'refused' && c.state !== 'confirmed');
  const most = 200;
  if (effective.length > 0) {
    append(list, [el('h3', {}, effective.length > most ? `Closures (the first ${most} of ${effective.length}; all are in closures.csv)` : 'Closures'),
      el('div', {class: 'scroll'}, table(['id', 'at', 'maps', 'verdict', 'origin', 'overlap', 'residual', 'moved'], effective.slice(0, most).map((c) => [String(c.id), momentText(c.t),
        `${c.source_map}, ${c.target_map}`, c.state, c.origin, `${fixed(100 * c.overlap, 0)} %`, `${fixed(100 * c.residual_rms_m, 1)} cm`, c.moved_m < 0 ? '\u2013' : `${significant(c.moved_m)} m`])))]);
  }
}

function truthSection() {
  if (!data.truth) return;
  byId('truth-section').hidden = false;
  const rows = [['trajectory.tum', data.truth.trajectory], ['odometry.tum', data.truth.odometry]].map(([name, e]) => [name, significant(e.ate_m.rmse), significant(e.ate_m.median), significant(e.ate_m.max),
    significant(e.rotation_deg.rmse), e.rpe_1s_m ? significant(e.rpe_1s_m.rmse) : '\u2013', e.rpe_100m_percent ? significant(e.rpe_100m_percent.rmse) : '\u2013', significant(e.end_to_end_m)]);
  append(byId('truth-table'), [table(['', 'ATE [m]', 'median [m]', 'max [m]', 'rotation [\u00b0]', 'RPE 1 s [m]', 'RPE 100 m [%]', 'end to end [m]'], rows)]);
  byId('truth-table').after(el('p', {class: 'hint'}, `Against ${data.truth.file}: aligned, RMSE unless said otherwise; it covers ${fixed(100 * data.truth.coverage_share, 1)} % of the truth.`));
  const container = byId('truth-charts');
  const series = (what, factor) => [{label: 'trajectory', curve: data.curves[`trajectory_error_${what}`], colour: 'var(--c3)', factor}, {label: 'odometry', curve: data.curves[`odometry_error_${what}`], colour: 'var(--c1)', factor}];
  lineChart(container, {title: 'Position error', unit: 'm', series: series('m', 1), height: 170});
  lineChart(container, {title: 'Attitude error', unit: '\u00b0', series: series('deg', 1), height: 130});
}

function observabilitySection() {
  const container = byId('observability');
  const degrees = 180 / Math.PI;
  const colours = ['var(--c1)', 'var(--c2)', 'var(--c3)'];
  const series = (letter, what, factor) => colours.map((colour, i) => ({label: `${letter}${i + 1}`, curve: data.curves[`${letter}${i + 1}_${what}`], colour, factor}));
  const l = data.limits;
  lineChart(container, {title: 'Position std', unit: 'm', log: true, series: series('t', 'std', 1), limits: [{value: l.weak_position_m, label: 'weak'}], height: 180});
  lineChart(container, {title: 'Attitude std', unit: '\u00b0', log: true, series: series('r', 'std', degrees), limits: [{value: l.weak_rotation_rad * degrees, label: 'weak'}], height: 180});
  for (const [letter, title] of [['t', 'Position, noise share'], ['r', 'Attitude, noise share']]) {
    lineChart(container, {title, unit: '%', high: 100, series: series(letter, 'noise_share', 100), limits: [{value: 100 * l.weak_noise_share, label: 'weak'}], height: 130});
  }
}

function matchSection() {
  const container = byId('matches');
  const one = (title, unit, name, colour, more) => lineChart(container, {title, unit, series: [{label: title.toLowerCase(), curve: data.curves[name], colour, factor: (more || {}).factor}], height: 120, ...more});
  one('Speed', 'm/s', 'speed_m_s', 'var(--c3)');
  one('Position against the map, std', 'm', 'std_position_m', 'var(--c1)', {log: true});
  lineChart(container, {title: 'Points and matches', unit: '', series: [{label: 'points', curve: data.curves.points, colour: 'var(--c2)'}, {label: 'matches', curve: data.curves.matches, colour: 'var(--c3)'}], height: 120});
  one('Explained by the map', '%', 'explained', 'var(--c4)', {factor: 100, high: 100});
  one('Residual of the matches', 'cm', 'residual_rms_m', 'var(--c3)', {factor: 100});
  one('IMU and LiDAR disagree over 1 s by', 'cm', 'disagreement_m', 'var(--c1)', {factor: 100});
}

function workSection() {
  const stages = Object.entries(figures.stages);
  const most = Math.max(...stages.filter(([name]) => name !== 'total').map(([, s]) => s.mean_ms), 1e-9);
  const rows = stages.map(([name, s]) => [name, ...['mean_ms', 'median_ms', 'p99_ms', 'max_ms'].map((k) => fixed(s[k], 2)),
    name === 'total' ? '' : el('span', {class: 'meter', style: `width:${(100 * s.mean_ms / most).toFixed(1)}%`})]);
  const node = table(['stage', 'mean', 'median', 'p99', 'max', ''], rows);
  node.querySelectorAll('tbody tr').forEach((row, i) => {
    row.lastChild.classList.add('meter-cell');
    row.dataset.stage = stages[i][0];
    if (stages[i][0] === 'total') row.classList.add('sum');
  });
  append(byId('stages'), [node, el('p', {class: 'hint'}, 'Milliseconds per scan; the bar shows the mean.')]);
  const total = figures.stages.total;
  histogramChart(byId('histogram'), figures.histogram, [{value: total.mean_ms, label: `mean ${significant(total.mean_ms)}`}, {value: total.p99_ms, label: `p99 ${significant(total.p99_ms)}`}]);
  const period = figures.scans > 1 ? 1000 * figures.duration_s / (figures.scans - 1) : 0;
  lineChart(byId('work-charts'), {title: 'Work per scan', unit: 'ms', series: [{label: 'total', curve: data.curves.total_ms, colour: 'var(--c3)'}], limits: period > 0 ? [{value: period, label: 'time between scans'}] : [], height: 130});
  const back = Object.entries(figures.mapping.seconds).map(([name, s]) => `${name} ${significant(s, 2)} s`).join(', ');
  byId('back-end').textContent = `Real-time factor ${significant(figures.real_time_factor)}: ${timeText(figures.wall_s)} of work for ${timeText(figures.duration_s)} of recording. Peak memory ${grouped(figures.peak_memory_mib)} MiB. Back end, beside the odometry: ${back}.`;
}

function recordingSection() {
  const r = data.recording;
  const node = byId('detected');
  if (!r) { append(node, [facts([['recording', figures.recording], ['LiDAR', figures.lidar_topic], ['IMU', figures.imu_topic]])]); return; }
  const model = data.settings.rig.find((s) => s.key === 'lidar_model');
  append(node, [facts([['recording', `${r.path}, ${timeText(r.seconds)}`], ['sensor', model ? model.value : ''],
    r.lidar && ['LiDAR', `${r.lidar.topic}: ${significant(r.lidar.rate_hz, 3)} scans per second of ${grouped(r.lidar.points_per_scan)} points${r.lidar.rings ? `, ${r.lidar.rings} rings` : ''}`],
    r.lidar && ['point time', r.lidar.point_time + (r.lidar.span_ms > 0 ? `; a scan spans ${fixed(r.lidar.span_ms, 1)} ms` : '')], r.lidar && ['point fields', r.lidar.fields],
    r.imu && ['IMU', `${r.imu.topic}: ${significant(r.imu.rate_hz, 3)} Hz, acceleration in ${r.imu.unit.replace('^2', '\u00b2')} (median ${fixed(r.imu.median_accel_norm, 2)})`]]),
  el('div', {class: 'scroll'}, table(['topic', {text: 'type'}, 'messages', 'rate', 'pauses', 'longest'], r.topics.map((t) => [t.name, {text: t.type}, grouped(t.messages),
    t.rate_hz > 0 ? `${significant(t.rate_hz)} Hz` : '\u2013', String(t.gaps), t.gaps > 0 ? `${fixed(t.longest_gap_s, 2)} s` : '\u2013'])))]);
}

function settingRows(list, short) {
  return el('div', {class: 'settings'}, ...list.map((s) => el('div', {}, el('code', {}, short ? s.key.split('.').pop() : s.key),
    el('span', {}, el('code', {}, `${s.value}${s.unit ? ` ${s.unit}` : ''}`), s.default !== undefined ? el('span', {class: 'was'}, ` (default ${s.default === '' ? 'empty' : s.default})`) : null), el('span', {class: 'meaning'}, s.meaning))));
}

function settingGroups(list) {
  const groups = new Map();
  for (const s of list) {
    const name = s.key.split('.').slice(0, -1).join('.') || 'general';
    groups.set(name, [...(groups.get(name) || []), s]);
  }
  return [...groups].map(([name, members]) => el('details', {}, el('summary', {}, `${name} (${members.length})`), settingRows(members, true)));
}

function configSection() {
  const node = byId('config');
  for (const [name, list, file] of [['method', data.settings.config, 'config.yaml'], ['sensors', data.settings.rig, 'rig.yaml']]) {
    const changed = list.filter((s) => s.default !== undefined);
    append(node, [el('h3', {style: 'margin-top:10px'}, changed.length === 0 ? `Parameters of the ${name}: all ${list.length} are the defaults` : `Parameters of the ${name}: ${changed.length} of ${list.length} differ from the defaults`),
      changed.length > 0 && settingRows(changed),
      el('details', {}, el('summary', {}, `All ${list.length} values of ${file}`), ...(name === 'method' ? settingGroups(list) : [settingRows(list)]))]);
  }
}
