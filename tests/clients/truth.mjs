// SPDX-License-Identifier: Apache-2.0
// What truth.py wrote, and what a client read beside it.
import fs from 'node:fs';
import path from 'node:path';

export const all = { good: true };  // whether nothing was wrong so far

export function load(folder) {
  const truth = JSON.parse(fs.readFileSync(path.join(folder, 'truth.json'), 'utf8'));
  const bytes = fs.readFileSync(path.join(folder, 'truth.bin'));
  const numbers = new Float64Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 8);
  for (const mesh of truth.meshes) {
    for (const key of ['positions', 'triangles', 'stretch', 'fibre']) {
      if (!mesh[key]) continue;
      const { at, shape } = mesh[key];
      mesh[key] = numbers.subarray(at, at + shape.reduce((a, b) => a * b));
    }
  }
  return truth;
}

export class Comparison {
  constructor(client, what, allowed, unit = ' m') {
    Object.assign(this, { client, what, allowed, unit, largest: 0, values: 0, wrong: [] });
  }
  add(place, read, expected, rounded = (x) => x) {
    if (read.length !== expected.length) {
      this.wrong.push(`${place}: ${read.length} numbers instead of ${expected.length}`);
      return;
    }
    let largest = 0;
    for (let i = 0; i < read.length; ++i) {
      const error = Math.abs(read[i] - rounded(expected[i]));
      if (!(error <= largest)) largest = error;  // NaN too
    }
    if (!(largest <= this.largest)) this.largest = largest;
    if (!(largest <= this.allowed)) this.wrong.push(`${place}: off by ${largest}`);
    this.values += read.length;
  }
  tell() {
    console.log(`${this.client}, ${this.what}: largest error ` +
                `${this.largest.toPrecision(3)}${this.unit} over ${this.values} numbers`);
    for (const line of this.wrong.slice(0, 5)) console.log('  ' + line);
    all.good &&= this.wrong.length === 0 && this.values > 0;
  }
}
