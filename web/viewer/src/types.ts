// SPDX-License-Identifier: MIT
// What the server sends, as docs/formats.md describes it. Times in seconds since the beginning, lengths in metres; a pose
// is x, y, z, qx, qy, qz, qw.

export type Pose = number[];

export interface MapInfo {
  id: number;
  world: number;
  active: boolean;
  began: string;
  ended: string;
  begin: number;
  last: number;
  anchor: Pose;
}

/** Columns, a row for each keyframe; poses one after the other. */
export interface Keyframes {
  id: number[];
  map: number[];
  points: number[];
  t: number[];
  odometry: number[];
  optimised: number[];
}

export interface ClosureEvidence {
  origin?: string;
  score?: number;
  overlap?: number;
  residual_rms_m?: number;
  reason?: string;
}

export interface Edge {
  from: number;
  to: number;
  kind: 'loop' | 'merge' | 'gap';
  weight: number;
  closure: number;
  evidence: ClosureEvidence | null;
  T_from_to: Pose;
}

export interface Merge {
  id: number;
  t: number;
  map: number;
  into: number;
  kind: string;
  undone: boolean;
  evidence: { closures?: number[]; enhancing?: number[]; motion_between_was_known?: boolean; [key: string]: unknown } | null;
  before: Pose;
  after: Pose;
}

export interface Atlas {
  maps: MapInfo[];
  keyframes: Keyframes;
  edges: Edge[];
  merges: Merge[];
  /** Map, first and last keyframe, number of points. */
  blocks: [number, number, number, number][];
}

export interface Scans {
  from: number;
  states: string[];
  causes: string[];
  t: number[];
  map: number[];
  state: number[];
  cause: number[];
  ms: number[];
  pose: number[];
}

export interface Summary {
  duration_s?: number;
  path_length_m?: number;
  scans?: number;
  stages?: { total?: { mean_ms: number; p99_ms: number } };
  [key: string]: unknown;
}

export interface SceneMessage {
  format: number;
  name: string;
  live: boolean;
  begin: string;
  summary: Summary | null;
  atlas: Atlas;
  scans: Scans;
}

/** News of a run that goes on: any of these. */
export interface LiveMessage {
  atlas?: Atlas;
  scans?: Scans;
  ended?: boolean;
}
