// All of the public API of @halflight/react, as an application would use it: compiled by types.mjs, never run.
import { HalflightModel, useBakedObject, useHalflight, type HalflightModelProps, type HalflightOptions } from '@halflight/react';
import type { BakedGLTF, HalflightScene } from '@halflight/three';
import { useRef, type ReactElement } from 'react';
import type { Group, Mesh } from 'three';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

const options: HalflightOptions = { draco: new DRACOLoader(), meshopt: MeshoptDecoder, sky: false };
useHalflight.preload('baked.glb', options);
useHalflight.clear('baked.glb');

function Ball({ bake }: { bake: HalflightScene | null }): ReactElement {
    const ref = useRef<Mesh>(null);
    useBakedObject(ref, bake);
    useBakedObject(ref);
    return <mesh ref={ref} />;
}

export function Level(props: Partial<HalflightModelProps>): ReactElement {
    const group = useRef<Group>(null);
    const [gltf, halflight] = useHalflight('baked.glb', options);
    const file: BakedGLTF = gltf;
    const names: string[] = [...Object.keys(gltf.nodes), ...(halflight?.lights.map((light) => light.name) ?? []), file.asset.version ?? ''];
    return (
        <group>
            <primitive object={gltf.scene} position={[0, 1, 0]} />
            <HalflightModel ref={group} url="baked.glb" mode="shadowmask" shadowDistance={40} shadowFadeRange={2} debugView="lit" name={names[0]} scale={2} {...props}>
                <Ball bake={halflight} />
            </HalflightModel>
            {/* @ts-expect-error there is no such mode */}
            <HalflightModel url="baked.glb" mode="fast" />
            {/* @ts-expect-error a model has a URL */}
            <HalflightModel mode="shadowmask" />
        </group>
    );
}
