// A view as the address's fragment: camera, mode, shadows, exposure, debug view.
import { VIEWS } from '@halflight/three';

const numbers = (list) => list.map((x) => Number(x.toFixed(3))).join(',');

export function writeLink({ halflight, camera, orbit, renderer }) {
    return new URLSearchParams({
        eye: numbers(camera.position.toArray()),
        target: numbers(orbit.target.toArray()),
        fov: numbers([camera.fov]),
        mode: halflight.mode,
        view: halflight.debugView,
        distance: numbers([halflight.shadowDistance]),
        fade: numbers([halflight.shadowFadeRange]),
        exposure: numbers([renderer.toneMappingExposure]),
    }).toString();
}

/** What a link lacks, or has wrong, stays as it is. */
export function readLink(hash, { halflight, camera, orbit, renderer }) {
    const link = new URLSearchParams(hash.slice(1));
    const read = (name, count) => {
        const list = (link.get(name) ?? '').split(',').map(Number);
        return link.has(name) && list.length === count && list.every(Number.isFinite) ? list : null;
    };
    const eye = read('eye', 3);
    const target = read('target', 3);
    if (eye && target) {
        camera.position.fromArray(eye);
        orbit.target.fromArray(target);
        camera.fov = read('fov', 1)?.[0] ?? camera.fov;
        camera.updateProjectionMatrix();
        orbit.update();
    }
    if (halflight.modes.includes(link.get('mode'))) halflight.mode = link.get('mode');
    if (VIEWS.includes(link.get('view'))) halflight.debugView = link.get('view');
    halflight.shadowDistance = read('distance', 1)?.[0] ?? halflight.shadowDistance;
    halflight.shadowFadeRange = read('fade', 1)?.[0] ?? halflight.shadowFadeRange;
    renderer.toneMappingExposure = read('exposure', 1)?.[0] ?? renderer.toneMappingExposure;
}
