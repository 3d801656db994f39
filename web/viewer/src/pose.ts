// SPDX-License-Identifier: MIT
// Poses as x, y, z, qx, qy, qz, qw.

import type { Pose } from './types';

export const identity: Pose = [0, 0, 0, 0, 0, 0, 1];

export function rotate(q: ArrayLike<number>, x: number, y: number, z: number, at = 3): [number, number, number] {
  const qx = q[at], qy = q[at + 1], qz = q[at + 2], qw = q[at + 3];
  const cx = 2 * (qy * z - qz * y), cy = 2 * (qz * x - qx * z), cz = 2 * (qx * y - qy * x);
  return [x + qw * cx + qy * cz - qz * cy, y + qw * cy + qz * cx - qx * cz, z + qw * cz + qx * cy - qy * cx];
}

export function apply(T: ArrayLike<number>, p: ArrayLike<number>): [number, number, number] {
  const r = rotate(T, p[0], p[1], p[2]);
  return [r[0] + T[0], r[1] + T[1], r[2] + T[2]];
}

export function compose(a: ArrayLike<number>, b: ArrayLike<number>): Pose {
  const p = apply(a, b);
  const [ax, ay, az, aw] = [a[3], a[4], a[5], a[6]];
  const [bx, by, bz, bw] = [b[3], b[4], b[5], b[6]];
  return [
    p[0], p[1], p[2],
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export function inverse(T: ArrayLike<number>): Pose {
  const q = [-T[3], -T[4], -T[5], T[6]];
  const p = rotate(q, T[0], T[1], T[2], 0);
  return [-p[0], -p[1], -p[2], q[0], q[1], q[2], q[3]];
}

/** Straight and at even speed from a to b. */
export function between(a: ArrayLike<number>, b: ArrayLike<number>, s: number): Pose {
  const dot = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6];
  const sign = dot < 0 ? -1 : 1;
  const out: Pose = [0, 1, 2, 3, 4, 5, 6].map((i) => a[i] * (1 - s) + (i < 3 ? b[i] : sign * b[i]) * s);
  const norm = Math.hypot(out[3], out[4], out[5], out[6]) || 1;
  for (let i = 3; i < 7; ++i) out[i] /= norm;
  return out;
}

/** The i-th of poses one after the other. */
export function poseAt(poses: ArrayLike<number>, i: number): Pose {
  return Array.prototype.slice.call(poses, 7 * i, 7 * i + 7) as Pose;
}

/** How far a pose moves what is near its origin, and by what angle it turns it: metres and degrees. */
export function amount(T: ArrayLike<number>): { metres: number; degrees: number } {
  const sine = Math.hypot(T[3], T[4], T[5]);
  return { metres: Math.hypot(T[0], T[1], T[2]), degrees: (2 * Math.atan2(sine, Math.abs(T[6])) * 180) / Math.PI };
}
