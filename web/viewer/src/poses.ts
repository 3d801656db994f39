// SPDX-License-Identifier: MIT
// Where each keyframe is drawn at this moment: on its way from where it was to where it should be. A texture that the
// shader of the points reads, and numbers for everything else.

import * as THREE from 'three';
import { between } from './pose';

const width = 1023; // a multiple of the texels of a keyframe
const perKeyframe = 3;
const seconds = 0.8;

export class PoseTable {
  texture: THREE.DataTexture;
  current = new Float64Array(0);
  private numbers: Float32Array<ArrayBuffer>;
  private from = new Float64Array(0);
  private target = new Float64Array(0);
  private begun = -1;

  constructor() {
    this.numbers = new Float32Array(4 * width);
    this.texture = this.makeTexture();
  }

  get count(): number {
    return this.current.length / 7;
  }

  /** Where keyframes shall be. Those that are new are there at once. */
  moveTo(target: Float64Array<ArrayBuffer>, now: number, slowly: boolean): void {
    const known = this.current.length;
    const current = new Float64Array(target);
    current.set(this.current.subarray(0, Math.min(known, target.length)));
    this.current = current;
    this.from = current.slice();
    this.target = target;
    const moves = current.some((value, i) => Math.abs(value - target[i]) > 1e-3);
    this.begun = slowly && moves ? now : -1;
    if (this.begun < 0) this.current = target.slice();
    this.reserve(target.length / 7);
    this.writePoses();
  }

  /** @return whether anything has moved */
  advance(now: number): boolean {
    if (this.begun < 0) return false;
    const share = Math.min(1, (now - this.begun) / (1000 * seconds));
    const eased = share * share * (3 - 2 * share);
    for (let i = 0; i < this.current.length; i += 7) {
      const a = this.from.subarray(i, i + 7), b = this.target.subarray(i, i + 7);
      this.current.set(share >= 1 ? b : between(a, b, eased), i);
    }
    if (share >= 1) this.begun = -1;
    this.writePoses();
    return true;
  }

  /** Of each keyframe: 1 if it is awake, less if it sleeps; map; time; side of a merge; whether it is shown. */
  setLooks(look: (i: number) => [awake: number, map: number, time: number, side: number, shown: number]): void {
    for (let i = 0; i < this.count; ++i) {
      const [awake, map, time, side, shown] = look(i);
      const at = 4 * perKeyframe * i;
      this.numbers[at + 7] = awake;
      this.numbers.set([map, time, side, shown], at + 8);
    }
    this.texture.needsUpdate = true;
  }

  private writePoses(): void {
    for (let i = 0; i < this.count; ++i) {
      const at = 4 * perKeyframe * i;
      for (let k = 0; k < 4; ++k) this.numbers[at + k] = this.current[7 * i + 3 + k];
      for (let k = 0; k < 3; ++k) this.numbers[at + 4 + k] = this.current[7 * i + k];
    }
    this.texture.needsUpdate = true;
  }

  private reserve(count: number): void {
    const rows = Math.ceil((count * perKeyframe) / width) || 1;
    if (4 * width * rows <= this.numbers.length) return;
    const grown = new Float32Array(4 * width * Math.ceil(1.5 * rows));
    grown.set(this.numbers);
    this.numbers = grown;
    this.texture.dispose();
    this.texture = this.makeTexture();
  }

  private makeTexture(): THREE.DataTexture {
    const texture = new THREE.DataTexture(this.numbers, width, this.numbers.length / 4 / width, THREE.RGBAFormat, THREE.FloatType);
    texture.minFilter = texture.magFilter = THREE.NearestFilter;
    texture.needsUpdate = true;
    return texture;
  }
}
