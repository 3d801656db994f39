// SPDX-License-Identifier: MIT
// Camera, controls, and how a picture is made: points into a buffer, relief from their depths, lines on top. Pictures are
// made only when something has changed.

import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { palettes, type Theme } from './colours';
import { screenFragment, screenVertex } from './shaders';

/** A picture should be made so fast while things move [ms]. */
const wantedMs = 33;
/** Points of a picture at rest, at least. */
const restBudget = 1.2e6;

/** Drawn by the processor, and so slowly that it is better to know at once. */
function drawsInSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const more = gl?.getExtension('WEBGL_debug_renderer_info');
  return Boolean(gl && more && /swiftshader|llvmpipe|software/i.test(String(gl.getParameter(more.UNMASKED_RENDERER_WEBGL))));
}

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(50, 1, 0.1, 1000);
  readonly controls: OrbitControls;
  readonly pointScene = new THREE.Scene();
  readonly lineScene = new THREE.Scene();
  relief = true;
  /** By somebody who would not like the camera to move by itself. */
  isSteered = false;
  /** Points per picture while things move; at rest there may be more. */
  budget = 1.5e6;
  framesPerSecond = 0;
  private readonly isSoftware: boolean;
  private readonly target: THREE.WebGLRenderTarget;
  private readonly screen: THREE.ShaderMaterial;
  private readonly screenScene = new THREE.Scene();
  private readonly screenCamera = new THREE.Camera();
  /** Share of the resolution, at present and while things move: less where even few points take too long. */
  private scale = 1;
  private movingScale = 1;
  private isDirty = true;
  private isStale = false;
  private lastPicture = 0;
  private lastCost = 0;
  private lastFrame = 0;
  private lastMotion = 0;
  private wasRefined = false;
  private glide: { from: THREE.Vector3[]; to: THREE.Vector3[]; begun: number } | null = null;
  private extent = 100;

  constructor(
    private readonly holder: HTMLElement,
    private readonly before: (now: number) => boolean,
    private readonly choose: (budget: number) => void,
    private readonly after: () => void,
  ) {
    THREE.ColorManagement.enabled = false;
    this.isSoftware = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.isSoftware, powerPreference: 'high-performance' });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.autoClear = false;
    this.renderer.domElement.tabIndex = 0;
    this.renderer.domElement.setAttribute('aria-label', 'The map in three dimensions');
    holder.prepend(this.renderer.domElement);
    this.target = new THREE.WebGLRenderTarget(4, 4, { minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    this.target.depthTexture = new THREE.DepthTexture(4, 4, THREE.FloatType);
    this.screen = this.makeScreen();
    if (this.isSoftware) {
      this.budget = 1e5;
      this.movingScale = 0.5;
    }
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, zoomToCursor: true, maxPolarAngle: Math.PI * 0.98, zoomSpeed: 1.3 });
    this.controls.listenToKeyEvents(this.renderer.domElement);
    this.controls.addEventListener('change', () => this.moved());
    this.controls.addEventListener('start', () => { this.isSteered = true; });
    this.renderer.domElement.addEventListener('wheel', () => { this.isSteered = true; }, { passive: true });
    new ResizeObserver(() => this.resize()).observe(holder);
    this.resize();
    requestAnimationFrame((now) => this.frame(now));
  }

  get height(): number {
    return this.target.height;
  }

  /** The picture is as good as it gets. */
  get isAtRest(): boolean {
    return this.wasRefined && !this.isDirty && !this.isStale && this.glide === null && performance.now() - this.lastMotion > 250;
  }

  /** Something looks different now. */
  invalidate(): void {
    this.isDirty = true;
    this.wasRefined = false;
  }
  /** More has come to be drawn: now and then is enough. */
  invalidateSoon(): void {
    this.isStale = true;
    this.wasRefined = false;
  }
  /** Something moves, so that speed counts. */
  moved(): void {
    this.lastMotion = performance.now();
    this.invalidate();
  }

  setTheme(theme: Theme): void {
    const palette = palettes[theme];
    const { low, high, shade, strength } = this.screen.uniforms;
    low.value.set(palette.background);
    high.value.set(palette.backgroundTop);
    shade.value.set(theme === 'dark' ? '#000000' : '#1d2630');
    strength.value = theme === 'dark' ? 14 : 9;
    this.invalidate();
  }

  /** Looks at a box from where all of it can be seen; its longer side lies across. */
  show(box: THREE.Box3, from: 'aslant' | 'above', atOnce = false): void {
    const centre = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    this.extent = Math.max(size.length(), 10);
    const across = size.x >= size.y ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, -1, 0);
    const away = new THREE.Vector3(across.y, -across.x, 0);
    const direction = from === 'above'
      ? new THREE.Vector3(0, 0, 1).addScaledVector(away, 0.001)
      : away.multiplyScalar(0.66).addScaledVector(across, 0.2).add(new THREE.Vector3(0, 0, 0.7));
    direction.normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(direction).normalize();
    const up = direction.clone().cross(right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360) * 0.94;
    let distance = 5;
    for (let corner = 0; corner < 8; ++corner) {
      const p = new THREE.Vector3(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5).multiply(size);
      const needed = Math.max(Math.abs(p.dot(right)) / (tall * this.camera.aspect), Math.abs(p.dot(up)) / tall);
      distance = Math.max(distance, needed + p.dot(direction));
    }
    this.moveCamera(centre.clone().addScaledVector(direction, distance), centre, atOnce);
  }

  moveCamera(position: THREE.Vector3, target: THREE.Vector3, atOnce = false): void {
    if (atOnce) {
      this.camera.position.copy(position);
      this.controls.target.copy(target);
      this.glide = null;
    } else {
      this.glide = { from: [this.camera.position.clone(), this.controls.target.clone()], to: [position, target], begun: performance.now() };
    }
    this.moved();
  }

  /** Where a point is on the page, in CSS pixels; null if it is behind the camera. */
  project(p: ArrayLike<number>): { x: number; y: number } | null {
    const v = new THREE.Vector3(p[0], p[1], p[2]).project(this.camera);
    if (v.z > 1 || v.z < -1) return null;
    const { clientWidth, clientHeight } = this.renderer.domElement;
    return { x: (0.5 + 0.5 * v.x) * clientWidth, y: (0.5 - 0.5 * v.y) * clientHeight };
  }

  /** @param isFine  in full resolution, whatever moves */
  render(budget: number, isFine = false): void {
    if (isFine) this.setScale(1);
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(0.05, Math.min(0.02 * distance, 2));
    this.camera.far = 4 * (distance + this.extent) + 200;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.choose(budget);
    const { renderer, screen } = this;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 1);
    renderer.clear();
    renderer.render(this.pointScene, this.camera);
    renderer.setRenderTarget(null);
    screen.uniforms.nearFar.value.set(this.camera.near, this.camera.far);
    const strength = screen.uniforms.strength.value;
    if (!this.relief) screen.uniforms.strength.value = 0;
    screen.uniforms.taps.value = this.isSoftware && performance.now() - this.lastMotion < 250 ? 4 : 8;
    renderer.clear();
    renderer.render(this.screenScene, this.screenCamera);
    screen.uniforms.strength.value = strength;
    renderer.render(this.lineScene, this.camera);
  }

  private frame(now: number): void {
    requestAnimationFrame((next) => this.frame(next));
    this.advanceGlide(now);
    this.controls.update();
    if (this.before(now)) this.moved();
    const isMoving = now - this.lastMotion < 250;
    if (isMoving) this.adapt(now);
    const isDue = this.isDirty || (this.isStale && now - this.lastPicture > 200 + 2 * this.lastCost);
    const refine = !isMoving && !this.wasRefined && !this.isStale;
    if (!isDue && !refine) {
      this.lastFrame = 0;
      return;
    }
    this.isDirty = this.isStale = false;
    this.setScale(refine ? 1 : isMoving ? this.movingScale : this.scale);
    const begun = performance.now();
    this.render(refine ? Math.max(4 * this.budget, restBudget) : this.budget);
    this.lastCost = performance.now() - begun;
    this.wasRefined = refine;
    this.lastPicture = now;
    this.lastFrame = isMoving ? now : 0;
    this.after();
  }

  private adapt(now: number): void {
    if (this.lastFrame <= 0) return;
    const took = now - this.lastFrame;
    this.framesPerSecond = this.framesPerSecond * 0.8 + 0.2 * (1000 / Math.max(took, 1));
    if (took > 1.3 * wantedMs && this.budget < 6e4) this.movingScale = 0.5;
    if (took > 1.3 * wantedMs) this.budget = Math.max(5e4, this.budget * 0.85);
    else if (took < 0.8 * wantedMs) this.budget = Math.min(8e6, this.budget * 1.05);
  }

  private advanceGlide(now: number): void {
    if (!this.glide) return;
    const share = Math.min(1, Math.max(0, (now - this.glide.begun) / 700));
    const eased = share * share * (3 - 2 * share);
    this.camera.position.lerpVectors(this.glide.from[0], this.glide.to[0], eased);
    this.controls.target.lerpVectors(this.glide.from[1], this.glide.to[1], eased);
    if (share >= 1) this.glide = null;
    this.moved();
  }

  private setScale(scale: number): void {
    if (scale === this.scale) return;
    this.scale = scale;
    this.resize();
    this.isDirty = false; // the picture follows at once
  }

  private resize(): void {
    const { clientWidth: w, clientHeight: h } = this.holder;
    if (w === 0 || h === 0) return;
    const ratio = Math.min(window.devicePixelRatio, 2) * this.scale;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(w, h);
    this.target.setSize(Math.round(w * ratio), Math.round(h * ratio));
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.screen.uniforms.pixel.value.set(1 / (w * ratio), 1 / (h * ratio));
    this.screen.uniforms.reach.value = Math.max(1, 1.2 * ratio);
    this.invalidate();
  }

  private makeScreen(): THREE.ShaderMaterial {
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: screenVertex,
      fragmentShader: screenFragment,
      depthTest: true,
      depthFunc: THREE.AlwaysDepth,
      uniforms: {
        image: { value: this.target.texture }, depths: { value: this.target.depthTexture }, pixel: { value: new THREE.Vector2() },
        nearFar: { value: new THREE.Vector2(0.1, 1000) }, strength: { value: 14 }, reach: { value: 1.2 }, taps: { value: 8 },
        low: { value: new THREE.Color() }, high: { value: new THREE.Color() }, shade: { value: new THREE.Color() },
      },
    });
    const triangle = new THREE.BufferGeometry();
    triangle.setAttribute('position', new THREE.BufferAttribute(new Float32Array(9), 3));
    const mesh = new THREE.Mesh(triangle, material);
    mesh.frustumCulled = false;
    this.screenScene.add(mesh);
    return material;
  }
}
