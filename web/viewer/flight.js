// Keys that move the camera together with what it orbits.
import { Vector3 } from 'three';

const DIRECTIONS = { KeyW: [0, 0, -1], KeyS: [0, 0, 1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyQ: [0, -1, 0], KeyE: [0, 1, 0] };
const METERS_PER_SECOND = 3;

export class Flight {
    /** @param {() => void} redraw requests a frame; each frame calls move() */
    constructor(camera, orbit, redraw) {
        this.camera = camera;
        this.orbit = orbit;
        this.redraw = redraw;
        this.keys = new Set();
        this.time = null;
        addEventListener('keydown', (event) => {
            if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
            if (event.ctrlKey || event.metaKey) return;
            this.keys.add(event.code);
            if (DIRECTIONS[event.code]) redraw();
        });
        addEventListener('keyup', (event) => this.keys.delete(event.code));
        addEventListener('blur', () => this.keys.clear());
    }

    /** Requests the next frame while a key is down. @param {number} time milliseconds */
    move(time) {
        const elapsed = this.time === null ? 0 : Math.min((time - this.time) / 1000, 0.1);
        const step = new Vector3();
        for (const key of this.keys) if (DIRECTIONS[key]) step.add(new Vector3(...DIRECTIONS[key]));
        this.time = step.lengthSq() > 0 ? time : null;
        if (step.lengthSq() === 0) return;
        const faster = this.keys.has('ShiftLeft') || this.keys.has('ShiftRight') ? 4 : 1;
        step.applyQuaternion(this.camera.quaternion).multiplyScalar(METERS_PER_SECOND * faster * elapsed);
        this.camera.position.add(step);
        this.orbit.target.add(step);
        this.orbit.update();
        this.redraw();
    }
}
