// SPDX-License-Identifier: MIT
// The slider of time, above it what happened when: states, each map awake or asleep, closures and merges.

import { mapColour, palettes, stateColour, type Theme } from './colours';
import { byId, seconds, svg } from './dom';
import type { History } from './history';
import type { Merge, Scans } from './types';

const lane = 7;

export class Timeline {
  t = 0;
  end = 1;
  isPlaying = false;
  /** The end moves on, and the slider with it. */
  isLive = false;
  private readonly slider = byId<HTMLInputElement>('slider');
  private readonly play = byId<HTMLButtonElement>('play');
  private readonly speed = byId<HTMLSelectElement>('speed');
  private readonly readout = byId('clock');
  private lastTick = 0;

  constructor(private readonly onChange: () => void, private readonly onMerge: (merge: Merge) => void) {
    this.slider.addEventListener('input', () => {
      this.isPlaying = false;
      this.isLive = false;
      this.set(Number(this.slider.value));
    });
    this.play.addEventListener('click', () => this.toggle());
    byId('to-end').addEventListener('click', () => this.set(this.end));
  }

  toggle(): void {
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying && this.t >= this.end) this.t = 0;
    this.lastTick = 0;
    this.set(this.t);
  }

  set(t: number): void {
    this.t = Math.min(this.end, Math.max(0, t));
    this.slider.value = String(this.t);
    this.slider.setAttribute('aria-valuetext', `${this.t.toFixed(1)} s`);
    this.readout.textContent = `${seconds(this.t)} / ${seconds(this.end)}`;
    this.play.textContent = this.isPlaying ? '\u275a\u275a' : '\u25b6';
    this.play.setAttribute('aria-label', this.isPlaying ? 'pause' : 'play');
    this.onChange();
  }

  setEnd(end: number): void {
    const wasAtEnd = this.isLive || this.t >= this.end - 1e-6;
    this.end = end;
    this.slider.max = String(end);
    this.slider.step = String(Math.max(0.01, end / 4000));
    if (wasAtEnd && !this.isPlaying) this.t = end;
    this.set(this.t);
  }

  /** @return whether time has gone on */
  tick(now: number): boolean {
    if (!this.isPlaying) return false;
    if (this.lastTick > 0) {
      const t = this.t + (Number(this.speed.value) * (now - this.lastTick)) / 1000;
      if (t >= this.end) this.isPlaying = false;
      this.set(t);
    }
    this.lastTick = now;
    return true;
  }

  draw(history: History, scans: Scans, theme: Theme): void {
    const { maps } = history.atlas;
    const rows = Math.min(maps.length, 8);
    const height = 8 + rows * lane + 4;
    const root = svg('svg', { viewBox: `0 0 1000 ${height}`, preserveAspectRatio: 'none', 'aria-hidden': 'true' });
    const x = (t: number) => (1000 * Math.min(this.end, Math.max(0, t))) / this.end;
    for (let i = 0; i < scans.t.length; ) {
      let j = i;
      while (j + 1 < scans.t.length && scans.state[j + 1] === scans.state[i]) ++j;
      const from = x(i > 0 ? scans.t[i - 1] : 0);
      root.append(svg('rect', { x: from, y: 0, width: Math.max(0.5, x(scans.t[j]) - from), height: 5, fill: stateColour(theme, scans.states[scans.state[i]]) }));
      i = j + 1;
    }
    maps.slice(-rows).forEach((map, row) => {
      const y = 9 + row * lane, colour = mapColour(theme, map.id);
      const last = map.active ? this.end : map.last;
      root.append(svg('rect', { x: x(map.begin), y: y + 1.5, width: Math.max(0, x(this.end) - x(map.begin)), height: 1, fill: colour, opacity: 0.45 }));
      root.append(svg('rect', { x: x(map.begin), y: y, width: Math.max(1, x(last) - x(map.begin)), height: 4, rx: 1, fill: colour }));
    });
    const holder = byId('lanes');
    holder.style.height = `${height * 1.15}px`;
    holder.replaceChildren(root, ...this.marks(history, theme, x));
  }

  private marks(history: History, theme: Theme, x: (t: number) => number): HTMLElement[] {
    return history.merges.map((merge) => {
      const mark = document.createElement('button');
      mark.type = 'button';
      mark.className = 'mark';
      mark.style.left = `${x(merge.t) / 10}%`;
      mark.style.background = palettes[theme].merge;
      mark.title = `map ${merge.map} joined to map ${merge.into}`;
      mark.setAttribute('aria-label', mark.title);
      mark.addEventListener('click', () => this.onMerge(merge));
      return mark;
    });
  }
}
