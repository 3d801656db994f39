// SPDX-License-Identifier: MIT
// Makes one self-contained page, viewer.html, of src/: checks types, bundles, and puts script and style into the document.

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import * as esbuild from 'esbuild';

execFileSync(process.execPath, ['node_modules/typescript/bin/tsc', '--noEmit'], { stdio: 'inherit' });

const bundle = await esbuild.build({
  entryPoints: { script: 'src/main.ts', style: 'src/style.css' },
  bundle: true,
  minify: true,
  write: false,
  outdir: '.',
  format: 'iife',
  target: 'es2022',
  loader: { '.glsl': 'text' },
  legalComments: 'inline',
});
const text = (extension) => bundle.outputFiles.find((file) => file.path.endsWith(extension)).text;
// A script ends where its end tag stands, be it in a string.
const script = text('.js').replaceAll('</script', '<\\/script');

writeFileSync(
  'viewer.html',
  readFileSync('src/index.html', 'utf8')
    .replace('<!-- style -->', () => `<style>${text('.css')}</style>`)
    .replace('<!-- script -->', () => `<script>${script}</script>`),
);
