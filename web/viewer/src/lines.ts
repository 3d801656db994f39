// SPDX-License-Identifier: MIT
// The way of the robot, keyframes, edges, and the robot itself. All of it hangs on keyframes and moves with them.

import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { mapColour, palettes, rgb, stateColour, type Theme } from './colours';
import { compose, identity, inverse, poseAt } from './pose';
import type { Atlas, Edge, Pose, Scans } from './types';

const carried = new Set(['BRIDGING', 'LOST', 'RELOCATING']);

/** Wide lines, visible through what is in front of them, but faintly. */
class WideLines {
  readonly group = new THREE.Group();
  private readonly materials: LineMaterial[];
  private readonly meshes: LineSegments2[];
  private count = 0;
  private capacity = 0;

  constructor(width: number, isDashed = false) {
    const dashes = isDashed ? { dashed: true, dashSize: 1, gapSize: 0.7 } : {};
    const make = (more: object) => new LineMaterial({ linewidth: width, vertexColors: true, ...dashes, ...more });
    this.materials = [make({ depthTest: false, transparent: true, opacity: 0.3 }), make({})];
    this.meshes = this.materials.map((material) => new LineSegments2(new LineSegmentsGeometry(), material));
    for (const mesh of this.meshes) {
      mesh.frustumCulled = false;
      this.group.add(mesh);
    }
  }

  /** Ends of segments one after the other, and a colour for each end. */
  set(ends: Float32Array, colours: Float32Array): void {
    this.count = ends.length / 6;
    this.group.visible = this.count > 0;
    if (this.count === 0) return;
    if (this.count > this.capacity) {
      this.capacity = Math.ceil(1.3 * this.count);
      for (const mesh of this.meshes) {
        mesh.geometry.dispose();
        mesh.geometry = new LineSegmentsGeometry();
      }
    }
    const pad = (numbers: Float32Array) => {
      const padded = new Float32Array(6 * this.capacity);
      padded.set(numbers);
      return padded;
    };
    for (const mesh of this.meshes) {
      mesh.geometry.setPositions(pad(ends));
      mesh.geometry.setColors(pad(colours));
      if (this.materials[0].dashed) mesh.computeLineDistances();
    }
    this.show(this.count);
  }
  show(segments: number): void {
    for (const mesh of this.meshes) mesh.geometry.instanceCount = Math.min(segments, this.count);
  }
}

/** A scan hangs between two keyframes. */
interface Hook {
  a: number;
  b: number;
  s: number;
}

export class Lines {
  readonly group = new THREE.Group();
  readonly path = new WideLines(3);
  readonly edges = new WideLines(2);
  readonly gaps = new WideLines(1.5, true);
  readonly keyframes: THREE.Points<THREE.BufferGeometry, THREE.PointsMaterial>;
  readonly robot = new THREE.Group();
  colourBy: 'map' | 'state' = 'map';
  shownKinds = new Set<string>(['loop', 'merge', 'gap']);
  highlighted = -1;
  hidesPath = false;
  private hooks: Hook[] = [];
  private locals: { a: Pose; b: Pose }[] = [];
  private scanPoses = new Float64Array(0);

  constructor() {
    const material = new THREE.PointsMaterial({ size: 6, sizeAttenuation: false, vertexColors: true, transparent: true, opacity: 0.9 });
    this.keyframes = new THREE.Points(new THREE.BufferGeometry(), material);
    this.keyframes.frustumCulled = false;
    this.group.add(this.gaps.group, this.edges.group, this.path.group, this.keyframes, this.robot);
    this.makeRobot();
  }

  /** Hangs scans up, from one on; those before are known already.
   *  @param poses  of the keyframes, in the frame that the scans' poses are in
   *  @param isLive  each scan is in the frame of its own map */
  hang(scans: Scans, atlas: Atlas, poses: ArrayLike<number>, isLive: boolean, from = 0): void {
    const { t, map } = atlas.keyframes;
    const keep = Math.min(from, this.hooks.length);
    this.hooks.length = this.locals.length = keep;
    let next = 0;
    for (let i = keep; i < scans.t.length; ++i) {
      const T = poseAt(scans.pose, i);
      while (next < t.length && t[next] < scans.t[i]) ++next;
      const hook = isLive ? this.hookInMap(scans.map[i], map, next) : this.hookBetween(scans, i, t, map, next);
      this.hooks.push(hook);
      const local = (k: number) => (k < 0 ? T : compose(inverse(poseAt(poses, k)), T));
      this.locals.push({ a: local(hook.a), b: hook.b === hook.a ? identity : local(hook.b) });
    }
    const places = new Float64Array(7 * this.hooks.length);
    places.set(this.scanPoses.subarray(0, Math.min(7 * keep, this.scanPoses.length)));
    this.scanPoses = places;
  }

  private hookInMap(of: number, map: number[], next: number): Hook {
    let a = Math.min(next, map.length) - 1;
    while (a >= 0 && map[a] > of) --a;
    if (a < 0 || map[a] !== of) a = map.indexOf(of); // before the first keyframe of its map
    return { a, b: a, s: 0 };
  }

  private hookBetween(scans: Scans, i: number, t: number[], map: number[], next: number): Hook {
    if (t.length === 0) return { a: -1, b: -1, s: 0 };
    const b = Math.min(next, t.length - 1), a = Math.max(0, next - 1);
    const span = t[b] - t[a];
    let s = span > 0 ? Math.min(1, Math.max(0, (scans.t[i] - t[a]) / span)) : 0;
    // A scan that was placed in a map belongs to that map alone.
    if (map[a] !== map[b] && !carried.has(scans.states[scans.state[i]])) s = scans.map[i] === map[b] ? 1 : 0;
    return { a, b, s };
  }

  /** Everything anew where the keyframes are now. */
  place(scans: Scans, atlas: Atlas, poses: Float64Array, theme: Theme, rows: number): void {
    this.placeScans(poses, rows);
    this.drawPath(scans, theme);
    this.drawKeyframes(atlas, poses, theme);
    this.drawEdges(atlas, poses, theme, rows);
  }

  /** What there is of it up to a time. */
  showUntil(scans: Scans, rows: number, t: number): void {
    let count = 0;
    while (count < this.hooks.length && scans.t[count] <= t) ++count;
    this.path.show(Math.max(0, count - 1));
    this.keyframes.geometry.setDrawRange(0, rows);
    this.robot.visible = count > 0;
    if (count === 0) return;
    const T = this.scanPose(count - 1);
    this.robot.position.set(T[0], T[1], T[2]);
    this.robot.quaternion.set(T[3], T[4], T[5], T[6]);
  }

  scanPose(i: number): Pose {
    return poseAt(this.scanPoses, i);
  }

  private placeScans(poses: Float64Array, rows: number): void {
    for (let i = 0; i < this.hooks.length; ++i) {
      const { a, b, s } = this.hooks[i];
      const T = a < 0 ? [...this.locals[i].a] : compose(poses.subarray(7 * a, 7 * a + 7), this.locals[i].a);
      if (s > 0 && b !== a && b < rows) {
        const U = compose(poses.subarray(7 * b, 7 * b + 7), this.locals[i].b);
        for (let k = 0; k < 3; ++k) T[k] += s * (U[k] - T[k]);
        if (s > 0.5) for (let k = 3; k < 7; ++k) T[k] = U[k];
      }
      this.scanPoses.set(T, 7 * i);
    }
  }

  private drawPath(scans: Scans, theme: Theme): void {
    const count = Math.max(0, this.hooks.length - 1);
    const ends = new Float32Array(6 * count), colours = new Float32Array(6 * count);
    for (let i = 0; i < count; ++i) {
      for (let k = 0; k < 3; ++k) {
        ends[6 * i + k] = this.scanPoses[7 * i + k];
        ends[6 * i + 3 + k] = this.scanPoses[7 * (i + 1) + k];
      }
      const state = scans.states[scans.state[i + 1]];
      const byState = this.colourBy === 'state' || carried.has(state);
      const c = rgb(byState ? stateColour(theme, state) : mapColour(theme, scans.map[i + 1]));
      colours.set(c, 6 * i);
      colours.set(c, 6 * i + 3);
    }
    this.path.set(ends, colours);
    if (this.hidesPath) this.path.group.visible = false;
  }

  private drawKeyframes(atlas: Atlas, poses: Float64Array, theme: Theme): void {
    const count = atlas.keyframes.id.length;
    const at = new Float32Array(3 * count), colours = new Float32Array(3 * count);
    for (let i = 0; i < count; ++i) {
      for (let k = 0; k < 3; ++k) at[3 * i + k] = poses[7 * i + k];
      colours.set(rgb(mapColour(theme, atlas.keyframes.map[i])), 3 * i);
    }
    const geometry = this.keyframes.geometry;
    geometry.setAttribute('position', new THREE.BufferAttribute(at, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  }

  private drawEdges(atlas: Atlas, poses: Float64Array, theme: Theme, rows: number): void {
    const rowOf = new Map(atlas.keyframes.id.map((id, i) => [id, i]));
    const palette = palettes[theme];
    const solid: number[] = [], solidColours: number[] = [], dashed: number[] = [], dashedColours: number[] = [];
    for (const edge of atlas.edges) {
      const from = rowOf.get(edge.from), to = rowOf.get(edge.to);
      if (from === undefined || to === undefined || from >= rows || to >= rows || !this.isShown(edge)) continue;
      const [ends, colours] = edge.kind === 'gap' ? [dashed, dashedColours] : [solid, solidColours];
      ends.push(...poses.subarray(7 * from, 7 * from + 3), ...poses.subarray(7 * to, 7 * to + 3));
      let c = rgb(edge.weight <= 0 ? palette.rejected : palette[edge.kind]);
      if (edge.closure >= 0 && edge.closure === this.highlighted) c = rgb(palette.measure);
      colours.push(...c, ...c);
    }
    this.edges.set(new Float32Array(solid), new Float32Array(solidColours));
    this.gaps.set(new Float32Array(dashed), new Float32Array(dashedColours));
  }

  private isShown(edge: Edge): boolean {
    if (edge.weight <= 0) return this.shownKinds.has('rejected');
    return this.shownKinds.has(edge.kind);
  }

  private makeRobot(): void {
    const axis = (colour: string, x: number, y: number, z: number) => {
      const geometry = new THREE.CylinderGeometry(0.05, 0.05, 1, 10).translate(0, 0.5, 0);
      const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true }));
      mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(x, y, z));
      mesh.renderOrder = 5;
      this.robot.add(mesh);
    };
    axis('#ff5a4d', 1, 0, 0);
    axis('#45d06e', 0, 1, 0);
    axis('#4d9bff', 0, 0, 1);
  }
}
