// SPDX-License-Identifier: Apache-2.0
// Opens report.html in headless Chromium and lets viewer_check.js work its viewer: node
// viewer_read.mjs FOLDER… Leaves FOLDER/viewer.png, to be looked at.
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const check = fs.readFileSync(
    path.join(path.dirname(fileURLToPath(import.meta.url)), 'viewer_check.js'), 'utf8');
const profile = fs.mkdtempSync('/tmp/thew_viewer_');
const options = ['--headless=new', '--no-sandbox', '--enable-unsafe-swiftshader', '--no-first-run',
  '--window-size=1280,1000', '--remote-debugging-pipe', `--user-data-dir=${profile}`];
const chromium =
    spawn('chromium', options, { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });

// DevTools' protocol: JSON with a zero byte after each message.
const waiting = new Map();
let number = 0, rest = '';
chromium.stdio[4].setEncoding('utf8').on('data', (piece) => {
  const messages = (rest + piece).split('\0');
  rest = messages.pop();
  for (const message of messages.map((text) => JSON.parse(text))) {
    const [done, failed] = waiting.get(message.id) ?? [];
    waiting.delete(message.id);
    if (message.error) failed?.(new Error(message.error.message)); else done?.(message.result);
  }
});
const call = (method, params = {}, sessionId) => new Promise((done, failed) => {
  waiting.set(++number, [done, failed]);
  chromium.stdio[3].write(JSON.stringify({ id: number, method, params, sessionId }) + '\0');
});

let good = true;
try {
  for (const folder of process.argv.slice(2)) {
    const url = pathToFileURL(path.resolve(folder, 'report.html')).href;
    const { targetId } = await call('Target.createTarget', { url });
    const { sessionId } = await call('Target.attachToTarget', { targetId, flatten: true });
    const run = (expression) => call('Runtime.evaluate',
        { expression, awaitPromise: true, returnByValue: true }, sessionId);
    // The page is there when its last script has run; until then it may be an empty one.
    for (let i = 0; i < 200; ++i) {
      const { result } = await run(
          `document.readyState === 'complete' && location.href !== 'about:blank'`);
      if (result.value === true) break;
      await new Promise((done) => setTimeout(done, 50));
    }
    const truth = JSON.parse(fs.readFileSync(path.join(folder, 'truth.json'), 'utf8'));
    await run(`window.truth = ${JSON.stringify(truth.largest_stretch)}`);
    const { result, exceptionDetails } = await run(check);
    const told = exceptionDetails ? ['wrong: ' + exceptionDetails.exception.description]
                                  : result.value;
    for (const line of told) console.log(`${folder}/report.html, ${line}`);
    good &&= told.length > 5 && told.every((line) => line.startsWith('right: '));
    const { data } = await call('Page.captureScreenshot', { format: 'png' }, sessionId);
    fs.writeFileSync(path.join(folder, 'viewer.png'), Buffer.from(data, 'base64'));
    await call('Target.closeTarget', { targetId });
  }
} finally {
  chromium.kill();
  await new Promise((done) => chromium.on('exit', done));
  fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
}
process.exit(good ? 0 : 1);
