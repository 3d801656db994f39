// SPDX-License-Identifier: MIT
// What people do: buttons, keys, clicks.

import './style.css';
import { App } from './app';
import { byId } from './dom';
import { type ColourBy, colourModes } from './panel';
import { takeScreenshot } from './screenshot';
import { fetchScene, follow } from './source';

const app = new App();

function onClick(id: string, act: () => void): void {
  byId(id).addEventListener('click', act);
}
function onToggle(id: string, act: (on: boolean) => void): void {
  const box = byId<HTMLInputElement>(id);
  box.addEventListener('change', () => {
    act(box.checked);
    app.redraw();
    app.stage.invalidate();
  });
}

function setFollow(on: boolean): void {
  app.follows = on;
  byId('follow').setAttribute('aria-pressed', String(on));
  if (on) app.followRobot();
}
function togglePanel(): void {
  app.showPanel(byId('panel').hidden);
}
function setColour(mode: ColourBy): void {
  app.colourBy = mode;
  app.closeMerge();
}

const actions: Record<string, () => void> = {
  f: () => { setFollow(false); app.stage.isSteered = false; app.stage.show(app.box(), 'aslant'); },
  t: () => { setFollow(false); app.stage.show(app.box(), 'above'); },
  r: () => setFollow(!app.follows),
  m: () => app.measure.toggle(),
  s: () => takeScreenshot(app.stage, app.labels, app.theme, app.scene.name, app.timeline.t),
  d: () => app.setTheme(app.theme === 'dark' ? 'light' : 'dark'),
  p: togglePanel,
  ' ': () => app.timeline.toggle(),
  home: () => app.timeline.set(0),
  end: () => app.timeline.set(app.timeline.end),
  escape: () => { app.measure.toggle(false); app.closeMerge(); },
};

function connect(): void {
  const buttons = { fit: 'f', top: 't', follow: 'r', measure: 'm', screenshot: 's', theme: 'd', menu: 'p' };
  for (const [id, key] of Object.entries(buttons)) onClick(id, actions[key]);
  for (const mode of colourModes) document.querySelector(`[data-colour=${mode}]`)!.addEventListener('click', () => setColour(mode));
  onToggle('show-points', (on) => { app.cloud.group.visible = on; });
  onToggle('relief', (on) => { app.stage.relief = on; });
  onToggle('dim', (on) => { app.dim = on; });
  onToggle('show-path', (on) => { app.lines.path.group.visible = on; app.lines.hidesPath = !on; });
  onToggle('by-state', (on) => { app.lines.colourBy = on ? 'state' : 'map'; });
  onToggle('show-keyframes', (on) => { app.lines.keyframes.visible = on; });
  app.lines.keyframes.visible = false;
  for (const box of document.querySelectorAll<HTMLInputElement>('[data-kind]')) {
    const setKind = () => { app.lines.shownKinds[box.checked ? 'add' : 'delete'](box.dataset.kind!); };
    setKind();
    box.addEventListener('change', () => { setKind(); app.redraw(); });
  }
  byId<HTMLInputElement>('size').addEventListener('input', (event) => {
    app.cloud.uniforms.pointScale.value = Number((event.target as HTMLInputElement).value);
    app.cloud.uniforms.sizeLimits.value.set(1.5 * app.cloud.uniforms.pointScale.value, 6 * app.cloud.uniforms.pointScale.value);
    app.stage.invalidate();
  });
  byId<HTMLInputElement>('cut').addEventListener('input', (event) => app.chooseCut(Number((event.target as HTMLInputElement).value) / 1000));
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLSelectElement || (event.target instanceof HTMLButtonElement && event.key === ' ')) return;
    if (event.target instanceof HTMLInputElement && event.target.type === 'range' && ['Home', 'End'].includes(event.key)) return;
    const act = actions[event.key.toLowerCase()];
    if (!act || !app.scene) return;
    event.preventDefault();
    act();
  });
  connectPointer();
}

/** A click that does not drag. Twice: look there. */
function connectPointer(): void {
  const canvas = app.stage.renderer.domElement;
  let down: { x: number; y: number } | null = null;
  canvas.addEventListener('pointerdown', (event) => { down = { x: event.offsetX, y: event.offsetY }; });
  canvas.addEventListener('pointerup', (event) => {
    const isClick = down && Math.hypot(event.offsetX - down.x, event.offsetY - down.y) < 5;
    down = null;
    if (!isClick || !app.measure.isOn) return;
    const p = app.picker.at(event.offsetX, event.offsetY);
    byId('hint').textContent = p ? 'Click two points; Escape ends it' : 'There is no point; try again';
    if (p) app.measure.add(p);
  });
  canvas.addEventListener('dblclick', (event) => {
    const p = app.measure.isOn ? null : app.picker.at(event.offsetX, event.offsetY);
    if (!p) return;
    const { camera, controls } = app.stage;
    const target = controls.target.clone().set(...p);
    app.stage.moveCamera(target.clone().add(camera.position.clone().sub(controls.target).multiplyScalar(0.5)), target);
  });
}

async function start(): Promise<void> {
  connect();
  app.setTheme(matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark');
  if (matchMedia('(max-width: 760px)').matches) togglePanel();
  try {
    app.load(await fetchScene());
  } catch (error) {
    byId('hint').textContent = `The run cannot be shown: ${error instanceof Error ? error.message : String(error)}`;
    return;
  }
  if (app.scene.live) follow((message) => void app.news(message), () => app.hasEnded());
}

// What a test or a curious person may look at.
Object.assign(window, { mmlins: app });
void start();
