// SPDX-License-Identifier: Apache-2.0
// Run inside report.html by viewer_read.mjs: works the viewer's controls as a user would; its value
// is what it saw.
(async () => {
  const box = document.getElementById('viewer'), canvas = box.querySelector('canvas');
  const told = [];
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const paper = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  // What is drawn at the next frame of the screen: the share of pixels, and a number that tells
  // pictures apart.
  const look = () => new Promise((done) => requestAnimationFrame(() => {
    paper.canvas.width = canvas.width;
    paper.canvas.height = canvas.height;
    paper.drawImage(canvas, 0, 0);
    const {data} = paper.getImageData(0, 0, canvas.width, canvas.height);
    let pixels = 0, sum = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] > 0) ++pixels;
      sum = (sum * 31 + data[i] + 256 * data[i + 1] + 65536 * data[i + 2] + data[i + 3]) >>> 0;
    }
    done({share: pixels / (canvas.width * canvas.height), sum});
  }));
  const expect = (what, right) => told.push((right ? 'right' : 'wrong') + ': ' + what);
  const set = (name, value) => {
    const input = box.querySelector(`[name=${name}]`);
    if (input.type === 'checkbox') input.checked = value; else input.value = value;
    input.dispatchEvent(new Event('change'));
    return look();
  };
  const go = (frame) => {
    range.value = frame;
    range.dispatchEvent(new Event('input'));
    return look();
  };
  const range = box.querySelector('input[type=range]');
  for (let i = 0; i < 200 && !box.querySelector('output').textContent; ++i) await wait(50);
  const first = await go(0);
  const last = await go(Number(range.max));
  const share = (100 * first.share).toFixed(1);
  expect(`something is drawn (${share} % of the pixels)`, first.share > 0.005);
  expect('the last frame is another picture', last.sum !== first.sum);
  expect('the same frame is the same picture', (await go(0)).sum === first.sum);
  for (const colour of ['muscle', 'weight', 'error']) {
    expect('another picture by ' + colour, (await set('colour', colour)).sum !== first.sum);
  }
  await set('colour', 'flesh');
  const bare = await set('muscle', false);
  expect('another picture without muscles', bare.sum !== first.sum);
  await set('muscle', true);
  canvas.dispatchEvent(new PointerEvent('pointermove', {buttons: 1, movementX: 80, movementY: 20}));
  expect('turned by a drag', (await look()).sum !== first.sum);
  const turned = await look();
  canvas.dispatchEvent(
      new PointerEvent('pointermove', {buttons: 1, shiftKey: true, movementX: 40, movementY: 30}));
  expect('shifted by shift and drag', (await look()).sum !== turned.sum);
  canvas.dispatchEvent(new WheelEvent('wheel', {deltaY: -300, cancelable: true}));
  expect('nearer by the wheel', (await look()).share > first.share);
  canvas.dispatchEvent(new MouseEvent('dblclick'));
  expect('back by a double click', (await look()).sum === first.sum);
  const before = box.querySelector('output').textContent;
  box.querySelector('button').click();
  await wait(600);
  box.querySelector('button').click();
  expect('playing goes on', box.querySelector('output').textContent !== before);
  return told;
})()
