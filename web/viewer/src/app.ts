// SPDX-License-Identifier: MIT
// Brings together what there is and what is shown of it.

import * as THREE from 'three';
import { Cloud } from './cloud';
import { mapColour, palettes, type Theme } from './colours';
import { button, byId, el, many, metres, seconds } from './dom';
import { edgesOf, showEvidence, type Side } from './evidence';
import { History } from './history';
import { Lines } from './lines';
import { Labels, Measure } from './measure';
import { type ColourBy, rampFor, showAbout, showLegend, showMaps, showMerges, showStateLegend } from './panel';
import { Picker } from './picking';
import { PoseTable } from './poses';
import { appendScans, fetchScene } from './source';
import { Stage } from './stage';
import { Timeline } from './timeline';
import type { Edge, LiveMessage, Merge, SceneMessage } from './types';

const carried = new Set(['BRIDGING', 'LOST', 'RELOCATING']);

export class App {
  scene!: SceneMessage;
  theme: Theme = 'dark';
  colourBy: ColourBy = 'height';
  dim = true;
  follows = false;
  readonly stage: Stage;
  readonly poses = new PoseTable();
  readonly cloud: Cloud;
  readonly lines = new Lines();
  readonly timeline: Timeline;
  readonly labels: Labels;
  readonly measure: Measure;
  readonly picker: Picker;
  private history!: History;
  private live: 'no' | 'live' | 'ended' = 'no';
  private shown: { merge: Merge; side: Side } | null = null;
  private epoch = '';
  private looks = '';
  private rangeFrom = 0;
  private isCutChosen = false;
  private loadText = '';
  private loadTold = 0;

  constructor() {
    this.cloud = new Cloud(this.poses, () => this.stage.invalidateSoon());
    this.stage = new Stage(byId('stage'), (now) => this.tick(now), (budget) => this.choose(budget), () => this.labels?.place());
    this.timeline = new Timeline(() => this.timeHasChanged(), (merge) => this.openMerge(merge));
    this.labels = new Labels(this.stage);
    this.measure = new Measure(this.stage, this.labels);
    this.picker = new Picker(this.stage);
    this.stage.pointScene.add(this.cloud.group);
    this.stage.lineScene.add(this.lines.group);
  }

  /** All anew, as at the beginning. */
  load(scene: SceneMessage): void {
    const isFirst = this.scene === undefined;
    this.scene = scene;
    this.live = scene.live ? 'live' : this.live === 'live' ? 'ended' : 'no';
    this.timeline.isLive = scene.live;
    this.takeAtlas();
    this.hang();
    this.timeline.setEnd(this.lastTime());
    if (isFirst) this.timeline.set(this.timeline.end);
    showAbout(scene, this.live);
    this.redraw();
    if (isFirst) this.stage.show(this.box(), 'aslant', true);
  }

  /** What a run that goes on has to tell. */
  async news(message: LiveMessage): Promise<void> {
    if (message.ended) {
      this.load(await fetchScene());
      return;
    }
    const before = this.scene.atlas.keyframes.id.length;
    const scansBefore = this.scene.scans.t.length;
    if (message.scans) appendScans(this.scene.scans, message.scans);
    if (message.atlas) {
      this.scene.atlas = message.atlas;
      this.takeAtlas();
      showAbout(this.scene, this.live);
    }
    // Scans without a keyframe of their map hang on the first one as soon as it is there.
    this.hang(message.atlas && before < 8 ? 0 : Math.max(0, scansBefore - 40));
    this.timeline.setEnd(this.lastTime());
    if (message.atlas) {
      this.redraw(true);
    } else {
      this.placeLines();
      this.timeline.draw(this.history, this.scene.scans, this.theme);
      this.stage.moved();
    }
    const { length } = this.scene.atlas.keyframes.id;
    if (length !== before && !this.follows && !this.stage.isSteered && (before < 3 || Math.floor(length / 8) !== Math.floor(before / 8))) this.stage.show(this.box(), 'aslant');
  }

  hasEnded(): void {
    if (this.live === 'live') this.live = 'ended';
    showAbout(this.scene, this.live);
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    document.documentElement.dataset.theme = theme;
    byId('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
    this.stage.setTheme(theme);
    const { uniforms } = this.cloud;
    uniforms.sleeping.value.set(theme === 'dark' ? '#3a424c' : '#b4bcc4');
    uniforms.movedColour.value.set(palettes[theme].moved);
    uniforms.intoColour.value.set(palettes[theme].into);
    this.measure.setColour(palettes[theme].measure);
    this.redraw();
  }

  /** Everything that depends on settings. */
  redraw(slowly = false): void {
    if (!this.scene) return;
    this.cloud.setRamp(rampFor(this.colourBy, this.theme));
    this.cloud.setMapColours(Array.from({ length: 64 }, (_, i) => mapColour(this.theme, i)));
    this.cloud.uniforms.colourBy.value = this.shown ? 4 : ['height', 'intensity', 'map', 'time'].indexOf(this.colourBy);
    this.cloud.uniforms.timeRange.value.set(0, Math.max(this.timeline.end, 1));
    this.rangeFrom = -1;
    this.updateRanges();
    showStateLegend(this.scene.scans.states, this.theme);
    this.timeline.draw(this.history, this.scene.scans, this.theme);
    this.epoch = this.looks = '';
    this.timeHasChanged(slowly);
  }

  openMerge(merge: Merge, side: Side = 'after'): void {
    const isNew = this.shown?.merge.id !== merge.id;
    this.shown = { merge, side };
    this.timeline.isPlaying = this.timeline.isLive = false;
    this.timeline.set(merge.t);
    this.lines.shownKinds.add('merge');
    this.showPanel(true);
    byId('panel').scrollTop = 0;
    showEvidence(byId('evidence'), merge, side, this.scene.atlas,
      { show: (m, s) => this.openMerge(m, s), closure: (edge) => this.lookAt(edge), close: () => this.closeMerge() });
    this.redraw();
    if (isNew) this.stage.show(this.box(this.mapsOf(merge)), 'aslant');
  }

  closeMerge(): void {
    this.shown = null;
    this.lines.highlighted = -1;
    byId('evidence').hidden = true;
    this.showPanel(!byId('panel').hidden);
    this.redraw();
  }

  showPanel(on: boolean): void {
    byId('panel').hidden = !on;
    byId('menu').setAttribute('aria-pressed', String(on));
    document.body.classList.toggle('has-panel', on);
    document.body.classList.toggle('has-wide-panel', on && this.shown !== null);
  }

  lookAt(edge: Edge): void {
    this.lines.highlighted = edge.closure;
    const row = this.history.indexOf.get(edge.from) ?? 0;
    const at = new THREE.Vector3(...this.poses.current.subarray(7 * row, 7 * row + 3));
    const away = this.stage.camera.position.clone().sub(this.stage.controls.target).normalize();
    this.stage.moveCamera(at.clone().addScaledVector(away, 35), at);
    this.redraw();
  }

  lookAtMap(map: number): void {
    this.stage.show(this.box(new Set([map])), 'aslant');
  }

  /** Around the way, or the part of it in some maps, with some of what was seen from it. */
  box(maps?: Set<number>): THREE.Box3 {
    const box = new THREE.Box3();
    const { map } = this.scene.atlas.keyframes;
    map.forEach((id, i) => {
      if (!maps || maps.has(id)) box.expandByPoint(new THREE.Vector3(...this.poses.current.subarray(7 * i, 7 * i + 3)));
    });
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const more = Math.min(12, 4 + 0.1 * Math.hypot(size.x, size.y));
    return box.expandByVector(new THREE.Vector3(more, more, 1));
  }

  /** Draws nothing above a height; null: all of it. */
  setCut(height: number | null): void {
    this.cloud.uniforms.heightCut.value = height ?? 1e9;
    byId('cut-at').textContent = height === null ? 'none' : `${height < 0 ? '\u2212' : ''}${Math.abs(height).toFixed(1)} m`;
    const [low, high] = this.cloud.heightRange() ?? [0, 1];
    const slider = byId<HTMLInputElement>('cut');
    slider.value = String(height === null ? 1000 : Math.min(999, (1000 * (height - low)) / (1.15 * (high - low))));
  }
  /** @param share  of the range of heights, from 0 to 1; 1: all of it */
  chooseCut(share: number): void {
    const [low, high] = this.cloud.heightRange() ?? [0, 1];
    this.isCutChosen = true;
    this.setCut(share >= 1 ? null : low + share * 1.15 * (high - low));
    this.rangeFrom = -1;
    this.stage.invalidate();
  }

  private mapsOf(merge: Merge): Set<number> {
    const { moved, into } = this.history.sidesOf(merge);
    return new Set([...moved, ...into]);
  }

  private lastTime(): number {
    const { scans, atlas } = this.scene;
    return Math.max(scans.t.at(-1) ?? 0, atlas.keyframes.t.at(-1) ?? 0, 0.1);
  }

  private takeAtlas(): void {
    this.history = new History(this.scene.atlas);
    this.cloud.setAtlas(this.scene.atlas, this.history.indexOf);
    this.labels.remove('flagged');
    for (const merge of this.history.merges) {
      const flag = button(`${merge.map} \u2192 ${merge.into}`, () => this.openMerge(merge), { class: 'flag', title: 'merge: select for its evidence', 'data-flag': String(merge.id) });
      this.labels.add(el('div', { class: 'label flagged' }, flag), () => this.placeOf(merge));
    }
  }

  /** Scans of a run that has ended lie where its keyframes lie in the end, those of one that goes on in their maps. */
  private hang(from = 0): void {
    const { scans, atlas, live } = this.scene;
    this.lines.hang(scans, atlas, live ? atlas.keyframes.odometry : this.history.posesAt(Infinity), live, from);
  }

  private placeOf(merge: Merge): ArrayLike<number> | null {
    if (merge.t > this.timeline.t + 1e-6) return null;
    const edge = edgesOf(this.scene.atlas, merge).find((one) => one.edge)?.edge;
    const row = edge ? this.history.indexOf.get(edge.to) ?? 0 : 0;
    return this.poses.current.subarray(7 * row, 7 * row + 3);
  }

  private tick(now: number): boolean {
    const played = this.timeline.tick(now);
    const moved = this.poses.advance(now);
    if (moved) this.placeLines();
    this.updateRanges();
    if (this.follows && (played || moved || this.timeline.isLive)) this.followRobot();
    return played || moved;
  }

  followRobot(): void {
    if (!this.lines.robot.visible) return;
    const step = this.lines.robot.position.clone().sub(this.stage.controls.target);
    if (step.lengthSq() < 1e-6) return;
    this.stage.controls.target.add(step);
    this.stage.camera.position.add(step);
    this.stage.moved();
  }

  private choose(budget: number): void {
    if (!this.scene) return;
    const distance = this.stage.camera.position.distanceTo(this.stage.controls.target);
    this.lines.robot.scale.setScalar(Math.max(0.8, 0.035 * distance));
    this.cloud.choose({ camera: this.stage.camera, height: this.stage.height, budget, shownRows: this.rowsUntil(this.timeline.t) });
    const load = `${many(this.cloud.drawn)} of ${many(this.cloud.numPoints)} points drawn${this.cloud.isComplete ? '' : ', loading'}`;
    if (load !== this.loadText && performance.now() - this.loadTold > 200) {
      byId('load').textContent = this.loadText = load;
      this.loadTold = performance.now();
    }
  }

  private rowsUntil(t: number): number {
    const times = this.scene.atlas.keyframes.t;
    let low = 0, high = times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t + 1e-6) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private timeHasChanged(slowly = true): void {
    if (!this.scene) return;
    const { t } = this.timeline;
    if (this.shown && Math.abs(this.shown.merge.t - t) > 1e-6) {
      this.closeMerge();
      return;
    }
    const without = this.shown?.side === 'before' ? this.shown.merge : undefined;
    const anyway = this.shown?.side === 'after' && this.shown.merge.undone ? this.shown.merge : undefined;
    const isEnd = t >= this.timeline.end - 1e-6;
    const epoch = `${anyway?.id ?? ''} ${this.history.events.filter((event) => event <= t).length} ${without?.id ?? ''} ${isEnd} ${this.history.numKeyframes}`;
    if (epoch !== this.epoch) {
      this.poses.moveTo(this.history.posesAt(isEnd && !without ? Infinity : t, without, anyway), performance.now(), slowly || this.shown !== null);
      this.epoch = epoch;
      this.placeLines();
    }
    this.updateLooks(t, without);
    this.lines.showUntil(this.scene.scans, this.rowsUntil(t), t);
    this.stage.moved();
  }

  private placeLines(): void {
    const rows = this.rowsUntil(this.timeline.t);
    this.lines.place(this.scene.scans, this.scene.atlas, this.poses.current, this.theme, rows);
    this.lines.showUntil(this.scene.scans, rows, this.timeline.t);
  }

  /** Which keyframes there are, and which are awake. */
  private updateLooks(t: number, without?: Merge): void {
    const { scans, atlas } = this.scene;
    const rows = this.rowsUntil(t);
    let scan = scans.t.findIndex((time) => time > t + 1e-6) - 1;
    if (scan < -1) scan = scans.t.length - 1;
    const state = scans.states[scans.state[scan]] ?? '';
    byId('state-now').textContent = scan < 0 ? '' : `${state.toLowerCase()}, map ${scans.map[scan]}`;
    byId('state-now').title = scan < 0 ? '' : scans.causes[scans.cause[scan]];
    const worlds = this.history.worldsAt(t, without);
    const isLost = carried.has(state) && !(state === 'BRIDGING');
    const active = isLost ? -1 : scan >= 0 ? worlds.get(scans.map[scan]) : worlds.get(atlas.keyframes.map[rows - 1]);
    const awake = new Set(atlas.maps.filter((map) => worlds.get(map.id) === active).map((map) => map.id));
    const looks = `${rows} ${[...awake].join()} ${this.shown?.merge.id} ${this.dim} ${t < 0}`;
    if (looks === this.looks) return;
    this.looks = looks;
    const sides = this.shown ? this.history.sidesOf(this.shown.merge) : null;
    const { map, t: times } = atlas.keyframes;
    const dimmed = sides || !this.dim ? 1 : 0.3;
    this.poses.setLooks((i) => [awake.has(map[i]) ? 1 : dimmed, map[i], times[i], sides?.moved.has(map[i]) ? 1 : sides?.into.has(map[i]) ? 2 : 0, i < rows ? 1 : 0]);
    showMaps(this.history, this.theme, t, awake, worlds, (id) => this.lookAtMap(id));
    showMerges(this.history, this.shown?.merge ?? null, (merge) => this.openMerge(merge));
    this.lines.place(scans, atlas, this.poses.current, this.theme, rows);
  }

  private updateRanges(): void {
    if (!this.scene || this.rangeFrom === this.cloud.resident) return;
    this.rangeFrom = this.cloud.resident;
    if (!this.isCutChosen) this.setCut(this.cloud.roofOver(this.poses.current));
    const [low, high] = this.cloud.heightRange(this.cloud.uniforms.heightCut.value) ?? [0, 5];
    this.cloud.uniforms.heightRange.value.set(low, high);
    this.cloud.uniforms.intensityScale.value = this.cloud.intensityScale();
    const ends: Record<ColourBy, [string, string]> = {
      height: [`${low < 0 ? '\u2212' : ''}${metres(Math.abs(low))}`, metres(high)], intensity: ['dark', 'bright'], map: ['', ''], time: ['0 s', seconds(this.timeline.end)],
    };
    showLegend(this.colourBy, this.theme, ends[this.colourBy]);
  }
}
