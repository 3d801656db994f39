// SPDX-License-Identifier: MIT
// What stands at the side: legend, maps, merges.

import { greys, mapColour, ramps, stateColour, type Theme } from './colours';
import { byId, el, many, metres, plural, seconds } from './dom';
import type { History } from './history';
import type { Merge, SceneMessage } from './types';

export type ColourBy = 'height' | 'intensity' | 'map' | 'time';
export const colourModes: ColourBy[] = ['height', 'intensity', 'map', 'time'];

export function rampFor(mode: ColourBy, theme: Theme): string[] {
  return mode === 'intensity' ? greys[theme] : ramps[theme];
}

export function showLegend(mode: ColourBy, theme: Theme, ends: [string, string]): void {
  const legend = byId('legend');
  for (const node of document.querySelectorAll<HTMLElement>('[data-colour]')) node.setAttribute('aria-pressed', String(node.dataset.colour === mode));
  if (mode === 'map') {
    legend.replaceChildren();
    return;
  }
  const ramp = el('div', { class: 'ramp' });
  ramp.style.background = `linear-gradient(to right, ${rampFor(mode, theme).join(', ')})`;
  legend.replaceChildren(ramp, el('div', { class: 'ends' }, el('span', {}, ends[0]), el('span', {}, ends[1])));
}

export function showStateLegend(states: string[], theme: Theme): void {
  byId('state-legend').replaceChildren(...states.map((state) => {
    const swatch = el('i');
    swatch.style.background = stateColour(theme, state);
    return el('span', {}, swatch, state.toLowerCase());
  }));
}

export function showAbout(scene: SceneMessage, live: 'no' | 'live' | 'ended'): void {
  const { atlas, summary } = scene;
  document.title = `${scene.name} \u00b7 mmlins`;
  byId('name').replaceChildren(scene.name, live === 'no' ? '' : el('span', { class: `live ${live}` }, live === 'live' ? 'live' : 'ended'));
  const points = atlas.keyframes.points.reduce((a, b) => a + b, 0);
  const facts = [plural(atlas.maps.length, 'map'), plural(atlas.keyframes.id.length, 'keyframe'), `${many(points)} points`];
  if (summary?.path_length_m) facts.push(metres(summary.path_length_m));
  if (summary?.duration_s) facts.push(seconds(summary.duration_s));
  const ms = summary?.stages?.total?.mean_ms;
  byId('about').title = ms ? `${ms.toFixed(1)} ms of work per scan` : '';
  byId('figures').textContent = facts.join(' \u00b7 ');
}

export function showMaps(history: History, theme: Theme, t: number, awake: Set<number>, worlds: Map<number, number>, pick: (map: number) => void): void {
  const { maps, keyframes } = history.atlas;
  byId('maps').replaceChildren(...maps.map((map) => {
    const swatch = el('span', { class: 'swatch' });
    swatch.style.background = mapColour(theme, map.id);
    const count = keyframes.map.filter((id) => id === map.id).length;
    const world = worlds.get(map.id) ?? map.id;
    const state = t < map.begin ? 'not yet' : awake.has(map.id) ? 'awake' : 'asleep';
    const lasts = map.active ? 'goes on' : `lasts ${seconds(Math.max(0, map.last - map.begin))}`;
    const began = `${map.began} at ${seconds(map.begin)}, ${lasts}${map.ended ? `; fell asleep: ${map.ended}` : ''}`;
    const node = el('button', { type: 'button', class: `item ${state === 'awake' ? '' : 'asleep'}`, 'data-map': String(map.id) }, swatch,
      el('b', {}, `Map ${map.id}`), el('span', { class: 'soft' }, world === map.id ? state : `${state}, in world ${world}`),
      el('small', {}, `${plural(count, 'keyframe')}; ${began}`));
    node.addEventListener('click', () => pick(map.id));
    return node;
  }));
}

export function showMerges(history: History, chosen: Merge | null, pick: (merge: Merge) => void): void {
  byId('merge-section').hidden = history.atlas.merges.length === 0;
  byId('merges').replaceChildren(...history.atlas.merges.map((merge) => {
    const closures = (merge.evidence?.closures?.length ?? 0) + (merge.evidence?.enhancing?.length ?? 0);
    const swatch = el('span', { class: 'swatch' });
    swatch.style.background = 'var(--merge)';
    const node = el('button', { type: 'button', class: 'item', 'data-merge': String(merge.id), 'aria-pressed': String(chosen?.id === merge.id) }, swatch,
      el('b', {}, `Map ${merge.map} \u2192 map ${merge.into}`), el('span', { class: 'soft' }, `at ${seconds(merge.t)}`),
      el('small', {}, merge.undone ? 'taken back' : `${plural(closures, 'closure')}; select for the evidence`));
    node.addEventListener('click', () => pick(merge));
    return node;
  }));
}
