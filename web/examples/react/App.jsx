import { Suspense, useLayoutEffect } from 'react';
import { NeutralToneMapping } from 'three';
import { Canvas, useThree } from '@react-three/fiber';
import { HalflightModel, useHalflight } from '@halflight/react';

const EV = 2;
const FILE = 'courtyard-baked.glb';
useHalflight.preload(FILE);

/** The file's first camera. */
function FileCamera() {
    const [gltf] = useHalflight(FILE);
    const { set, size } = useThree();
    useLayoutEffect(() => {
        const camera = gltf.cameras[0];
        camera.aspect = size.width / size.height;
        camera.updateProjectionMatrix();
        set({ camera });
    }, [gltf, set, size]);
    return null;
}

export default function App() {
    const gl = { antialias: true, toneMapping: NeutralToneMapping, toneMappingExposure: 2 ** -EV };
    return (
        <Canvas shadows="percentage" frameloop="demand" gl={gl} style={{ position: 'fixed', inset: 0 }}>
            <Suspense>
                <FileCamera />
                <HalflightModel url={FILE} mode="shadowmask" shadowDistance={60} />
            </Suspense>
        </Canvas>
    );
}
