// SPDX-License-Identifier: Apache-2.0
// Reads .usda, .usdc and .usdz in three.js and TinyUSDZ: node usd_read.mjs MODULES FOLDER…
// TinyUSDZ knows of times only in the text that it makes of a layer, a line a value. three.js
// leaves much out of a text.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { all, Comparison, load } from './truth.mjs';

const modules = path.join(path.resolve(process.argv[2]), 'node_modules');
const load_module = (file) => import(pathToFileURL(path.join(modules, file)));
const { USDAParser } = await load_module('three/examples/jsm/loaders/usd/USDAParser.js');
const { USDCParser } = await load_module('three/examples/jsm/loaders/usd/USDCParser.js');
const { unzipSync } = await load_module('three/examples/jsm/libs/fflate.module.js');
const { REVISION } = await load_module('three/build/three.module.js');
process.type = 'renderer';  // or it looks for files that are not there
globalThis.window = globalThis;
const { default: open_tinyusdz } = await load_module('tinyusdz/tinyusdz.js');
const tinyusdz = await open_tinyusdz(
  { wasmBinary: fs.readFileSync(path.join(modules, 'tinyusdz/tinyusdz.wasm')) });

const plain = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

function by_three(file) {
  const bytes = fs.readFileSync(file);
  if (file.endsWith('.usda')) return new USDAParser().parseData(bytes.toString()).specsByPath;
  if (file.endsWith('.usdc')) return new USDCParser().parseData(plain(bytes)).specsByPath;
  const [inner] = Object.values(unzipSync(bytes));
  return new USDCParser().parseData(plain(inner)).specsByPath;
}

function by_tinyusdz(file) {
  const layer = new tinyusdz.TinyUSDZLoaderNative();
  if (!layer.loadAsLayerFromBinary(new Uint8Array(fs.readFileSync(file)), path.basename(file))) {
    throw new Error(`TinyUSDZ: ${file}: ${layer.error()}`);
  }
  return specs_of_text(layer.layerToString());
}

function value_of(text) {
  if (text.startsWith('"')) return JSON.parse(text);
  if (text.startsWith('@')) return text;
  const list = text.replaceAll('(', '[').replaceAll(')', ']');
  const value = JSON.parse(list);
  return Array.isArray(value) ? value.flat(2) : value;
}

function specs_of_text(text) {
  const specs = {}, open = [''];  // the path of each brace that is open
  let fields = (specs['/'] = { fields: {} }).fields, attribute;
  for (const line of text.split('\n').map((line) => line.trim())) {
    const [, type, name] = line.match(/^def (\w+) "(\w+)"/) ?? [];
    if (name) {
      open.push(`${open.at(-1)}/${name}`);
      specs[open.at(-1)] = { fields: fields = { typeName: type } };
      continue;
    }
    const [, time, sample] = line.match(/^(-?[\d.]+): (.*),$/) ?? [];
    if (time) {
      attribute.timeSamples.times.push(Number(time));
      attribute.timeSamples.values.push(value_of(sample));
      continue;
    }
    const [, , from, connect, to] =
      line.match(/^(.*? )?([\w:]+)(\.connect)? = <(.*)>$/) ?? [];
    if (to) {
      const of = specs[`${open.at(-1)}.${from}`] ??= { fields: {} };
      of.fields[connect ? 'connectionPaths' : 'targetPaths'] = [to];
      continue;
    }
    const [, declared, key, samples, value] =
      line.match(/^(.*? )?([\w:]+)(\.timeSamples)? = (.*)$/) ?? [];
    if (samples) {
      attribute = specs[`${open.at(-1)}.${key}`].fields;  // its default stands before
      attribute.timeSamples = { times: [], values: [] };
    } else if (key && declared && !declared.startsWith('string') && value !== '{') {
      const custom = declared.startsWith('custom ');
      specs[`${open.at(-1)}.${key}`] = { fields: fields = { custom } };
      fields.default = value_of(value.replace(/ \($/, ''));
    } else if (key && value !== '{') {
      if (!declared) fields[key] = value_of(value);
    }
    if (line.endsWith('= {')) open.push(open.at(-1));
    if (line === '}') open.pop();
  }
  return specs;
}

// Its value at a time, on the line between two samples; where none is allowed they have to be the
// same.
function value_at({ fields }, time, line = false) {
  const samples = fields.timeSamples;
  if (!samples) return fields.default;
  const next = samples.times.findIndex((one) => one >= time);
  if (samples.times[next] === time) return samples.values[next];
  const [a, b] = [samples.values[next - 1], samples.values[next]];
  if (line) {
    const from = samples.times[next - 1], t = (time - from) / (samples.times[next] - from);
    return Array.from(a, (value, k) => (1 - t) * value + t * b[k]);
  }
  if (String(a) !== String(b)) throw new Error(`no sample at ${time}`);
  return a;
}

// Degrees between each normal and the one that follows from the points, by the area of triangles.
function angles(normals, points, triangles) {
  const sums = new Float64Array(points.length);
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * triangles[i + k]);
    const edge = (to, k) => points[to + k % 3] - points[a + k % 3];
    for (let k = 0; k < 3; ++k) {
      const twice = edge(b, k + 1) * edge(c, k + 2) - edge(b, k + 2) * edge(c, k + 1);
      for (const corner of [a, b, c]) sums[corner + k] += twice;
    }
  }
  const result = [];
  for (let i = 0; i < points.length; i += 3) {
    const [v, w] = [normals, sums].map((of) => of.slice(i, i + 3));
    const cosine = (v[0] * w[0] + v[1] * w[1] + v[2] * w[2]) / Math.hypot(...v) / Math.hypot(...w);
    result.push(Math.acos(Math.min(1, cosine)) * 180 / Math.PI);
  }
  return result;
}

// USD's vectors are rows: x' = x M. Text has the rows as lists of their own.
function placed(points, matrix) {
  const m = matrix.flat(), result = [];
  for (let i = 0; i < points.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      result.push(points[i] * m[k] + points[i + 1] * m[4 + k] + points[i + 2] * m[8 + k] +
                  m[12 + k]);
    }
  }
  return result;
}

const kScopes = { bone: 'Bones', muscle: 'Muscles', skin: 'Skin' };

function compare(client, file, specs, truth) {
  const whole = client === 'TinyUSDZ' || !file.endsWith('.usda');
  const free = new Comparison(client, `${file}, points`, 0);
  const rigid = new Comparison(client, `${file}, transforms`, 3e-7);
  const turned = new Comparison(client, `${file}, normals of muscles`, 1, ' degrees');
  const root = specs['/'].fields, wrong = free.wrong;
  if (root.upAxis !== 'Y' || root.metersPerUnit !== 1 || root.timeCodesPerSecond !== truth.fps ||
      root.defaultPrim !== 'Bake') {
    wrong.push('units, axis, frame rate or default prim');
  }
  if (whole && (root.startTimeCode !== truth.frames[0] ||
      root.endTimeCode !== truth.frames.at(-1) || specs['/Bake'].fields.kind !== 'component')) {
    wrong.push('first time, last time or kind');
  }
  for (const mesh of truth.meshes) {
    const prim = `/Bake/${kScopes[mesh.kind]}/${mesh.name}`;
    const points = specs[`${prim}.points`], transform = specs[`${prim}.xformOp:transform`];
    const size = mesh.positions.length / truth.frames.length;
    for (let i = 0; i < truth.frames.length; ++i) {
      const time = truth.frames[i], place = `${mesh.name}, frame ${time}`;
      const expected = mesh.positions.subarray(i * size, (i + 1) * size);
      const read = Array.from(value_at(points, time), Math.fround);
      if (transform) rigid.add(place, placed(read, value_at(transform, time)), expected);
      else free.add(place, read, expected, Math.fround);
      const extent = Array.from(value_at(specs[`${prim}.extent`], time)).flat();
      for (let k = 0; k < read.length; ++k) {
        if (Math.fround(extent[k % 3]) > read[k] || Math.fround(extent[3 + k % 3]) < read[k]) {
          wrong.push(`${place}: a point beyond the extent`);
          break;
        }
      }
      const normals = value_at(specs[`${prim}.normals`], time, true);
      if (normals.length !== size) wrong.push(place + ': normals');
      if (mesh.kind !== 'muscle' || transform) continue;
      const off = angles(normals, expected, mesh.triangles);
      turned.add(place, off, off.map(() => 0));
    }
    const indices = specs[`${prim}.faceVertexIndices`].fields.default;
    if (String(indices) !== String(mesh.triangles)) wrong.push(mesh.name + ': triangles');
    const colour = specs[`${prim}.primvars:displayColor`].fields.default;
    if (colour.length !== 3) wrong.push(mesh.name + ': colour');
    if (!whole || mesh.kind !== 'muscle') continue;
    const st = specs[`${prim}.primvars:st`], corners = specs[`${prim}.primvars:st:indices`];
    if (!mesh.fibres ? st : st.fields.interpolation !== 'faceVarying' ||
        corners.fields.default.length !== mesh.triangles.length ||
        Math.max(...corners.fields.default) + 1 !== st.fields.default.length / 2) {
      wrong.push(mesh.name + ': texture coordinates');
    }
    if (3 * specs[`${prim}.primvars:thew:weight`].fields.default.length !== size) {
      wrong.push(mesh.name + ': weights');
    }
    const length = specs[`${prim}.thew:length`];
    const lengths = length ? truth.frames.map((time) => value_at(length, time)) : [];
    if (String(lengths) !== String(mesh.lengths)) wrong.push(mesh.name + ': lengths');
  }
  free.tell();
  if (rigid.values > 0) rigid.tell();
  if (turned.values > 0) turned.tell();
}

// Values by node that Thew derives, against those of truth.py.
function compare_fields(client, file, specs, truth) {
  const told = { fibre: new Comparison(client, `${file}, fibre directions`, 2e-6, ''),
                 stretch: new Comparison(client, `${file}, principal stretches`, 2e-5, '') };
  for (const mesh of truth.meshes) {
    for (const [key, comparison] of Object.entries(told)) {
      const prim = `/Bake/${kScopes[mesh.kind]}/${mesh.name}`;
      const values = specs[`${prim}.primvars:thew:${key}`];
      if (!mesh[key] !== !values) comparison.wrong.push(`${mesh.name}: ${key} where none is`);
      if (!mesh[key] || !values) continue;
      const size = mesh[key].length / truth.frames.length;
      truth.frames.forEach((time, i) => comparison.add(`${mesh.name}, frame ${time}`,
          Array.from(value_at(values, time)), mesh[key].subarray(i * size, (i + 1) * size)));
    }
  }
  for (const comparison of Object.values(told)) if (comparison.values > 0) comparison.tell();
}

// The materials of the character that the skin was put back onto, and the image beside or within.
function compare_looks(client, file, specs) {
  const wrong = [];
  const to = (path, key) => {
    const found = specs[path]?.fields[key];
    const paths = found?.explicitItems ?? found?.items ?? found;
    return String(Array.isArray(paths) ? paths[0] : paths).replace(/[<>]/g, '');
  };
  const expect = (what, read, expected) => {
    if (String(read) !== String(expected)) wrong.push(`${what}: ${read}, expected ${expected}`);
  };
  const looks = '/Bake/Looks', texture = `${looks}/skin/Texture`;
  for (const name of ['skin', 'cloth']) {
    expect(`binding of ${name}`, to(`/Bake/Skin/skin/${name}.material:binding`, 'targetPaths'),
           `${looks}/${name}`);
    expect(`surface of ${name}`, to(`${looks}/${name}.outputs:surface`, 'connectionPaths'),
           `${looks}/${name}/Surface.outputs:surface`);
  }
  expect('colour', Array.from(specs[`${looks}/cloth/Surface.inputs:diffuseColor`].fields.default,
      (x) => x.toFixed(4)), ['0.2000', '0.3000', '0.6000']);
  expect('textured colour', to(`${looks}/skin/Surface.inputs:diffuseColor`, 'connectionPaths'),
         `${texture}.outputs:rgb`);
  expect('coordinates', to(`${texture}.inputs:st`, 'connectionPaths'),
         `${looks}/skin/Coordinates.outputs:result`);
  const image = String(specs[`${texture}.inputs:file`].fields.default).replaceAll('@', '');
  const bytes = file.endsWith('.usdz')
    ? unzipSync(fs.readFileSync(file))[image] : fs.readFileSync(path.join(path.dirname(file), image));
  if (bytes?.[1] !== 0x50) wrong.push(`${image} is no picture`);
  console.log(`${client}, ${file}: materials ${wrong.length ? 'differ' : 'are those of the file'}`);
  for (const line of wrong) console.log('  ' + line);
  all.good &&= wrong.length === 0;
}

// The skin as three.js would draw it: a group of faces for each material, one of them with a picture.
// Node has no pictures: the loader asks for one and is not answered.
globalThis.document = { createElementNS: () => ({ addEventListener() {}, removeEventListener() {} }) };
globalThis.self ??= globalThis;
const { USDLoader } = await load_module('three/examples/jsm/loaders/USDLoader.js');
function compare_drawn(file) {
  const wrong = [], found = {};
  new USDLoader().parse(plain(fs.readFileSync(file))).traverse((mesh) => {
    if (!mesh.isMesh || mesh.name !== 'skin') return;
    for (const { count, materialIndex } of mesh.geometry.groups) {
      const { color, map } = mesh.material[materialIndex];
      found[map ? 'skin' : color.toArray().map((x) => x.toFixed(2)).join(' ')] = count;
    }
  });
  const expected = { '0.20 0.30 0.60': 2790, skin: 3612 };  // corners
  for (const key of new Set([...Object.keys(expected), ...Object.keys(found)])) {
    if (found[key] !== expected[key]) wrong.push(`${key}: ${found[key]}, not ${expected[key]}`);
  }
  console.log(`three.js ${REVISION}, ${file}: materials ${wrong.length ? 'differ' : 'as'} drawn`);
  for (const line of wrong) console.log('  ' + line);
  all.good &&= wrong.length === 0;
}

for (const folder of process.argv.slice(3)) {
  if (folder.endsWith('/onto')) {
    for (const ending of ['usda', 'usdc', 'usdz']) {
      const file = `${folder}/onto.${ending}`;
      compare_looks(`three.js ${REVISION}`, file, by_three(file));
      compare_looks('TinyUSDZ', file, by_tinyusdz(file));
      compare_drawn(file);
    }
    continue;
  }
  const truth = load(folder);
  const fields = `${folder}/fields.usdc`;
  compare_fields(`three.js ${REVISION}`, fields, by_three(fields), truth);
  compare_fields('TinyUSDZ', fields, by_tinyusdz(fields), truth);
  for (const ending of ['usda', 'usdc', 'usdz']) {
    const file = `${folder}/all.${ending}`;
    compare(`three.js ${REVISION}`, file, by_three(file), truth);
    compare('TinyUSDZ', file, by_tinyusdz(file), truth);
  }
}
process.exit(all.good ? 0 : 1);
