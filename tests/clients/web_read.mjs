// SPDX-License-Identifier: Apache-2.0
// Reads the exports in three.js and by the Khronos validator of glTF:
// node web_read.mjs MODULES FOLDER…
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';
import { all, Comparison, load } from './truth.mjs';

const modules = path.join(path.resolve(process.argv[2]), 'node_modules');
const require = createRequire(path.join(modules, 'x.js'));
const load_module = (file) => import(pathToFileURL(path.join(modules, file)));
const validator = require('gltf-validator');
const THREE = await load_module('three/build/three.module.js');
const { GLTFLoader } = await load_module('three/examples/jsm/loaders/GLTFLoader.js');

// Node has none of these: the loader tells its progress by the first and asks the second for
// pictures, which are not looked at.
globalThis.ProgressEvent ??= class extends Event {};
globalThis.self ??= globalThis;
THREE.TextureLoader.prototype.load = (url, done) => {
  const texture = new THREE.Texture();
  setTimeout(() => done(texture));
  return texture;
};

// `known`: what the file that came in is told as well, and joints that nothing hangs on any more.
async function validate(file, known = []) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  report.issues.messages = report.issues.messages.filter(({ code }) => !known.includes(code));
  const count = (severity) => report.issues.messages.filter((m) => m.severity === severity).length;
  const [numErrors, numWarnings, numInfos, numHints] = [0, 1, 2, 3].map(count);
  console.log(`gltf-validator ${validator.version()}, ${file}: ${numErrors} errors, ` +
              `${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
  for (const message of report.issues.messages.slice(0, 5)) console.log('  ' + message.message);
  all.good &&= numErrors + numWarnings + numInfos + numHints === 0;
}

// The mesh at a time as three.js itself moves and morphs it.
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
    mixer.setTime(truth.frames[i] / truth.fps);
    asset.scene.updateMatrixWorld(true);
    for (const mesh of truth.meshes) {
      const thing = asset.scene.getObjectByName(mesh.name);
      const count = thing.geometry.attributes.position.count;
      const read = new Float64Array(3 * count);
      for (let v = 0; v < count; ++v) {
        thing.getVertexPosition(v, point).applyMatrix4(thing.matrixWorld).toArray(read, 3 * v);
      }
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

async function open_glb(file) {
  const bytes = fs.readFileSync(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new GLTFLoader().parseAsync(buffer, '');
}

// A character's own file with its skin as baked: its meshes one after another are the bake's skin,
// as three.js plays it, and lie as far from it as the file states, in mm.
async function onto(file, truth) {
  const asset = await open_glb(file);
  const stated = asset.asset.extras.position_error_max_mm;
  const result =
    new Comparison(`three.js ${THREE.REVISION}`, file, 1e-3 * stated + 1e-6);
  const mixer = new THREE.AnimationMixer(asset.scene);
  const action = mixer.clipAction(asset.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const meshes = [], point = new THREE.Vector3();
  asset.scene.traverse((node) => { if (node.isMesh) meshes.push(node); });
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  const size = skin.positions.length / truth.frames.length;
  for (let i = 0; i < truth.frames.length; ++i) {
    mixer.setTime(truth.frames[i] / truth.fps);
    asset.scene.updateMatrixWorld(true);
    const read = [];
    for (const mesh of meshes) {
      for (let v = 0; v < mesh.geometry.attributes.position.count; ++v) {
        read.push(...mesh.getVertexPosition(v, point).applyMatrix4(mesh.matrixWorld).toArray());
      }
    }
    result.add(`frame ${truth.frames[i]}`, read, skin.positions.subarray(i * size, (i + 1) * size));
  }
  result.tell();
}

// All that a file has beside its shapes and animations.
function same_asset(file, input) {
  const bytes = fs.readFileSync(file);
  const now = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
  const was = JSON.parse(fs.readFileSync(input, 'utf8')), wrong = [];
  const of = ({ nodes, meshes, materials, textures }) => JSON.stringify({
    nodes: nodes.map(({ name, children }) => ({ name, children })),
    meshes: meshes.map(({ name, primitives }) =>
      ({ name, primitives: primitives.map(({ material }) => material) })),
    materials: materials.map(({ name, extras }) => ({ name, extras })), textures });
  if (of(now) !== of(was)) wrong.push(`${of(now)} is not ${of(was)}`);
  console.log(`${file}: nodes, meshes, materials and textures ${wrong.length ? 'differ' : 'kept'}`);
  for (const line of wrong) console.log('  ' + line);
  all.good &&= wrong.length === 0;
}

// A character's own animation as three.js plays it, curves of all kinds and skinning included.
async function play(file) {
  const asset = await new GLTFLoader().parseAsync(fs.readFileSync(file, 'utf8'), '');
  let thing;
  asset.scene.traverse((node) => thing = node.isSkinnedMesh ? node : thing);
  const mixer = new THREE.AnimationMixer(asset.scene);
  const action = mixer.clipAction(asset.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const seek = (seconds) => {
    mixer.setTime(seconds);
    asset.scene.updateMatrixWorld(true);
  };
  // A place of the bind pose, as vertex v's weights carry it.
  const carry = (v, place) =>
    thing.applyBoneTransform(v, place.clone()).applyMatrix4(thing.matrixWorld);
  return { thing, seek, carry };
}

// By vertex, whether no muscle reaches it: on what the hips carry, and on the fingers.
function beyond_muscles({ geometry, skeleton }) {
  const { skinIndex, skinWeight, position } = geometry.attributes;
  const { bones, boneInverses } = skeleton;
  const weight_of = (v, name) => [0, 1, 2, 3].reduce((sum, k) => sum +
    (bones[skinIndex.getComponent(v, k)].name === name ? skinWeight.getComponent(v, k) : 0), 0);
  const is_finger = (v, name) => weight_of(v, name) === 1 && new THREE.Vector3()
    .fromBufferAttribute(position, v)
    .applyMatrix4(boneInverses[bones.findIndex((bone) => bone.name === name)]).length() > 0.1;
  return Array.from({ length: position.count }, (_, v) => weight_of(v, 'Hips') > 0 ||
    is_finger(v, 'LeftHand') || is_finger(v, 'RightHand'));
}

function place_of(truth, mesh, i, v) {
  const at = i * mesh.positions.length / truth.frames.length + 3 * v;
  return new THREE.Vector3(...mesh.positions.subarray(at, at + 3));
}

// The baked skin against three.js's, in the file's order of vertices; all, or those that `chosen`
// says of the character.
async function weights_alone(file, truth, what, chosen = () => null) {
  const result = new Comparison(`three.js ${THREE.REVISION}`, `${file}, ${what}`, 1e-6);
  const { thing, seek } = await play(file);
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  if (String(thing.geometry.index.array) !== String(skin.triangles)) {
    result.wrong.push('triangles differ');
  }
  const among = chosen(thing), point = new THREE.Vector3();
  for (let i = 0; i < truth.frames.length; ++i) {
    seek((truth.frames[i] - 1) / truth.fps);
    const read = [], expected = [];
    for (let v = 0; v < thing.geometry.attributes.position.count; ++v) {
      if (among && !among[v]) continue;
      read.push(...thing.getVertexPosition(v, point).applyMatrix4(thing.matrixWorld).toArray());
      expected.push(...place_of(truth, skin, i, v).toArray());
    }
    result.add(`frame ${truth.frames[i]}`, read, expected);
  }
  result.tell();
}

// Skin vertices of one arm within `reach` (m) of its muscles in the first frame, each with the
// node that is nearest to it.
function over_flesh(truth, side, reach) {
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  const muscles = truth.meshes.filter(({ name, kind }) => kind === 'muscle' && name.endsWith(side));
  const nodes = muscles.flatMap((mesh) => Array.from(
    { length: mesh.positions.length / truth.frames.length / 3 },
    (_, node) => ({ mesh, node, was: place_of(truth, mesh, 0, node) })));
  const pairs = [];
  for (let v = 0; v < skin.positions.length / truth.frames.length / 3; ++v) {
    const was = place_of(truth, skin, 0, v);
    const [best, squared] = nodes.reduce((least, node) => {
      const d = node.was.distanceToSquared(was);
      return d < least[1] ? [node, d] : least;
    }, [null, reach * reach]);
    if (best) pairs.push({ v, was, flesh: best, above: Math.sqrt(squared) });
  }
  return pairs;
}

// Muscles take the skin along with them against its weights, and no farther than they go. In a bent
// elbow that is far: two tubes of radius r meet at r / cos(a / 2) from its axis, a its angle, and
// weights of a half leave the skin at r cos(a / 2), deep in the flesh. So in each frame and arm the
// most that the skin has gone, beside what its weights make of it as the first frame has it, is
// held against the most that the flesh below has, beside what they make of that: whole ways against
// whole ways, since in a fold both slide, and ways out of the limb against such, along what the
// weights make of the line from the flesh to the skin.
async function displacement(file, truth) {
  const { thing, seek, carry } = await play(file);
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  const place = `${file}: muscles`, wrong = [];
  let farthest = 0, closest = 0;
  seek(0);
  const { position } = thing.geometry.attributes, point = new THREE.Vector3();
  for (let v = 0; v < position.count; ++v) {
    point.fromBufferAttribute(position, v);
    if (!(carry(v, point).distanceTo(point) < 1e-6)) wrong.push(`vertex ${v}: begins not at bind`);
  }
  const arms = ['_left', '_right'].map((side) => over_flesh(truth, side, 0.03));
  for (let i = 1; i < truth.frames.length; ++i) {
    seek((truth.frames[i] - 1) / truth.fps);
    for (const pairs of arms) {
      const gone = { whole: 0, outward: 0 }, come = { whole: 0, outward: 0 };
      for (const { v, was, flesh, above } of pairs) {
        const carried = carry(v, was), below = carry(v, flesh.was);
        const out = carried.clone().sub(below).normalize();
        const skin_way = place_of(truth, skin, i, v).sub(carried);
        const flesh_now = place_of(truth, flesh.mesh, i, flesh.node);
        const level = out.dot(flesh_now) + above - out.dot(carried);
        gone.whole = Math.max(gone.whole, skin_way.length());
        come.whole = Math.max(come.whole, flesh_now.distanceTo(below));
        gone.outward = Math.max(gone.outward, Math.abs(skin_way.dot(out)));
        come.outward = Math.max(come.outward, Math.abs(level));
      }
      for (const kind of ['whole', 'outward']) {
        if (!(gone[kind] > 1e-4 && gone[kind] <= come[kind])) {
          wrong.push(`frame ${truth.frames[i]}: skin by ${gone[kind]} m (${kind} way), ` +
                     `flesh by ${come[kind]} m`);
        }
        closest = Math.max(closest, gone[kind] / come[kind]);
      }
      farthest = Math.max(farthest, gone.whole);
    }
  }
  console.log(`${place} take the skin along by up to ${(1e3 * farthest).toFixed(1)} mm, at most ` +
              `${closest.toFixed(2)} of their own way`);
  for (const line of wrong.slice(0, 5)) console.log('  ' + line);
  all.good &&= wrong.length === 0;
}

for (const folder of process.argv.slice(3)) {
  const truth = load(folder);
  if (folder.endsWith('/wave')) {
    const file = `${folder}/input.gltf`;
    await validate(file);
    await weights_alone(file, truth, 'hips and fingers', beyond_muscles);
    await weights_alone(file, load(`${folder}/weights`), 'without muscles');
    await displacement(file, truth);
    continue;
  }
  if (folder.endsWith('/onto')) {
    const known = ['NODE_SKINNED_MESH_NON_ROOT', 'UNUSED_MESH_TANGENT', 'UNUSED_OBJECT'];
    await validate(`${folder}/input.gltf`, known);
    for (const name of ['onto', 'onto_basis', 'correctives', 'correctives_basis']) {
      const file = `${folder}/${name}.glb`;
      await validate(file, name.startsWith('onto') ? [...known, 'NODE_EMPTY'] : known);
      same_asset(file, `${folder}/input.gltf`);
      await onto(file, truth);
    }
    continue;
  }
  const stated = fs.readFileSync(`${folder}/basis.txt`, 'utf8').match(/position error (\S+) mm/);
  await validate(`${folder}/all.glb`);
  await validate(`${folder}/basis.glb`);
  await gltf(`${folder}/all.glb`, truth, 1e-6);
  await validate(`${folder}/quantized.glb`);
  const steps = (await open_glb(`${folder}/quantized.glb`)).asset.extras.position_error_max_mm;
  await gltf(`${folder}/quantized.glb`, truth, 1e-3 * steps + 1e-6);
  await gltf(`${folder}/basis.glb`, truth, 1e-3 * Number(stated[1]) + 1e-6);
}
process.exit(all.good ? 0 : 1);
