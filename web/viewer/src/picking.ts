// SPDX-License-Identifier: MIT
// Which point is under the pointer: a few pixels around it are drawn with coordinates instead of colours.

import * as THREE from 'three';
import { pointFragment, pointVertex } from './shaders';
import type { Stage } from './stage';

const size = 15; // px

export class Picker {
  private readonly target = new THREE.WebGLRenderTarget(size, size, {
    type: THREE.FloatType, format: THREE.RGBAFormat, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter,
  });
  private readonly materials = new WeakMap<THREE.Material, THREE.RawShaderMaterial>();

  constructor(private readonly stage: Stage) {}

  /** @param x, y  in CSS pixels from the upper left corner of the picture; null if there is no point */
  at(x: number, y: number): [number, number, number] | null {
    const { renderer, camera, pointScene } = this.stage;
    const { clientWidth, clientHeight } = renderer.domElement;
    const ratio = this.stage.height / clientHeight;
    const half = (size - 1) / 2;
    camera.setViewOffset(Math.round(clientWidth * ratio), Math.round(clientHeight * ratio), Math.round(x * ratio) - half,
      Math.round(y * ratio) - half, size, size);
    const originals = new Map<THREE.Points, THREE.Material>();
    pointScene.traverseVisible((node) => {
      if (!(node instanceof THREE.Points)) return;
      originals.set(node, node.material as THREE.Material);
      node.material = this.materialFor(node.material as THREE.RawShaderMaterial);
    });
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.render(pointScene, camera);
    const pixels = new Float32Array(4 * size * size);
    renderer.readRenderTargetPixels(this.target, 0, 0, size, size, pixels);
    renderer.setRenderTarget(null);
    camera.clearViewOffset();
    for (const [node, material] of originals) node.material = material;
    return this.nearest(pixels, half);
  }

  private nearest(pixels: Float32Array, half: number): [number, number, number] | null {
    let best: [number, number, number] | null = null;
    let least = Infinity;
    for (let row = 0; row < size; ++row) {
      for (let column = 0; column < size; ++column) {
        const at = 4 * (row * size + column);
        const distance = Math.hypot(row - half, column - half);
        if (pixels[at + 3] < 0.5 || distance >= least || distance > half) continue;
        least = distance;
        best = [pixels[at], pixels[at + 1], pixels[at + 2]];
      }
    }
    return best;
  }

  private materialFor(material: THREE.RawShaderMaterial): THREE.RawShaderMaterial {
    let own = this.materials.get(material);
    if (!own) {
      own = new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3, vertexShader: pointVertex, fragmentShader: pointFragment, uniforms: material.uniforms, defines: { PICK: 1 },
      });
      this.materials.set(material, own);
    }
    return own;
  }
}
