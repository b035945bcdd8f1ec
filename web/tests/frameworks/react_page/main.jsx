// A canvas whose scene the tests change.
import { useHalflight } from '@halflight/react';
import { Canvas, useFrame, useThree } from '@react-three/fiber';
import { Component, StrictMode, Suspense, useLayoutEffect } from 'react';
import { createRoot } from 'react-dom/client';
import { NeutralToneMapping, Vector3 } from 'three';

import { decoders, scenes } from './scenes.jsx';

const root = createRoot(document.getElementById('root'));
Object.assign(window, { held: [], order: [], frames: 0, failed: null, decoders, useHalflight });

/** Looks as the program's camera does; `offset` is where the file was put. */
function View({ fov, eye, target, offset = [0, 0, 0] }) {
    const get = useThree((state) => state.get);
    const key = JSON.stringify([fov, eye, target, offset]); // a frame is requested where it looks elsewhere, and only there
    useLayoutEffect(() => {
        const [fov, eye, target, offset] = JSON.parse(key);
        window.state = get;
        const { camera, invalidate } = get();
        camera.fov = fov;
        camera.near = 0.05;
        camera.far = 500;
        camera.position.fromArray(eye).add(new Vector3(...offset));
        camera.lookAt(new Vector3(...target).add(new Vector3(...offset)));
        camera.updateProjectionMatrix();
        invalidate();
    }, [get, key]);
    useFrame(() => void (window.frames += 1));
    return null;
}

class Boundary extends Component {
    state = { error: null };
    static getDerivedStateFromError = (error) => ({ error });
    render() {
        window.failed = this.state.error?.message ?? null;
        return this.state.error ? null : this.props.children;
    }
}

/** @param {string} name of a scene @param {any} props of it @param {any} view @param {any} canvas props */
window.show = (name, props, view, { exposure = 0, ...canvas } = {}) => {
    const gl = { antialias: false, toneMapping: NeutralToneMapping, toneMappingExposure: 2 ** -exposure };
    const Scene = scenes[name];
    root.render(
        <StrictMode>
            <Canvas shadows="percentage" frameloop="demand" dpr={1} gl={gl} {...canvas}>
                <View {...view} />
                <Boundary key={name}>
                    <Suspense fallback={<group name="fallback" />}><Scene {...props} /></Suspense>
                </Boundary>
            </Canvas>
        </StrictMode>
    );
};

/** Draws a frame now. @returns {string} PNG in base64 */
window.picture = () => {
    const { advance, gl } = window.state();
    advance(performance.now());
    return gl.domElement.toDataURL('image/png').split(',')[1];
};
