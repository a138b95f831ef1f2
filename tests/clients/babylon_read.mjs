// SPDX-License-Identifier: Apache-2.0
// Plays glTF in Babylon.js: node babylon_read.mjs MODULES FOLDER…, of which one is a character put
// back onto its file. Without a screen, so that Babylon itself moves, morphs and skins.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { all, Comparison, load } from './truth.mjs';

const modules = path.join(path.resolve(process.argv[2]), 'node_modules/@babylonjs');
const load_module = (file) => import(pathToFileURL(path.join(modules, file)));
globalThis.XMLHttpRequest ??= class {};  // it is asked for, and loads nothing
const B = await load_module('core/index.js');
await load_module('loaders/glTF/index.js');
B.Logger.LogLevels = B.Logger.ErrorLogLevel;
const engine = new B.NullEngine();

async function open_glb(file) {
  const scene = new B.Scene(engine);
  scene.useRightHandedSystem = true;
  new B.FreeCamera('camera', B.Vector3.Zero(), scene);
  await B.ImportMeshAsync(new Uint8Array(fs.readFileSync(file)), scene,
                          { pluginExtension: '.glb' });
  const bytes = fs.readFileSync(file);
  const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
  return { scene, json };
}

// All vertices of a mesh where they are now.
function places(mesh) {
  const local = mesh.getPositionData(true, true), world = mesh.computeWorldMatrix(true);
  const read = [];
  for (let i = 0; i < local.length; i += 3) {
    const at = B.Vector3.TransformCoordinates(B.Vector3.FromArray(local, i), world);
    read.push(at.x, at.y, at.z);
  }
  return read;
}

function seek(scene, seconds) {
  const [group] = scene.animationGroups;
  group.start(false, 1, group.from, group.to);
  group.pause();
  group.goToFrame(seconds * group.targetedAnimations[0].animation.framePerSecond);
  scene.skeletons.forEach((skeleton) => skeleton.prepare(true));
}

function each_frame(scene, truth, work) {
  truth.frames.forEach((frame, i) => {
    seek(scene, frame / truth.fps);
    for (const mesh of scene.meshes) mesh.morphTargetManager?.synchronize?.();
    work(i, frame);
  });
}

// A character's meshes one after another are the bake's skin, as far off as the file states.
async function onto(file, truth) {
  const { scene, json } = await open_glb(file);
  const result = new Comparison(`Babylon.js ${B.Engine.Version}`, file,
                                1e-3 * json.asset.extras.position_error_max_mm + 2e-6);
  const skin = truth.meshes.find((mesh) => mesh.name === 'skin');
  const size = skin.positions.length / truth.frames.length;
  const names = [];  // of nodes, each before those below it
  const walk = (number) => {
    names.push(json.nodes[number].name);
    json.nodes[number].children?.forEach(walk);
  };
  json.scenes[0].nodes.forEach(walk);
  const rank = (mesh) => names.findIndex((name) => mesh.name.replace(/_primitive\d+$/, '') === name);
  const meshes = scene.meshes.filter((mesh) => mesh.getTotalVertices() > 0)
      .sort((a, b) => rank(a) - rank(b) || a.name.localeCompare(b.name));
  each_frame(scene, truth, (i, frame) => result.add(`frame ${frame}`, meshes.flatMap(places),
      skin.positions.subarray(i * size, (i + 1) * size)));
  result.tell();
}

async function meshes(file, truth) {
  const { scene, json } = await open_glb(file);
  const result = new Comparison(`Babylon.js ${B.Engine.Version}`, file,
                                1e-3 * (json.asset.extras.position_error_max_mm ?? 0) + 2e-6);
  each_frame(scene, truth, (i, frame) => {
    for (const mesh of truth.meshes) {
      const size = mesh.positions.length / truth.frames.length;
      result.add(`${mesh.name}, frame ${frame}`, places(scene.getMeshByName(mesh.name)),
                 mesh.positions.subarray(i * size, (i + 1) * size));
    }
  });
  result.tell();
}

for (const folder of process.argv.slice(3)) {
  const truth = load(folder);
  if (folder.endsWith('/onto')) {
    for (const name of ['onto', 'onto_basis', 'correctives', 'correctives_basis']) {
      await onto(`${folder}/${name}.glb`, truth);
    }
  } else {
    for (const name of ['all', 'basis', 'quantized']) await meshes(`${folder}/${name}.glb`, truth);
  }
}
process.exit(all.good ? 0 : 1);
