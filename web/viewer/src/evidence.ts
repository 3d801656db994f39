// SPDX-License-Identifier: MIT
// A merge in words, with all that is on record about it.

import { button, el, metres, plural, seconds } from './dom';
import { amount, compose, inverse } from './pose';
import type { Atlas, Edge, Merge } from './types';

export type Side = 'before' | 'after';

export interface EvidenceActions {
  show: (merge: Merge, side: Side) => void;
  closure: (edge: Edge) => void;
  close: () => void;
}

function number(value: number | undefined, digits: number, unit = ''): string {
  return value === undefined ? '\u2013' : `${value.toFixed(digits)}${unit}`;
}

/** Edges by the closures that they were made of. */
export function edgesOf(atlas: Atlas, merge: Merge): { edge: Edge | undefined; id: number; enhancing: boolean }[] {
  const byClosure = new Map(atlas.edges.filter((edge) => edge.closure >= 0).map((edge) => [edge.closure, edge]));
  const list = (ids: number[] | undefined, enhancing: boolean) => (ids ?? []).map((id) => ({ edge: byClosure.get(id), id, enhancing }));
  return [...list(merge.evidence?.closures, false), ...list(merge.evidence?.enhancing, true)];
}

function story(merge: Merge, atlas: Atlas): string[] {
  const moved = amount(compose(merge.after, inverse(merge.before)));
  const first = merge.evidence?.closures?.length ?? 0, more = merge.evidence?.enhancing?.length ?? 0;
  const lines = [`At ${seconds(merge.t)} map ${merge.map} was recognised in map ${merge.into} and joined to it.`];
  if (first > 0) lines.push(`${plural(first, 'closure')} between them told the same story and ${first === 1 ? 'was' : 'were'} the reason.`);
  if (more > 0) lines.push(`${plural(more, 'further one', 'further ones')} ${more === 1 ? 'was' : 'were'} sought and found afterwards, to tie them together where it adds most.`);
  const known = merge.evidence?.motion_between_was_known;
  if (known === true) lines.push('The IMU had carried the pose from one to the other, and the closures were checked against it.');
  if (known === false) lines.push('Nothing was known of the motion between them: the places were recognised by how they look.');
  lines.push(`The join moved map ${merge.map} by ${metres(Math.hypot(merge.after[0] - merge.before[0], merge.after[1] - merge.before[1], merge.after[2] - merge.before[2]))} at its origin and turned it by ${moved.degrees.toFixed(2)}\u00b0.`);
  const rejected = edgesOf(atlas, merge).filter(({ edge }) => edge && edge.weight <= 0).length;
  if (rejected > 0) lines.push(`${plural(rejected, 'of these closures', 'of these closures')} ${rejected === 1 ? 'was' : 'were'} rejected later, when others spoke against ${rejected === 1 ? 'it' : 'them'}.`);
  const why = merge.evidence?.undone_because;
  if (merge.undone) lines.push(`It was taken back later${typeof why === 'string' ? `: ${why}` : ''}.`);
  return lines;
}

function table(merge: Merge, atlas: Atlas, actions: EvidenceActions): HTMLElement {
  const body = el('tbody');
  const verdict = el('p', { class: 'soft', role: 'status' });
  for (const { edge, id, enhancing } of edgesOf(atlas, merge)) {
    const e = edge?.evidence;
    const row = el('tr', { tabindex: '0', title: e?.reason ?? '' },
      el('td', {}, String(id)),
      el('td', {}, edge ? `${edge.from} \u2192 ${edge.to}` : '\u2013'),
      el('td', { class: 'text' }, `${e?.origin ?? '\u2013'}${enhancing ? ', later' : ''}`),
      el('td', {}, number(e?.overlap === undefined ? undefined : 100 * e.overlap, 0, ' %')),
      el('td', {}, number(e?.residual_rms_m === undefined ? undefined : 100 * e.residual_rms_m, 1, ' cm')),
      el('td', { class: 'text' }, edge ? (edge.weight > 0 ? 'counts' : 'rejected') : 'not kept'));
    const choose = () => {
      for (const other of body.children) other.classList.toggle('chosen', other === row);
      verdict.textContent = e?.reason ? `Closure ${id}: ${e.reason}` : '';
      if (edge) actions.closure(edge);
    };
    row.addEventListener('click', choose);
    row.addEventListener('keydown', (event) => event.key === 'Enter' && choose());
    body.append(row);
  }
  const head = el('tr', {}, ...['closure', 'keyframes', 'found', 'overlap', 'residual', ''].map((name) => el('th', {}, name)));
  return el('div', { class: 'scroll' }, el('table', {}, el('thead', {}, head), body), verdict);
}

/** Whatever else is on record. */
function rest(merge: Merge): HTMLElement | null {
  const told = new Set(['closures', 'enhancing', 'motion_between_was_known', 'undone_because']);
  const entries = Object.entries(merge.evidence ?? {}).filter(([key]) => !told.has(key));
  if (entries.length === 0) return null;
  return el('dl', { class: 'facts' }, ...entries.flatMap(([key, value]) => [el('dt', {}, key.replaceAll('_', ' ')), el('dd', {}, typeof value === 'string' ? value : JSON.stringify(value))]));
}

export function showEvidence(holder: HTMLElement, merge: Merge, side: Side, atlas: Atlas, actions: EvidenceActions): void {
  const option = (name: Side) =>
    button(name === 'before' ? 'Before' : 'After', () => actions.show(merge, name), { 'aria-pressed': String(side === name), 'data-side': name });
  holder.hidden = false;
  holder.replaceChildren(
    el('div', { class: 'row' }, el('h2', {}, `Merge: map ${merge.map} into map ${merge.into}`), button('\u00d7', actions.close, { class: 'close', 'aria-label': 'close' })),
    el('div', { class: 'row' },
      el('div', { class: 'switch', role: 'group', 'aria-label': 'the two clouds' }, option('before'), option('after')),
      el('span', { class: 'key moved' }, `map ${merge.map}`), el('span', { class: 'key into' }, `map ${merge.into}`)),
    ...story(merge, atlas).map((line) => el('p', {}, line)),
    rest(merge) ?? '',
    table(merge, atlas, actions),
  );
}
