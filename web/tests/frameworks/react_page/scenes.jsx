// What the tests mount, by name.
import { HalflightModel, useBakedObject, useHalflight } from '@halflight/react';
import { HalflightPlugin } from '@halflight/three';
import { Center, Clone, Gltf, OrbitControls, useGLTF } from '@react-three/drei';
import { useFrame, useThree } from '@react-three/fiber';
import { EffectComposer, ToneMapping } from '@react-three/postprocessing';
import { ToneMappingMode } from 'postprocessing';
import { Suspense, use, useEffect, useLayoutEffect, useRef } from 'react';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

export const decoders = { draco: new DRACOLoader().setDecoderPath('/draco/'), meshopt: MeshoptDecoder };

function Primitive({ url, position, clones }) {
    const [gltf, halflight] = useHalflight(url);
    useEffect(() => void window.held.push([gltf, halflight]), [gltf, halflight]);
    return clones ? <Clone object={gltf.scene} position={position} /> : <primitive object={gltf.scene} position={position} />;
}

function Ball({ bake, ...props }) {
    const ref = useRef(null);
    useBakedObject(ref, bake);
    return (
        <mesh ref={ref} name="ball" castShadow receiveShadow {...props}>
            <sphereGeometry args={[0.3]} />
            <meshStandardMaterial color="white" roughness={1} />
        </mesh>
    );
}

function OwnBake({ url, ...props }) {
    const [, halflight] = useHalflight(url);
    return <Ball bake={halflight} {...props} />;
}

/** Writes who acted in which order. */
function Order({ url }) {
    const [, halflight] = useHalflight(url);
    const controls = useThree((state) => state.controls);
    const gl = useThree((state) => state.gl);
    useLayoutEffect(() => {
        const undo = [[controls, 'update', 'controls'], [halflight, 'update', 'halflight'], [gl, 'render', 'render']].map(([object, name, label]) => {
            const act = object?.[name];
            if (object) object[name] = function (...args) { window.order.push(label); return act.apply(this, args); };
            return () => object && (object[name] = act);
        });
        return () => undo.forEach((take) => take());
    }, [controls, halflight, gl]);
    return null;
}

const plugin = (loader) => loader.register((parser) => new HalflightPlugin(parser));

/** By drei's loader, which is not three.js's. */
function Drei({ url, ...props }) {
    const { halflight } = useGLTF(url, false, true, plugin).userData;
    useFrame(({ gl, camera, scene }) => halflight.update(gl, camera, scene));
    useEffect(() => void (window.bake = halflight), [halflight]);
    return <Gltf src={url} useDraco={false} extendLoader={plugin} {...props} />;
}

function Slow() {
    use(window.slow);
    return null;
}

export const scenes = {
    nothing: () => null,
    drei: (props) => <Drei {...props} />,
    model: (props) => <HalflightModel {...props} />,
    decoded: (props) => <HalflightModel options={{ ...decoders }} {...props} />,
    hook: (props) => <Primitive {...props} />,
    twice: ({ url, positions }) => positions.map((position, i) => <HalflightModel key={i} url={url} position={position} />),
    'hook twice': ({ url, position }) => [<Primitive key="a" url={url} clones />, <Primitive key="b" url={url} position={position} clones />],
    center: ({ url }) => <Center><HalflightModel url={url} /></Center>,
    ball: ({ url, ball, ...props }) => <HalflightModel url={url}>{ball && <Ball {...props} />}</HalflightModel>,
    'ball of a hook': ({ url, position }) => [<HalflightModel key="a" url={url} />, <OwnBake key="b" url={url} position={position} />],
    'ball alone': (props) => <Ball {...props} />,
    slow: ({ url, slow }) => <><HalflightModel url={url} />{slow && <Slow />}</>,
    'own suspense': ({ url }) => <Suspense fallback={<group name="fallback" />}><HalflightModel url={url} /></Suspense>,
    controls: ({ url, target, composer }) => (
        <>
            <Order url={url} />
            <OrbitControls makeDefault target={target} />
            <HalflightModel url={url} />
            {composer && <EffectComposer multisampling={0}><ToneMapping mode={ToneMappingMode.NEUTRAL} /></EffectComposer>}
        </>
    ),
};
