// SPDX-License-Identifier: MIT
// Fetches tiles, few at a time, the most wanted first.

export interface Tile {
  level: number;
  /** Points of each level of the block, and the distance that they keep [m]. */
  counts: number[];
  cells: number[];
  /** Of the block, in the frame of its middle keyframe. */
  centre: [number, number, number];
  radius: number;
  /** x, y, z in steps of 4 mm, and keyframe, less the first of the block. */
  places: Int16Array;
  intensities: Uint16Array;
}

export function decodeTile(buffer: ArrayBuffer): Tile {
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== 0x31544d4d) throw new Error('this is no tile');
  const level = view.getUint32(4, true);
  const numLevels = view.getUint32(8, true);
  const counts: number[] = [], cells: number[] = [];
  for (let i = 0; i < numLevels; ++i) {
    counts.push(view.getUint32(12 + 8 * i, true));
    cells.push(view.getFloat32(16 + 8 * i, true));
  }
  const after = 12 + 8 * numLevels;
  const number = (i: number) => view.getFloat32(after + 4 * i, true);
  const begin = after + 16;
  return {
    level, counts, cells,
    centre: [number(0), number(1), number(2)],
    radius: number(3),
    places: new Int16Array(buffer, begin, 4 * counts[level]),
    intensities: new Uint16Array(buffer, begin + 8 * counts[level], counts[level]),
  };
}

interface Wish {
  url: string;
  priority: number;
  take: (tile: Tile) => void;
  fail: () => void;
}

export class TileQueue {
  private wishes = new Map<string, Wish>();
  private readonly running = new Set<string>();

  constructor(private readonly atOnce = 6) {}

  /** What is wanted now, instead of what was and has not been begun. */
  want(wishes: Wish[]): void {
    this.wishes = new Map(wishes.filter((wish) => !this.running.has(wish.url)).map((wish) => [wish.url, wish]));
    this.next();
  }

  get isIdle(): boolean {
    return this.running.size === 0 && this.wishes.size === 0;
  }

  private next(): void {
    while (this.running.size < this.atOnce && this.wishes.size > 0) {
      let best: Wish | undefined;
      for (const wish of this.wishes.values()) if (!best || wish.priority > best.priority) best = wish;
      this.wishes.delete(best!.url);
      void this.fetch(best!);
    }
  }

  private async fetch(wish: Wish): Promise<void> {
    this.running.add(wish.url);
    try {
      const response = await fetch(wish.url);
      if (!response.ok) throw new Error(await response.text());
      if (response.status !== 204) wish.take(decodeTile(await response.arrayBuffer())); // 204: not now
    } catch {
      wish.fail();
    }
    this.running.delete(wish.url);
    this.next();
  }
}
