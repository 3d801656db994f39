// SPDX-License-Identifier: MIT
// The palette, the same as that of report.html, and ramps.

export type Theme = 'dark' | 'light';

interface Palette {
  background: string;
  backgroundTop: string;
  ink: string;
  soft: string;
  maps: string[];
  states: Record<string, string>;
  loop: string;
  merge: string;
  gap: string;
  rejected: string;
  moved: string;
  into: string;
  measure: string;
}

export const palettes: Record<Theme, Palette> = {
  dark: {
    background: '#0d1014', backgroundTop: '#1b2129', ink: '#e8ebee', soft: '#9aa4af',
    maps: ['#4aa8e8', '#f0a83c', '#2fcf9f', '#e58abf', '#8fd0ff', '#ff8a4c', '#b09af0', '#d6c25a'],
    states: { INITIALIZING: '#8a929b', TRACKING: '#4aa8e8', DEGRADED: '#f2c94c', BRIDGING: '#ff8a4c', LOST: '#ff5fa8', RELOCATING: '#e2b0d0' },
    loop: '#7ee787', merge: '#ff7ac6', gap: '#c9d2dc', rejected: '#ff5f57', moved: '#ffab3d', into: '#45b3ff', measure: '#ffe066',
  },
  light: {
    background: '#eceff2', backgroundTop: '#ffffff', ink: '#15191e', soft: '#5a636e',
    maps: ['#0072b2', '#d98200', '#009e73', '#c0508f', '#3fa0dc', '#b94a00', '#6a51a3', '#7a6a00'],
    states: { INITIALIZING: '#8a929b', TRACKING: '#0072b2', DEGRADED: '#e0a100', BRIDGING: '#d55e00', LOST: '#8c1d5c', RELOCATING: '#cc79a7' },
    loop: '#1a8f3c', merge: '#b0207d', gap: '#39424e', rejected: '#c62828', moved: '#d97a00', into: '#0068b5', measure: '#7a4f00',
  },
};

export function mapColour(theme: Theme, map: number): string {
  const { maps } = palettes[theme];
  return maps[map % maps.length];
}

export function stateColour(theme: Theme, state: string): string {
  return palettes[theme].states[state] ?? palettes[theme].soft;
}

export function rgb(hex: string): [number, number, number] {
  const value = parseInt(hex.slice(1), 16);
  return [((value >> 16) & 255) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** From low to high, readable on dark and on light. */
export const ramps: Record<Theme, string[]> = {
  dark: ['#3b4cc0', '#2f8bd6', '#22b8b0', '#5fd06b', '#c8dc3c', '#ffc03a', '#ff7a45', '#f0483e'],
  light: ['#2a2f86', '#2467ad', '#128a8f', '#2f9a4a', '#8a9a10', '#cf8a00', '#d1561c', '#a81e22'],
};
/** For intensity. */
export const greys: Record<Theme, string[]> = {
  dark: ['#39424e', '#6b7683', '#a3adb8', '#ffffff'],
  light: ['#b9c0c8', '#848d98', '#4a525c', '#0b0d10'],
};

/** A ramp as `count` colours, RGBA bytes. */
export function rampBytes(stops: string[], count = 256): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(4 * count);
  for (let i = 0; i < count; ++i) {
    const at = (i / (count - 1)) * (stops.length - 1);
    const k = Math.min(Math.floor(at), stops.length - 2);
    const a = rgb(stops[k]), b = rgb(stops[k + 1]);
    for (let c = 0; c < 3; ++c) bytes[4 * i + c] = Math.round(255 * (a[c] + (b[c] - a[c]) * (at - k)));
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}
