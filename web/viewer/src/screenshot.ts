// SPDX-License-Identifier: MIT
// The picture as a PNG file, with what is measured and one line about what it shows.

import { palettes, type Theme } from './colours';
import type { Labels } from './measure';
import type { Stage } from './stage';

export function takeScreenshot(stage: Stage, labels: Labels, theme: Theme, name: string, t: number): void {
  stage.render(8e6, true); // the drawing buffer is only kept until this task ends
  const source = stage.renderer.domElement;
  const canvas = document.createElement('canvas');
  canvas.width = source.width;
  canvas.height = source.height;
  const context = canvas.getContext('2d')!;
  const ratio = source.width / source.clientWidth;
  const palette = palettes[theme];
  context.drawImage(source, 0, 0);
  context.scale(ratio, ratio);
  context.font = '600 13px system-ui, sans-serif';
  context.lineWidth = 4;
  context.lineJoin = 'round';
  const write = (text: string, x: number, y: number) => {
    context.strokeStyle = palette.background;
    context.fillStyle = palette.ink;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  };
  for (const label of labels.texts()) label.text.split('\n').forEach((line, i) => write(line, label.x + 12, label.y + 20 + 16 * i));
  write(`${name}, ${t.toFixed(1)} s`, 14, source.clientHeight - 14);
  canvas.toBlob((blob) => {
    if (!blob) return;
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = `${name}_${t.toFixed(1)}s.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }, 'image/png');
}
