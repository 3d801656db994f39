// SPDX-License-Identifier: MIT
// Draws everything, and again when there is more or less room, or paper.

header();
tiles();
mapControls();
drawing(drawMap);
cursorFollowers.push(followOnMap);
drawing(drawTimeline);
cursorFollowers.push(followOnTimeline);
timelineLegend();
tables();
truthSection();
observabilitySection();
matchSection();
workSection();
recordingSection();
configSection();
setCursor(null);

let pending = 0;
let lastWidth = window.innerWidth;
window.addEventListener('resize', () => {
  if (window.innerWidth === lastWidth || printing) return;  // a phone's address bar changes the height all the time
  lastWidth = window.innerWidth;
  cancelAnimationFrame(pending);
  pending = requestAnimationFrame(redraw);
});

let folded = [];
window.addEventListener('beforeprint', () => {
  printing = true;
  setCursor(null);
  folded = [...document.querySelectorAll('details:not([open])')];
  for (const node of folded) node.open = true;
  redraw();
});
window.addEventListener('afterprint', () => {
  printing = false;
  for (const node of folded) node.open = false;
  redraw();
});
