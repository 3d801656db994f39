// SPDX-License-Identifier: MIT
// Distances between points that are clicked, two by two, and labels that stay where things are.

import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { byId, el, metres } from './dom';
import type { Stage } from './stage';

type Point = [number, number, number];

interface Label {
  node: HTMLElement;
  /** Null: nowhere at present. */
  at: () => ArrayLike<number> | null;
}

/** Elements over the picture. */
export class Labels {
  private labels: Label[] = [];

  constructor(private readonly stage: Stage) {}

  add(node: HTMLElement, at: Label['at']): void {
    byId('labels').append(node);
    this.labels.push({ node, at });
  }
  remove(kind: string): void {
    this.labels = this.labels.filter(({ node }) => {
      if (!node.classList.contains(kind)) return true;
      node.remove();
      return false;
    });
  }
  place(): void {
    for (const { node, at } of this.labels) {
      const p = at();
      const where = p && this.stage.project(p);
      node.hidden = where === null;
      if (where) node.style.transform = `translate(${where.x.toFixed(1)}px, ${where.y.toFixed(1)}px)`;
    }
  }
  /** What stands where, for a picture of it. */
  texts(): { text: string; x: number; y: number }[] {
    return this.labels.filter(({ node }) => !node.hidden && node.classList.contains('measure'))
      .map(({ node, at }) => ({ text: node.innerText, ...this.stage.project(at()!)! }));
  }
}

export class Measure {
  isOn = false;
  private first: Point | null = null;
  private readonly ends: number[] = [];
  private readonly dots = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ size: 9, sizeAttenuation: false, depthTest: false, transparent: true }));
  private readonly material = new LineMaterial({ linewidth: 2.5, depthTest: false, transparent: true });
  private readonly line = new LineSegments2(new LineSegmentsGeometry(), this.material);

  constructor(private readonly stage: Stage, private readonly labels: Labels) {
    this.dots.frustumCulled = this.line.frustumCulled = false;
    this.dots.renderOrder = this.line.renderOrder = 9;
    this.line.visible = false;
    stage.lineScene.add(this.line, this.dots);
  }

  setColour(colour: string): void {
    this.material.color.set(colour);
    this.dots.material.color.set(colour);
  }

  toggle(on = !this.isOn): void {
    this.isOn = on;
    if (!on) this.clear();
    byId('measure').setAttribute('aria-pressed', String(on));
    byId('hint').textContent = on ? 'Click two points; Escape ends it' : '';
    this.stage.renderer.domElement.classList.toggle('aiming', on);
  }

  clear(): void {
    this.first = null;
    this.ends.length = 0;
    this.labels.remove('measure');
    this.draw(null);
  }

  /** A point was clicked. */
  add(p: Point): void {
    if (!this.first) {
      this.first = p;
      this.draw(p);
      return;
    }
    const a = this.first;
    this.first = null;
    this.ends.push(...a, ...p);
    const d = [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    const label = el('div', { class: 'label measure' }, el('b', {}, metres(Math.hypot(...d))),
      el('span', {}, `level ${metres(Math.hypot(d[0], d[1]))} \u00b7 up ${d[2] < 0 ? '\u2212' : ''}${metres(Math.abs(d[2]))}`));
    this.labels.add(label, () => [(a[0] + p[0]) / 2, (a[1] + p[1]) / 2, (a[2] + p[2]) / 2]);
    this.draw(null);
  }

  private draw(pending: Point | null): void {
    const dots = pending ? [...this.ends, ...pending] : this.ends;
    this.dots.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(dots), 3));
    this.dots.geometry.setDrawRange(0, dots.length / 3);
    this.line.visible = this.ends.length > 0;
    if (this.line.visible) {
      this.line.geometry.dispose();
      this.line.geometry = new LineSegmentsGeometry().setPositions(new Float32Array(this.ends));
    }
    this.stage.invalidate();
  }
}
