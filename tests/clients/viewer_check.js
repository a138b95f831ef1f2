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
  // The skin's stretch, to two digits, is that of the bake.
  if (window.truth?.length) {
    const told_stretch = async (frame) => {
      await go(frame);
      return Number(box.querySelector('.scale').lastChild.textContent.match(/up to ([\d.]+)/)[1]);
    };
    expect('another picture by stretch', (await set('colour', 'stretch')).sum !== first.sum);
    for (const frame of [0, truth.length - 1]) {
      const read = await told_stretch(frame);
      expect(`stretch of frame ${frame}: ${read}, the bake has ${truth[frame].toFixed(3)}`,
             Math.abs(read - truth[frame]) < 0.01);
    }
    await go(0);
  }
  await set('colour', 'flesh');
  const alone = box.querySelector('[name=alone]');
  if (alone.options.length > 2) {
    expect('another picture of one muscle alone',
           (await set('alone', alone.options[1].value)).sum !== first.sum);
    expect('all muscles again', (await set('alone', '')).sum === first.sum);
  }
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
  // From a chart, a thumbnail and a worst frame to that frame.
  const shown = () => box.querySelector('output').textContent;
  const chart = document.querySelector('svg[data-frames]');
  const [first_frame, last_frame] = chart.dataset.frames.split(' ').map(Number);
  const [left, right] = chart.dataset.plot.split(' ').map(Number);
  const middle = Math.round((first_frame + last_frame) / 2);
  const at = chart.getBoundingClientRect();
  const x = left + (right - left) * (middle - first_frame) / (last_frame - first_frame);
  chart.dispatchEvent(new MouseEvent('click', {bubbles: true,
    clientX: at.left + x * at.width / chart.viewBox.baseVal.width, clientY: at.top + 50}));
  await look();
  expect(`a click in a chart at frame ${middle} shows ${shown()}`, shown() === 'frame ' + middle);
  const marked = Number(chart.querySelector('.now').getAttribute('x1'));
  expect('the chart marks it', Math.abs(marked - x) < 0.1);
  for (const button of document.querySelectorAll('.worst button, .sheet button')) {
    button.click();
    await look();
    if (shown() !== 'frame ' + button.dataset.frame) expect('a button shows its frame', false);
  }
  expect('worst frames are named', document.querySelectorAll('.worst button').length > 0);
  expect('no wider than the window', document.documentElement.scrollWidth <= innerWidth);
  await go(0);
  const before = box.querySelector('output').textContent;
  box.querySelector('button').click();
  await wait(600);
  box.querySelector('button').click();
  expect('playing goes on', box.querySelector('output').textContent !== before);
  return told;
})()
