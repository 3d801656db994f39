// SPDX-License-Identifier: MIT
// The data, and news of it.

import type { LiveMessage, SceneMessage, Scans } from './types';

export async function fetchScene(): Promise<SceneMessage> {
  const response = await fetch('/api/scene');
  if (!response.ok) throw new Error((await response.text()).trim());
  return (await response.json()) as SceneMessage;
}

/** Adds rows; names come in full each time. */
export function appendScans(to: Scans, more: Scans): void {
  to.states = more.states;
  to.causes = more.causes;
  const skip = to.t.length - more.from; // what is there already
  if (skip < 0) return;
  for (const column of ['t', 'map', 'state', 'cause', 'ms'] as const) to[column].push(...more[column].slice(skip));
  to.pose.push(...more.pose.slice(7 * skip));
}

/** Tells news until the run has ended or the server is gone. */
export function follow(onNews: (message: LiveMessage) => void, onGone: () => void): void {
  let hasEnded = false;
  const socket = new WebSocket(`ws://${location.host}/api/live`);
  socket.addEventListener('message', (event) => {
    const message = JSON.parse(event.data as string) as LiveMessage;
    hasEnded ||= message.ended === true;
    onNews(message);
  });
  socket.addEventListener('close', () => {
    if (!hasEnded) onGone();
  });
}
