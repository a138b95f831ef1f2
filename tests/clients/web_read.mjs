// SPDX-License-Identifier: Apache-2.0
// Reads the exports in three.js and by the Khronos validator of glTF:
// node web_read.mjs MODULES FOLDER…
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const modules = path.join(path.resolve(process.argv[2]), 'node_modules');
const require = createRequire(path.join(modules, 'x.js'));
const load_module = (file) => import(pathToFileURL(path.join(modules, file)));
const validator = require('gltf-validator');
const THREE = await load_module('three/build/three.module.js');
const { GLTFLoader } = await load_module('three/examples/jsm/loaders/GLTFLoader.js');
const { USDAParser } = await load_module('three/examples/jsm/loaders/usd/USDAParser.js');

function load(folder) {
  const truth = JSON.parse(fs.readFileSync(path.join(folder, 'truth.json'), 'utf8'));
  const bytes = fs.readFileSync(path.join(folder, 'truth.bin'));
  const numbers = new Float64Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 8);
  for (const mesh of truth.meshes) {
    for (const key of ['positions', 'triangles']) {
      const { at, shape } = mesh[key];
      mesh[key] = numbers.subarray(at, at + shape.reduce((a, b) => a * b));
    }
  }
  return truth;
}

// Node has none, and the loader tells its progress by them.
globalThis.ProgressEvent ??= class extends Event {};

let good = true;
class Comparison {
  constructor(client, what, allowed) {
    Object.assign(this, { client, what, allowed, largest: 0, values: 0, wrong: [] });
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
    console.log(`${this.client}, ${this.what}: largest error ${this.largest.toPrecision(3)} m ` +
                `over ${this.values / 3} vertices`);
    for (const line of this.wrong.slice(0, 5)) console.log('  ' + line);
    good &&= this.wrong.length === 0 && this.values > 0;
  }
}

async function validate(file) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  const { numErrors, numWarnings, numInfos, numHints } = report.issues;
  console.log(`gltf-validator ${validator.version()}, ${file}: ${numErrors} errors, ` +
              `${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
  for (const message of report.issues.messages.slice(0, 5)) console.log('  ' + message.message);
  good &&= numErrors + numWarnings + numInfos + numHints === 0;
}

// The mesh at a time as three.js itself animates and morphs it.
async function gltf(file, truth, allowed) {
  const result = new Comparison(`three.js ${THREE.REVISION}`, file, allowed);
  const bytes = fs.readFileSync(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const asset = await new GLTFLoader().parseAsync(buffer, '');
  const mixer = new THREE.AnimationMixer(asset.scene);
  const action = mixer.clipAction(asset.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const point = new THREE.Vector3();
  for (let i = 0; i < truth.frames.length; ++i) {
    mixer.setTime((truth.frames[i] - truth.frames[0]) / truth.fps);
    for (const mesh of truth.meshes) {
      const thing = asset.scene.getObjectByName(mesh.name);
      const count = thing.geometry.attributes.position.count;
      const read = new Float64Array(3 * count);
      for (let v = 0; v < count; ++v) thing.getVertexPosition(v, point).toArray(read, 3 * v);
      const size = mesh.positions.length / truth.frames.length;
      const place = `${mesh.name}, frame ${truth.frames[i]}`;
      result.add(place, read, mesh.positions.subarray(i * size, (i + 1) * size));
      if (String(thing.geometry.index.array) !== String(mesh.triangles)) {
        result.wrong.push(place + ': triangles differ');
      }
    }
  }
  result.tell();
}

function usda(file, truth) {
  const result = new Comparison(`three.js ${THREE.REVISION}`, file, 0);
  const specs = new USDAParser().parseData(fs.readFileSync(file, 'utf8')).specsByPath;
  const root = specs['/'].fields;
  if (root.upAxis !== 'Y' || root.metersPerUnit !== 1 || root.timeCodesPerSecond !== truth.fps) {
    result.wrong.push('units, axis or frame rate');
  }
  for (const mesh of truth.meshes) {
    const { times, values } = specs[`/Bake/${mesh.name}.points`].fields.timeSamples;
    if (String(times) !== String(truth.frames)) result.wrong.push(mesh.name + ': time codes');
    const size = mesh.positions.length / truth.frames.length;
    for (let i = 0; i < times.length; ++i) {
      result.add(`${mesh.name}, frame ${times[i]}`, values[i].map(Math.fround),
                 mesh.positions.subarray(i * size, (i + 1) * size), Math.fround);
    }
    const indices = specs[`/Bake/${mesh.name}.faceVertexIndices`].fields.default;
    if (String(indices) !== String(mesh.triangles)) result.wrong.push(mesh.name + ': triangles');
  }
  result.tell();
}

// The character's own animation as three.js plays it, curves of all kinds and skinning included:
// the bake is that, vertex by vertex in the file's order, and the muscles' displacement on top.
async function character(file, truth) {
  const result = new Comparison(`three.js ${THREE.REVISION}`, file, 1e-6);
  await validate(file);
  const asset = await new GLTFLoader().parseAsync(fs.readFileSync(file, 'utf8'), '');
  let thing;
  asset.scene.traverse((node) => thing = node.isSkinnedMesh ? node : thing);
  const mixer = new THREE.AnimationMixer(asset.scene);
  const action = mixer.clipAction(asset.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  if (String(thing.geometry.index.array) !== String(skin.triangles)) {
    result.wrong.push('triangles differ');
  }
  const { skinIndex, skinWeight, position } = thing.geometry.attributes;
  // Muscles act neither on what the hips carry nor on the fingers.
  const { bones, boneInverses } = thing.skeleton;
  const weight_of = (v, name) => [0, 1, 2, 3].reduce((sum, k) => sum +
    (bones[skinIndex.getComponent(v, k)].name === name ? skinWeight.getComponent(v, k) : 0), 0);
  const is_finger = (v, name) => weight_of(v, name) === 1 && new THREE.Vector3()
    .fromBufferAttribute(position, v)
    .applyMatrix4(boneInverses[bones.findIndex((bone) => bone.name === name)]).length() > 0.1;
  const apart = Array.from({ length: position.count }, (_, v) => weight_of(v, 'Hips') > 0 ||
    is_finger(v, 'LeftHand') || is_finger(v, 'RightHand'));
  const point = new THREE.Vector3();
  let moved = 0;
  for (let i = 0; i < truth.frames.length; ++i) {
    mixer.setTime((truth.frames[i] - 1) / truth.fps);
    asset.scene.updateMatrixWorld(true);
    const read = [], expected = [];
    for (let v = 0; v < position.count; ++v) {
      thing.getVertexPosition(v, point).applyMatrix4(thing.matrixWorld);
      const at = 3 * (i * position.count + v), baked = skin.positions.subarray(at, at + 3);
      if (!apart[v]) {
        moved = Math.max(moved, point.distanceTo(new THREE.Vector3(...baked)));
        continue;
      }
      read.push(...point.toArray());
      expected.push(...baked);
    }
    result.add(`hips and fingers, frame ${truth.frames[i]}`, read, expected);
  }
  console.log(`  between them muscles move the skin by up to ${(1e3 * moved).toFixed(2)} mm`);
  if (!(moved > 1e-4 && moved < 0.03)) result.wrong.push('that is not what muscles do');
  result.tell();
}

for (const folder of process.argv.slice(3)) {
  const truth = load(folder);
  if (folder.endsWith('/wave')) {
    await character(`${folder}/input.gltf`, truth);
    continue;
  }
  const stated = fs.readFileSync(`${folder}/basis.txt`, 'utf8').match(/position error (\S+) mm/);
  await validate(`${folder}/all.glb`);
  await validate(`${folder}/basis.glb`);
  await gltf(`${folder}/all.glb`, truth, 1e-6);
  await gltf(`${folder}/basis.glb`, truth, 1e-3 * Number(stated[1]) + 1e-6);
  usda(`${folder}/all.usda`, truth);
}
process.exit(good ? 0 : 1);
