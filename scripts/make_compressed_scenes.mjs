#!/usr/bin/env node
// Makes assets/tests/compressed/: one small scene as plain glTF and as independent encoders compress it. The outputs are
// committed; this is run again only when the scene changes. Packages come from npm, into a folder of their own:
//
//   npm install --prefix build @gltf-transform/core @gltf-transform/extensions @gltf-transform/functions draco3dgltf \
//     meshoptimizer gltfpack sharp
//   NODE_PATH=build/node_modules scripts/make_compressed_scenes.mjs build/node_modules assets/tests/compressed
import { execFileSync } from 'node:child_process';
import { createRequire } from 'node:module';
import fs from 'node:fs';
import path from 'node:path';

const [modules, out] = process.argv.slice(2);
const require = createRequire(path.resolve(modules, 'x.js'));
const load = async (name) => import(require.resolve(name));
const { Document, NodeIO } = await load('@gltf-transform/core');
const extensions = await load('@gltf-transform/extensions');
const functions = await load('@gltf-transform/functions');
const draco3d = require('draco3dgltf');
const { MeshoptEncoder, MeshoptDecoder } = await load('meshoptimizer');
const sharp = require('sharp');

await MeshoptEncoder.ready;
const io = new NodeIO().registerExtensions(extensions.ALL_EXTENSIONS).registerDependencies({
  'draco3d.encoder': await draco3d.createEncoderModule(),
  'draco3d.decoder': await draco3d.createDecoderModule(),
  'meshopt.encoder': MeshoptEncoder,
  'meshopt.decoder': MeshoptDecoder,
});

const image = (r, g, b) => sharp({ create: { width: 4, height: 4, channels: 3, background: { r, g, b } } });

// A curved grid with normals, texture coordinates and vertex colours; a grid with a morph target; three instances; a
// skinned strip with an animation. No two triangles of a mesh have the same middle.
async function makeScene() {
  const doc = new Document();
  const buffer = doc.createBuffer();
  const accessor = (type, array) => doc.createAccessor().setType(type).setArray(array).setBuffer(buffer);
  const grid = (n, height) => {
    const position = [], normal = [], uv = [], color = [], index = [];
    for (let y = 0; y <= n; ++y) {
      for (let x = 0; x <= n; ++x) {
        const u = x / n, v = y / n;
        position.push(2 * u - 1, height * Math.sin(3 * u + 2 * v), 2 * v - 1);
        const d = [-1.5 * height * Math.cos(3 * u + 2 * v), 1, -height * Math.cos(3 * u + 2 * v)];
        const length = Math.hypot(...d);
        normal.push(...d.map((c) => c / length));
        uv.push(u, v);
        color.push(u, v, 0.5, 1);
      }
    }
    for (let y = 0; y < n; ++y) {
      for (let x = 0; x < n; ++x) {
        const a = y * (n + 1) + x;
        index.push(a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2);
      }
    }
    return { position, normal, uv, color, index };
  };
  const primitive = (g) => doc.createPrimitive()
    .setAttribute('POSITION', accessor('VEC3', new Float32Array(g.position)))
    .setAttribute('NORMAL', accessor('VEC3', new Float32Array(g.normal)))
    .setAttribute('TEXCOORD_0', accessor('VEC2', new Float32Array(g.uv)))
    .setIndices(accessor('SCALAR', new Uint16Array(g.index)));
  const texture = doc.createTexture('red').setMimeType('image/png').setImage(await image(200, 40, 40).png().toBuffer());
  const material = doc.createMaterial('painted').setBaseColorTexture(texture).setRoughnessFactor(0.8);
  const scene = doc.createScene('compressed');

  const curved = grid(6, 0.3);
  const curvedPrimitive = primitive(curved).setMaterial(material)
    .setAttribute('COLOR_0', accessor('VEC4', new Float32Array(curved.color)));
  scene.addChild(doc.createNode('curved').setMesh(doc.createMesh('curved').addPrimitive(curvedPrimitive)));

  const morphing = primitive(grid(2, 0.1));
  const offsets = new Float32Array(morphing.getAttribute('POSITION').getCount() * 3).map((_, i) => (i % 3 === 1 ? i / 50 : 0));
  morphing.addTarget(doc.createPrimitiveTarget().setAttribute('POSITION', accessor('VEC3', offsets)));
  const morphMesh = doc.createMesh('morphing').addPrimitive(morphing).setWeights([0.5]);
  scene.addChild(doc.createNode('morphing').setMesh(morphMesh).setTranslation([4, 0, 0]));

  const instancing = doc.createExtension(extensions.EXTMeshGPUInstancing).setRequired(true);
  const translations = new Float32Array([-4, 0, 0, -4, 0, 3, -4, 1, -3]);
  const rotations = new Float32Array([0, 0, 0, 1, 0, Math.SQRT1_2, 0, Math.SQRT1_2, 0.5, 0.5, 0.5, 0.5]);
  scene.addChild(doc.createNode('instanced').setMesh(doc.createMesh('small').addPrimitive(primitive(grid(3, 0.2))))
    .setExtension('EXT_mesh_gpu_instancing', instancing.createInstancedMesh()
      .setAttribute('TRANSLATION', accessor('VEC3', translations))
      .setAttribute('ROTATION', accessor('VEC4', rotations))));

  const strip = primitive(grid(2, 0.05));
  const count = strip.getAttribute('POSITION').getCount();
  strip.setAttribute('JOINTS_0', accessor('VEC4', new Uint8Array(count * 4).map((_, i) => (i % 4 === 0 ? Math.floor(i / 4) % 2 : 0))));
  strip.setAttribute('WEIGHTS_0', accessor('VEC4', new Float32Array(count * 4).map((_, i) => (i % 4 === 0 ? 1 : 0))));
  const joints = [doc.createNode('root').setTranslation([0, 0, 4]), doc.createNode('tip').setTranslation([0.5, 0, 0])];
  joints[0].addChild(joints[1]);
  scene.addChild(joints[0]);
  const inverse = new Float32Array(32);
  for (let j = 0; j < 2; ++j) for (let k = 0; k < 4; ++k) inverse[j * 16 + k * 5] = 1;
  const skin = doc.createSkin().setSkeleton(joints[0]).setInverseBindMatrices(accessor('MAT4', inverse));
  joints.forEach((joint) => skin.addJoint(joint));
  scene.addChild(doc.createNode('skinned').setMesh(doc.createMesh('skinned').addPrimitive(strip)).setSkin(skin));
  const sampler = doc.createAnimationSampler().setInput(accessor('SCALAR', new Float32Array([0, 1])))
    .setOutput(accessor('VEC4', new Float32Array([0, 0, 0, 1, 0, 0, Math.SQRT1_2, Math.SQRT1_2])));
  doc.createAnimation('wave').addSampler(sampler).addChannel(
    doc.createAnimationChannel().setTargetNode(joints[1]).setTargetPath('rotation').setSampler(sampler));
  return doc;
}

async function write(name, doc, ...transforms) {
  if (transforms.length > 0) await doc.transform(...transforms);
  await io.write(path.join(out, name), doc);
}

fs.mkdirSync(out, { recursive: true });
const plain = path.join(out, 'plain.glb');
await write('plain.glb', await makeScene());
const read = () => io.read(plain);
await write('draco_edgebreaker.glb', await read(), functions.draco({ method: 'edgebreaker' }));
await write('draco_sequential.glb', await read(), functions.draco({ method: 'sequential' }));
await write('meshopt_medium.glb', await read(), functions.meshopt({ encoder: MeshoptEncoder, level: 'medium' }));
await write('meshopt_high.glb', await read(), functions.meshopt({ encoder: MeshoptEncoder, level: 'high' }));
const gltfpack = (name, ...options) => execFileSync(
  process.execPath, [require.resolve('gltfpack/cli.js'), '-i', plain, '-o', path.join(out, name), '-kn', '-km', ...options]);
gltfpack('gltfpack_ext.glb', '-c', '-ce', 'ext');
gltfpack('gltfpack_filters.glb', '-cc', '-ce', 'ext', '-kv');
gltfpack('gltfpack_khr.glb', '-cz', '-ce', 'khr');

// A green WebP image in place of the red PNG, which stays for programs that read no WebP.
const webp = await read();
await write("webp.glb", webp);
{
  const bytes = fs.readFileSync(path.join(out, 'webp.glb'));
  const jsonLength = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.subarray(20, 20 + jsonLength).toString());
  let binary = bytes.subarray(20 + jsonLength + 8);
  const green = await image(40, 200, 40).webp({ lossless: true }).toBuffer();
  json.bufferViews.push({ buffer: 0, byteOffset: binary.length, byteLength: green.length });
  json.images.push({ name: 'green', mimeType: 'image/webp', bufferView: json.bufferViews.length - 1 });
  json.textures[0].extensions = { EXT_texture_webp: { source: json.images.length - 1 } };
  (json.extensionsUsed ??= []).push('EXT_texture_webp');
  binary = Buffer.concat([binary, green, Buffer.alloc((4 - (green.length % 4)) % 4)]);
  json.buffers[0].byteLength = binary.length;
  let text = JSON.stringify(json);
  text += ' '.repeat((4 - (Buffer.byteLength(text) % 4)) % 4);
  const header = Buffer.alloc(20);
  header.write('glTF');
  [2, 28 + text.length + binary.length, text.length, 0x4e4f534a].forEach((v, i) => header.writeUInt32LE(v, 4 + 4 * i));
  const chunk = Buffer.alloc(8);
  chunk.writeUInt32LE(binary.length);
  chunk.writeUInt32LE(0x004e4942, 4);
  fs.writeFileSync(path.join(out, 'webp.glb'), Buffer.concat([header, Buffer.from(text), chunk, binary]));
}
