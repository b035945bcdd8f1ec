// All of the public API of @halflight/three, as an application would use it: compiled by types.test.mjs, never run.
import { HalflightPlugin, HalflightScene, MODES, RELEASES, VIEWS, type BakedGLTF, type BakedLight, type LightGroup, type Mode, type Options, type View } from '@halflight/three';
import { HalflightPlugin as NodePlugin } from '@halflight/three/webgpu';
import { composeLight, composeReflections, isBaked, readBaked, type BakedData, type GroupData, type LightData, type NodeData, type Pixels, type ProbeData, type ReflectionPicture, type Source } from '@halflight/three/file';
import { Box3, Color, Mesh, PerspectiveCamera, Scene, WebGLRenderer } from 'three';
import { LightProbeGridWebGL } from 'three/addons/lighting/LightProbeGridWebGL.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const options: Options = { sky: false, brdf: 'three', dynamicLayer: 30 };
const loader = new GLTFLoader();
let plugin: HalflightPlugin | null = null;
loader.register((parser) => (plugin = new HalflightPlugin(parser, options)));
loader.register((parser) => new NodePlugin(parser));

export async function show(renderer: WebGLRenderer, camera: PerspectiveCamera, scene: Scene): Promise<string[]> {
    const gltf: BakedGLTF = await loader.loadAsync('baked.glb');
    scene.add(gltf.scene);
    const halflight: HalflightScene | null = plugin?.scene ?? gltf.userData.halflight ?? null;
    if (!halflight) return [];
    const mode: Mode = halflight.modes[0] ?? MODES[0]!;
    const view: View = VIEWS[0]!;
    halflight.mode = mode;
    halflight.debugView = view;
    halflight.shadowDistance = 40;
    halflight.shadowFadeRange = 2;
    halflight.shadowColor = [1, 2, 3];
    const light: BakedLight | undefined = halflight.lights.find((l) => l.name === 'sun');
    if (light) {
        light.castShadows = false;
        light.shadowStrength = 0.5;
        light.light.intensity *= 2;
    }
    const group: LightGroup | undefined = halflight.lightGroups[0];
    if (group) halflight.setLightGroup(group.name, group.savedWeight);
    halflight.setLightGroup('lamps', 0.5);
    while (halflight.isFollowing) halflight.update(renderer, camera);
    halflight.setLightGroup('lamps', [1, 0.5, 0.2]);
    halflight.setLightGroup('lamps', new Color(0xffaa88));
    // @ts-expect-error a weight is no text
    halflight.setLightGroup('lamps', 'red');
    const own = new Mesh();
    halflight.add(own);
    halflight.remove(own);
    const grid: LightProbeGridWebGL = halflight.toLightProbeGrid(LightProbeGridWebGL, { box: new Box3(), resolution: [4, 4, 4] });
    scene.add(grid);
    halflight.update(renderer, camera);
    halflight.update(renderer, camera, scene);
    halflight.dispose();
    const release: string | undefined = RELEASES[0];
    // @ts-expect-error it has a type: there is no such method
    gltf.userData.halflight?.draw();
    // @ts-expect-error there is no such mode
    halflight.mode = 'fast';
    // @ts-expect-error the warnings are the plug-in's
    halflight.warnings = new Set();
    return [...halflight.warnings, release ?? '', plugin?.name ?? ''];
}

export async function read(source: Source): Promise<number> {
    if (!isBaked(source.json)) return 0;
    const data: BakedData = await readBaked(source);
    const pages: Pixels[] = [...data.lightmaps, ...data.masks, ...data.directions];
    const probes: ProbeData | null = data.probes;
    const node: NodeData | undefined = data.nodes.get(0);
    const light: LightData | undefined = data.lights.get(0);
    const groups: GroupData[] = data.groups;
    pages.push(...composeLight(data, groups.map(({ weight }) => weight)).lightmaps);
    const reflected: (ReflectionPicture | null)[] = [composeReflections(data), ...groups.map(({ reflections }) => reflections)];
    pages.push(...reflected.flatMap((own) => (own ? [own.picture] : [])));
    const cells = probes?.cells?.vertices.length ?? 0;
    return pages.length + cells + (node?.lightmap?.page ?? 0) + (light?.channel ?? -1) + data.bytes.probes;
}
