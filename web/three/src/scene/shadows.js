// Shadow maps of three.js for the plug-in: where their cameras look, their biases, and who casts into them.
import { Box3, Matrix4, REVISION, Sphere, Vector3 } from 'three';

const CASTERS_OF_A_LIGHT_HAVE_LAYERS = Number.parseInt(REVISION, 10) >= 187;
/** Texels by which a receiver moves along its normal, as ShadowSettings::normalBiasTexels. */
const NORMAL_BIAS = 1.8;
const NEAREST_METERS = 0.02;

/** What a camera sees nearer than the shadow distance, by its projection: headsets' eyes have no field of view. @returns {Sphere} */
function sphereOf(camera, distance) {
    const m = camera.projectionMatrix.elements;
    const sphere = new Sphere();
    if (m[11] === 0) {
        const depth = Math.min(camera.far, distance);
        sphere.center.set(-m[12] / m[0], -m[13] / m[5], -0.5 * depth);
        sphere.radius = Math.hypot(1 / m[0], 1 / m[5], 0.5 * depth);
    } else {
        // Of a cone's part up to radial distance d, with half angle a: the sphere about its axis' point at d cos(a) for
        // wide cones, at d / (2 cos(a)) for narrow ones.
        const cosine = 1 / Math.hypot(1, (1 + Math.abs(m[8])) / m[0], (1 + Math.abs(m[9])) / m[5]);
        const d = Math.min(camera.far / cosine, distance);
        const center = Math.min(d * cosine, (0.5 * d) / cosine);
        sphere.center.set(0, 0, -center);
        sphere.radius = Math.sqrt(Math.max(d * d - 2 * d * center * cosine + center * center, 0));
    }
    return sphere.applyMatrix4(camera.matrixWorld);
}

/** The same of a camera or of several, such as both eyes of a headset. @returns {Sphere} */
function visibleSphere(camera, distance) {
    const cameras = camera.isArrayCamera && camera.cameras.length > 0 ? camera.cameras : [camera];
    return cameras.map((one) => sphereOf(one, distance)).reduce((all, sphere) => all.union(sphere));
}

/**
 * A square around what the camera sees, or around the scene where that is smaller, moved in whole texels so that shadow
 * edges rest while the camera moves. @param {Box3} sceneBox in bake space
 */
function fitDirectional(light, camera, distance, sceneBox, instance) {
    const shadow = light.shadow;
    const c = shadow.camera;
    const position = new Vector3().setFromMatrixPosition(light.matrixWorld);
    const target = new Vector3().setFromMatrixPosition(light.target.matrixWorld);
    const lightFromWorld = new Matrix4().lookAt(position, target, c.up).setPosition(position).invert();
    const box = sceneBox.clone().applyMatrix4(lightFromWorld.clone().multiply(instance.worldFromBake));
    const sphere = visibleSphere(camera, distance).applyMatrix4(lightFromWorld);
    const side = Math.max(box.max.x - box.min.x, box.max.y - box.min.y) * 1.001;
    const size = shadow.mapSize.x;
    const half = Math.min(sphere.radius, 0.5 * side) * (size / (size - 8));
    const middle = half < sphere.radius ? box.getCenter(new Vector3()) : sphere.center;
    const texel = (2 * half) / size;
    const x = Math.round(middle.x / texel) * texel;
    const y = Math.round(middle.y / texel) * texel;
    const slack = 0.01 * instance.scale + 0.001 * (box.max.z - box.min.z);
    Object.assign(c, { left: x - half, right: x + half, bottom: y - half, top: y + half });
    c.near = -box.max.z - slack;
    c.far = -box.min.z + slack;
    c.updateProjectionMatrix();
    return texel;
}

function fitLocal(light, sceneBox, { scale, bakeFromWorld }) {
    const c = light.shadow.camera;
    const position = new Vector3().setFromMatrixPosition(light.matrixWorld).applyMatrix4(bakeFromWorld);
    const farthest = sceneBox.isEmpty() ? 100 : new Vector3().subVectors(
        new Vector3(
            Math.abs(position.x - sceneBox.min.x) > Math.abs(position.x - sceneBox.max.x) ? sceneBox.min.x : sceneBox.max.x,
            Math.abs(position.y - sceneBox.min.y) > Math.abs(position.y - sceneBox.max.y) ? sceneBox.min.y : sceneBox.max.y,
            Math.abs(position.z - sceneBox.min.z) > Math.abs(position.z - sceneBox.max.z) ? sceneBox.min.z : sceneBox.max.z
        ), position).length() + 0.01;
    const far = light.distance > 0 ? light.distance / scale : farthest;
    c.near = NEAREST_METERS * scale;
    c.far = far * scale;
    c.updateProjectionMatrix();
    const tangent = light.isSpotLight ? Math.tan(Math.min(light.angle, 1.5)) : 1;
    return (2 * tangent * 0.5 * Math.min(far, 10) * scale) / light.shadow.mapSize.x; // a texel half way
}

/** @param {import('./lights.js').BakedLight} state @param {number} distance metres of the file @param {Box3} sceneBox in bake space */
export function fitShadow(state, camera, distance, sceneBox) {
    const { light } = state;
    const shadow = light.shadow;
    const bias = state.data.shadowBias;
    const texel = light.isDirectionalLight ? fitDirectional(light, camera, distance * state.instance.scale, sceneBox, state.instance) : fitLocal(light, sceneBox, state.instance);
    shadow.normalBias = (bias.normal ?? NORMAL_BIAS) * texel;
    const depth = shadow.camera.far - shadow.camera.near;
    shadow.bias = light.isDirectionalLight ? (-(bias.depth ?? 0.1) * texel) / depth : -2e-5;
}

/**
 * Lets only dynamic objects into a light's shadow map, or all. Shadow cameras have layers of their own in WebGPURenderer,
 * and in WebGLRenderer since three.js 0.187; before, the shadow camera's frustum leaves static objects out.
 * @param {import('./lights.js').BakedLight} state @param {number} layer of dynamic objects
 */
export function chooseCasters(state, layer, renderer) {
    const shadow = state.light.shadow;
    const all = state.plan.staticCasters;
    if (all) shadow.camera.layers.mask = state.before.shadowLayers;
    else shadow.camera.layers.set(layer);
    if (CASTERS_OF_A_LIGHT_HAVE_LAYERS || !renderer.isWebGLRenderer) return;
    const frustum = shadow.getFrustum();
    delete frustum.intersectsObject;
    if (all) return;
    const test = frustum.intersectsObject;
    frustum.intersectsObject = function (object) {
        return object.layers.isEnabled(layer) && test.call(this, object);
    };
}

export function releaseCasters(state) {
    const frustum = state.light.shadow?.getFrustum();
    if (frustum) delete frustum.intersectsObject;
}

/** Union of the objects' boxes in bake space. @param {import('./objects.js').BakedObject[]} objects */
export function boundsOf(objects) {
    const box = new Box3();
    for (const object of objects) box.union(object.bakeBox());
    return box;
}
