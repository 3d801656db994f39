// SPDX-License-Identifier: MIT
// The points: which blocks, in which detail, so that a picture never has more than can be drawn in time.

import * as THREE from 'three';
import { rampBytes, rgb } from './colours';
import { apply } from './pose';
import type { PoseTable } from './poses';
import { pointFragment, pointVertex } from './shaders';
import { type Tile, TileQueue } from './tiles';
import type { Atlas } from './types';

interface Level {
  state: 'none' | 'here' | 'lost';
  points?: THREE.Points;
  lastDrawn: number;
}

interface Block {
  first: number;
  last: number;
  /** Rows of the table of keyframes. */
  firstRow: number;
  lastRow: number;
  points: number;
  levels: Level[];
  counts?: number[];
  cells: number[];
  centre: [number, number, number];
  radius: number;
  material: THREE.RawShaderMaterial;
}

const defaultCells = [1, 0.5, 0.25, 0.125, 0];
/** Points nearer to each other than this on the screen add nothing [px]. */
const fineEnough = 1.3;
const maxResident = 24e6;

function uniforms() {
  return {
    poses: { value: null as THREE.Texture | null },
    ramp: { value: null as THREE.Texture | null },
    mapColours: { value: null as THREE.Texture | null },
    colourBy: { value: 0 },
    heightRange: { value: new THREE.Vector2(0, 1) },
    heightCut: { value: 1e9 },
    timeRange: { value: new THREE.Vector2(0, 1) },
    intensityScale: { value: 1 / 255 },
    sizeLimits: { value: new THREE.Vector2(1.5, 6) },
    pixelsPerRadian: { value: 1000 },
    pointScale: { value: 1 },
    sleeping: { value: new THREE.Color(0.3, 0.33, 0.37) },
    movedColour: { value: new THREE.Color(1, 0.6, 0.2) },
    intoColour: { value: new THREE.Color(0.2, 0.6, 1) },
  };
}

interface Wanted {
  block: Block;
  level: number;
  /** Distance between points of the level before, on the screen [px]. */
  priority: number;
  isSeen: boolean;
}

export interface LodView {
  camera: THREE.PerspectiveCamera;
  height: number;
  budget: number;
  shownRows: number;
}

export class Cloud {
  readonly group = new THREE.Group();
  readonly uniforms = uniforms();
  drawn = 0;
  resident = 0;
  private blocks: Block[] = [];
  private readonly queue = new TileQueue();
  private readonly samples: [number, number, number][] = [];
  private readonly brightness: number[] = [];
  private frame = 0;

  constructor(private readonly poses: PoseTable, private readonly onChange: () => void) {
    this.group.matrixAutoUpdate = false;
  }

  /** Takes over the blocks; those that have not changed stay as they are. */
  setAtlas(atlas: Atlas, rowOf: Map<number, number>): void {
    const known = new Map(this.blocks.map((block) => [`${block.first}-${block.last}`, block]));
    const kept = atlas.blocks.map(([, first, last, points]) => {
      const same = known.get(`${first}-${last}`);
      known.delete(`${first}-${last}`);
      return same ?? this.makeBlock(first, last, points, rowOf);
    });
    const begins = new Map(kept.map((block) => [block.first, block]));
    for (const gone of known.values()) {
      // A block that grows is shown as it was until it comes again.
      const next = begins.get(gone.first);
      if (next) this.lend(gone, next);
      else this.drop(gone);
    }
    this.blocks = kept;
  }

  /** All blocks are there, be it coarsely. */
  get isCoarse(): boolean {
    return this.blocks.every((block) => block.levels[0].state !== 'none');
  }
  /** All that this picture can use is there. */
  get isComplete(): boolean {
    return this.queue.isIdle && this.isCoarse;
  }
  get numPoints(): number {
    return this.blocks.reduce((sum, block) => sum + block.points, 0);
  }

  setRamp(stops: string[]): void {
    const texture = new THREE.DataTexture(rampBytes(stops), 256, 1);
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    this.uniforms.ramp.value = texture;
  }
  setMapColours(colours: string[]): void {
    const bytes = new Uint8Array(4 * 64);
    for (let i = 0; i < 64; ++i) bytes.set([...rgb(colours[i % colours.length]).map((c) => Math.round(255 * c)), 255], 4 * i);
    const texture = new THREE.DataTexture(bytes, 64, 1);
    texture.needsUpdate = true;
    this.uniforms.mapColours.value = texture;
  }

  /** Chooses what is drawn, and asks for what is missing. */
  choose(view: LodView): void {
    ++this.frame;
    this.uniforms.poses.value = this.poses.texture;
    const perRadian = view.height / (2 * Math.tan((view.camera.fov * Math.PI) / 360));
    this.uniforms.pixelsPerRadian.value = perRadian;
    const frustum = new THREE.Frustum().setFromProjectionMatrix(
      new THREE.Matrix4().multiplyMatrices(view.camera.projectionMatrix, view.camera.matrixWorldInverse));
    const wanted: Wanted[] = [];
    for (const block of this.blocks) {
      for (const level of block.levels) if (level.points) level.points.visible = false;
      if (block.firstRow >= view.shownRows) continue;
      const centre = this.centreOf(block);
      const isSeen = frustum.intersectsSphere(new THREE.Sphere(centre, 1.7 * block.radius));
      const distance = Math.max(view.camera.position.distanceTo(centre) - 0.7 * block.radius, 3);
      const pixelsPerMetre = perRadian / distance;
      for (let level = 0; level < block.levels.length; ++level) {
        const priority = level === 0 ? 1e6 + pixelsPerMetre : block.cells[level - 1] * pixelsPerMetre;
        if (level > 0 && (!isSeen || priority < fineEnough)) break;
        wanted.push({ block, level, priority: isSeen ? priority : 0.5, isSeen });
      }
    }
    wanted.sort((a, b) => b.priority - a.priority);
    this.queue.want(this.wishes(wanted, view.budget));
    this.draw(wanted.filter(({ isSeen }) => isSeen), view.budget);
    this.forget();
  }

  /** Low and high ends of the heights that are shown, without outliers; null while nothing is known. */
  heightRange(cut = Infinity): [number, number] | null {
    const sorted = this.samples.map((p) => p[2]).filter((z) => z <= cut).sort((a, b) => a - b);
    if (sorted.length < 50) return null;
    const at = (share: number) => sorted[Math.floor(share * (sorted.length - 1))];
    const [low, high] = [at(0.02), at(0.97)];
    return [low, Math.max(high, low + 1)];
  }

  /** The height to cut a building open at, if most of a way lies under a roof [m]. */
  roofOver(way: ArrayLike<number>): number | null {
    const cell = (x: number, y: number) => `${Math.floor(x / 3)} ${Math.floor(y / 3)}`;
    const highest = new Map<string, number>();
    for (const [x, y, z] of this.samples) highest.set(cell(x, y), Math.max(z, highest.get(cell(x, y)) ?? -Infinity));
    const heights: number[] = [];
    let covered = 0;
    for (let i = 0; i + 6 < way.length; i += 7) {
      heights.push(way[i + 2]);
      if ((highest.get(cell(way[i], way[i + 1])) ?? -Infinity) > way[i + 2] + 0.8) ++covered;
    }
    if (heights.length === 0 || covered < 0.6 * heights.length) return null;
    heights.sort((a, b) => a - b);
    const roofs = [...highest.values()].sort((a, b) => a - b);
    const roof = roofs[Math.floor(0.5 * roofs.length)];
    const top = heights[heights.length - 1];
    return top + Math.max(0.4, 0.5 * (roof - top));
  }
  intensityScale(): number {
    if (this.brightness.length < 50) return 1 / 255;
    const sorted = [...this.brightness].sort((a, b) => a - b);
    return 1 / Math.max(1, sorted[Math.floor(0.98 * (sorted.length - 1))]);
  }

  private makeBlock(first: number, last: number, points: number, rowOf: Map<number, number>): Block {
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: pointVertex,
      fragmentShader: pointFragment,
      uniforms: { ...this.uniforms, firstKeyframe: { value: rowOf.get(first) ?? 0 }, spacing: { value: 1 } },
    });
    return {
      first, last, points, material, firstRow: rowOf.get(first) ?? 0, lastRow: rowOf.get(last) ?? 0,
      levels: defaultCells.map(() => ({ state: 'none', lastDrawn: 0 })),
      cells: defaultCells, centre: [0, 0, 0], radius: 25,
    };
  }

  private centreOf(block: Block): THREE.Vector3 {
    const middle = (block.firstRow + block.lastRow + 1) >> 1;
    return new THREE.Vector3(...apply(this.poses.current.subarray(7 * middle, 7 * middle + 7), block.centre));
  }

  /** What is missing of the best picture of so many points. */
  private wishes(wanted: Wanted[], budget: number) {
    let count = 0;
    const wishes = [];
    for (const { block, level, priority } of wanted) {
      count += block.counts?.[level] ?? 0;
      if (level > 0 && (count > budget || !block.counts)) continue;
      if (block.levels[level].state === 'none') wishes.push(this.wish(block, level, priority));
    }
    return wishes;
  }

  /** What there is, as long as the budget lasts. Any beginning of a level is an even sample: what does not fit is thinned. */
  private draw(wanted: Wanted[], budget: number): void {
    const coarse = wanted.filter(({ level }) => level === 0);
    const least = coarse.reduce((sum, { block, level }) => sum + (block.levels[level].points ? block.counts![level] : 0), 0);
    const coarseShare = Math.min(1, budget / Math.max(1, least));
    this.drawn = 0;
    const full = new Set<Block>();
    for (const { block, level } of wanted) {
      const slot = block.levels[level];
      if (!slot.points || full.has(block)) continue;
      const count = block.counts![level];
      const share = level === 0 ? coarseShare : Math.min(1, (budget - this.drawn) / Math.max(1, count));
      if (share < 1) full.add(block); // finer levels alone would show holes
      if (share < 0.02) continue;
      slot.points.visible = true;
      slot.points.geometry.setDrawRange(0, Math.ceil(share * count));
      slot.lastDrawn = this.frame;
      const own = block.cells[level] || 0.5 * block.cells[level - 1];
      const coarser = level > 0 ? block.cells[level - 1] : own / Math.sqrt(share);
      (block.material.uniforms.spacing as THREE.IUniform<number>).value = coarser + (own - coarser) * share;
      this.drawn += Math.ceil(share * count);
    }
  }

  private wish(block: Block, level: number, priority: number) {
    const slot = block.levels[level];
    return {
      url: `/api/tiles/${block.first}-${block.last}/${level}`,
      priority,
      take: (tile: Tile) => this.take(block, tile),
      fail: () => { slot.state = 'lost'; this.onChange(); },
    };
  }

  private take(block: Block, tile: Tile): void {
    const slot = block.levels[tile.level];
    if (slot.state === 'here') return;
    if (!this.blocks.includes(block)) return;
    slot.points?.geometry.dispose();
    if (slot.points) this.group.remove(slot.points);
    Object.assign(block, { counts: tile.counts, cells: tile.cells, centre: tile.centre, radius: Math.max(tile.radius, 2) });
    const geometry = new THREE.BufferGeometry();
    const places = new THREE.Int16BufferAttribute(tile.places, 4);
    places.gpuType = THREE.FloatType;
    const intensities = new THREE.Uint16BufferAttribute(tile.intensities, 1);
    intensities.gpuType = THREE.FloatType;
    geometry.setAttribute('place', places);
    geometry.setAttribute('intensity', intensities);
    geometry.setDrawRange(0, tile.counts[tile.level]);
    slot.points = new THREE.Points(geometry, block.material);
    slot.points.frustumCulled = false;
    slot.points.matrixAutoUpdate = false;
    slot.state = 'here';
    this.resident += tile.counts[tile.level];
    this.group.add(slot.points);
    if (tile.level <= 1) this.sample(block, tile);
    this.onChange();
  }

  /** Heights and intensities, for the ranges of the colours. */
  private sample(block: Block, tile: Tile): void {
    const step = Math.max(1, Math.floor(tile.counts[tile.level] / 300));
    for (let i = 0; i < tile.counts[tile.level]; i += step) {
      const row = block.firstRow + tile.places[4 * i + 3];
      const p = [0, 1, 2].map((k) => 0.004 * tile.places[4 * i + k]);
      this.samples.push(apply(this.poses.current.subarray(7 * row, 7 * row + 7), p));
      this.brightness.push(tile.intensities[i]);
    }
  }

  /** Frees what has not been drawn for long, the finest first, if there is too much. */
  private forget(): void {
    if (this.resident <= maxResident) return;
    const old = this.blocks.flatMap((block) => block.levels.map((slot, level) => ({ block, slot, level })))
      .filter(({ slot, level }) => slot.points && level > 1 && slot.lastDrawn < this.frame - 30)
      .sort((a, b) => a.slot.lastDrawn - b.slot.lastDrawn);
    for (const { block, slot, level } of old) {
      if (this.resident <= 0.8 * maxResident) break;
      this.group.remove(slot.points!);
      slot.points!.geometry.dispose();
      slot.points = undefined;
      slot.state = 'none';
      this.resident -= block.counts![level];
    }
  }

  private lend(gone: Block, next: Block): void {
    next.counts = gone.counts;
    next.centre = gone.centre;
    next.radius = gone.radius;
    gone.levels.forEach((slot, level) => {
      next.levels[level].points = slot.points;
      if (slot.points) slot.points.material = next.material;
      if (slot.points && gone.counts) this.resident -= gone.counts[level];
    });
    gone.material.dispose();
  }

  private drop(block: Block): void {
    block.levels.forEach((slot, level) => {
      if (!slot.points) return;
      this.group.remove(slot.points);
      slot.points.geometry.dispose();
      this.resident -= block.counts?.[level] ?? 0;
    });
    block.material.dispose();
  }
}
