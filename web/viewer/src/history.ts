// SPDX-License-Identifier: MIT
// Where every keyframe lay at a moment of the run, as far as it was known then: before a map was corrected for the first
// time it lies as the odometry and the gap before it had it; a merge moves it into the world of another; at the end
// everything is where the last optimisation left it.

import { compose, identity, inverse, poseAt } from './pose';
import type { Atlas, Edge, Merge, Pose } from './types';

interface Move {
  merge: Merge;
  maps: Set<number>;
  joined: Set<number>;
  back: Pose;
}

export class History {
  readonly indexOf = new Map<number, number>();
  readonly merges: Merge[];
  private readonly moves: Move[] = [];
  private readonly corrections = new Map<number, number[]>();
  private readonly gaps = new Map<number, Edge>();
  private readonly firstOf = new Map<number, number>();
  private readonly byGap = new Map<number, Pose>();

  constructor(readonly atlas: Atlas) {
    const { keyframes } = atlas;
    keyframes.id.forEach((id, i) => {
      this.indexOf.set(id, i);
      if (!this.firstOf.has(keyframes.map[i])) this.firstOf.set(keyframes.map[i], i);
    });
    this.merges = atlas.merges.filter((merge) => !merge.undone).sort((a, b) => a.t - b.t || a.id - b.id);
    this.followMerges();
    this.findCorrections();
  }

  get numKeyframes(): number {
    return this.atlas.keyframes.id.length;
  }

  /** Moments at which anything is moved. */
  get events(): number[] {
    const times = new Set<number>(this.merges.map((merge) => merge.t));
    for (const list of this.corrections.values()) list.forEach((t) => times.add(t));
    return [...times].sort((a, b) => a - b);
  }

  /** The world of each map at a time; `without`: as if that merge had not been made. */
  worldsAt(t: number, without?: Merge): Map<number, number> {
    const worlds = new Map(this.atlas.maps.map((map) => [map.id, map.id]));
    for (const { merge, maps } of this.moves) {
      if (merge.t > t || merge === without) continue;
      for (const map of maps) worlds.set(map, merge.into);
    }
    return worlds;
  }

  /** Maps that a merge moved, and those that they were joined to. */
  sidesOf(merge: Merge): { moved: Set<number>; into: Set<number> } {
    const move = this.moves.find((one) => one.merge.id === merge.id);
    return { moved: move?.maps ?? new Set([merge.map]), into: move?.joined ?? new Set([merge.into]) };
  }

  /** Poses of all keyframes in the frame of the first map, one after the other.
   *  @param without  as if this merge had not been made
   *  @param anyway   as if this one, which was taken back, stood */
  posesAt(t: number, without?: Merge, anyway?: Merge): Float64Array<ArrayBuffer> {
    const { keyframes, maps } = this.atlas;
    const frames = new Map<number, { T: Pose; optimised: boolean }>();
    for (const map of maps) {
      const optimised = this.isCorrected(map.id, t, without);
      let T = optimised ? this.anchorAt(map.id, t, without) : this.placeByGap(map.id);
      if (anyway && map.id === anyway.map) T = compose(compose(anyway.after, inverse(anyway.before)), T);
      frames.set(map.id, { T, optimised });
    }
    const poses = new Float64Array(7 * keyframes.id.length);
    for (let i = 0; i < keyframes.id.length; ++i) {
      const frame = frames.get(keyframes.map[i]);
      if (!frame) continue;
      poses.set(compose(frame.T, poseAt(frame.optimised ? keyframes.optimised : keyframes.odometry, i)), 7 * i);
    }
    return poses;
  }

  private followMerges(): void {
    const worlds = new Map(this.atlas.maps.map((map) => [map.id, map.id]));
    for (const merge of this.merges) {
      const of = (world: number) => new Set([...worlds].filter(([, w]) => w === world).map(([map]) => map));
      const maps = of(worlds.get(merge.map) ?? merge.map);
      const joined = of(worlds.get(merge.into) ?? merge.into);
      this.moves.push({ merge, maps, joined, back: compose(merge.before, inverse(merge.after)) });
      for (const map of maps) worlds.set(map, worlds.get(merge.into) ?? merge.into);
    }
  }

  private findCorrections(): void {
    const { keyframes, edges } = this.atlas;
    const add = (map: number, t: number) => this.corrections.set(map, [...(this.corrections.get(map) ?? []), t]);
    for (const edge of edges) {
      const from = this.indexOf.get(edge.from), to = this.indexOf.get(edge.to);
      if (from === undefined || to === undefined) continue;
      if (edge.kind === 'gap') this.gaps.set(keyframes.map[to], edge);
      if (edge.kind !== 'loop' || edge.weight <= 0) continue;
      if (keyframes.map[from] === keyframes.map[to]) add(keyframes.map[from], Math.max(keyframes.t[from], keyframes.t[to]));
    }
    for (const { merge, maps, joined } of this.moves) [...maps, ...joined].forEach((map) => add(map, merge.t));
    for (const list of this.corrections.values()) list.sort((a, b) => a - b);
  }

  private isCorrected(map: number, t: number, without?: Merge): boolean {
    const times = this.corrections.get(map);
    if (!times) return true; // it never was: the last poses are those of the odometry
    return times.some((time) => time <= t && !(without && time === without.t));
  }

  private anchorAt(map: number, t: number, without?: Merge): Pose {
    let T = this.atlas.maps.find((one) => one.id === map)?.anchor ?? identity;
    for (let i = this.moves.length - 1; i >= 0; --i) {
      const { merge, maps, back } = this.moves[i];
      if ((merge.t > t || merge === without) && maps.has(map)) T = compose(back, T);
    }
    return T;
  }

  private placeByGap(map: number): Pose {
    const known = this.byGap.get(map);
    if (known) return known;
    const { keyframes } = this.atlas;
    const gap = this.gaps.get(map), first = this.firstOf.get(map);
    let T = this.anchorAt(map, -Infinity);
    this.byGap.set(map, T);
    if (gap && first !== undefined) {
      const before = this.indexOf.get(gap.from)!, after = this.indexOf.get(gap.to)!;
      const map_before = keyframes.map[before];
      const corrected = this.isCorrected(map_before, keyframes.t[after]);
      const T_before = compose(
        corrected ? this.anchorAt(map_before, keyframes.t[after]) : this.placeByGap(map_before),
        poseAt(corrected ? keyframes.optimised : keyframes.odometry, before),
      );
      T = compose(compose(T_before, gap.T_from_to), inverse(poseAt(keyframes.odometry, after)));
    }
    this.byGap.set(map, T);
    return T;
  }
}
