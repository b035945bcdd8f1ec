// Keys: some move the camera while they are down, others do one thing.
import { Vector3 } from 'three';

const STEPS = {
    KeyW: [0, 0, -1],
    KeyS: [0, 0, 1],
    KeyA: [-1, 0, 0],
    KeyD: [1, 0, 0],
    KeyQ: [0, -1, 0],
    KeyE: [0, 1, 0],
};
const TURNS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const RADIANS_PER_SECOND = 1;
const FASTER = 4; // with shift

/** Whether the control that has the focus needs a key itself. */
function needs({ target }, code) {
    if (target instanceof HTMLSelectElement) return true;
    if (target instanceof HTMLInputElement) return ['range', 'radio', 'number'].includes(target.type) && !STEPS[code];
    return false;
}

export class Keys {
    /**
     * @param {import('./orbit.js').Orbit} orbit @param {() => void} redraw requests a frame; each frame calls move()
     * @param {Record<string, () => void>} actions by code of the key
     */
    constructor(orbit, redraw, actions) {
        this.orbit = orbit;
        this.down = new Set();
        this.time = null;
        this.redraw = redraw;
        /** Metres a second. */
        this.speed = 3;
        addEventListener('keydown', (event) => {
            const { code } = event;
            if (event.ctrlKey || event.metaKey || event.altKey || needs(event, code)) return;
            if (STEPS[code] || TURNS[code]) {
                this.down.add(code);
                redraw();
            } else if (actions[code] && !event.repeat) actions[code]();
            if (TURNS[code]) event.preventDefault(); // the panel would scroll
            this.shift = event.shiftKey;
        });
        addEventListener('keyup', (event) => {
            this.down.delete(event.code);
            this.shift = event.shiftKey;
        });
        addEventListener('blur', () => this.down.clear());
    }

    /** Moves the camera, and requests the next frame while a key is down. @param {number} time milliseconds */
    move(time) {
        if (this.down.size === 0) {
            this.time = null;
            return;
        }
        const seconds = this.time === null ? 0 : Math.min((time - this.time) / 1000, 0.1);
        this.time = time;
        const step = new Vector3();
        const turn = [0, 0];
        for (const code of this.down) {
            if (STEPS[code]) step.add(new Vector3(...STEPS[code]));
            for (const axis of [0, 1]) turn[axis] += TURNS[code]?.[axis] ?? 0;
        }
        const amount = seconds * (this.shift ? FASTER : 1);
        if (turn[0] !== 0 || turn[1] !== 0)
            this.orbit.look(turn[0] * RADIANS_PER_SECOND * amount, turn[1] * RADIANS_PER_SECOND * amount);
        if (step.lengthSq() > 0)
            this.orbit.move(step.applyQuaternion(this.orbit.camera.quaternion).multiplyScalar(this.speed * amount));
        this.redraw();
    }
}
