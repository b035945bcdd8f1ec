// The camera turns about what is under the pointer, and comes nearer to it: OrbitControls moves a handle that looks at
// that point, and the camera stays beside the handle.
import { PerspectiveCamera, Raycaster, Vector2, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

export class Orbit {
    /**
     * @param {PerspectiveCamera} camera @param {HTMLElement} element that takes mouse and touch
     * @param {() => import('three').Object3D | null} solid what the pointer may be on @param {() => void} changed
     */
    constructor(camera, element, solid, changed) {
        this.camera = camera;
        this.element = element;
        this.solid = solid;
        this.handle = new PerspectiveCamera();
        this.distance = 1;
        /** The camera's place in the handle's plane. */
        this.beside = new Vector2();
        this.pointers = new Map();
        this.placing = false;
        element.addEventListener('pointerdown', (event) => this.#press(event), { capture: true });
        for (const name of ['pointerup', 'pointercancel'])
            addEventListener(name, (event) => this.pointers.delete(event.pointerId));
        element.addEventListener('wheel', (event) => this.aboutPixel(event.clientX, event.clientY), {
            capture: true,
            passive: true,
        });
        this.controls = new OrbitControls(this.handle, element);
        this.controls.addEventListener('change', () => {
            this.#follow();
            if (!this.placing) changed();
        });
    }

    #press(event) {
        if (event.pointerType !== 'touch') this.pointers.clear();
        this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
        const places = [...this.pointers.values()];
        const mean = (axis) => places.reduce((sum, place) => sum + place[axis], 0) / places.length;
        this.aboutPixel(mean(0), mean(1));
    }

    #follow() {
        const { camera, handle, controls, beside } = this;
        const distance = handle.position.distanceTo(controls.target);
        beside.multiplyScalar(distance / this.distance); // the point stays under the pointer
        this.distance = distance;
        camera.quaternion.copy(handle.quaternion);
        camera.position.set(beside.x, beside.y, 0).applyQuaternion(handle.quaternion).add(handle.position);
        camera.updateMatrixWorld();
    }

    /** Middle of the picture at the depth that the camera turns about. */
    get target() {
        return this.camera.getWorldDirection(new Vector3()).multiplyScalar(this.distance).add(this.camera.position);
    }

    /** What a pixel of the page shows, or a point as far away as the last one where it shows nothing. */
    pick(clientX, clientY) {
        const { left, top, width, height } = this.element.getBoundingClientRect();
        const place = new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
        const caster = new Raycaster();
        caster.setFromCamera(place, this.camera);
        const solid = this.solid();
        const hit = solid
            ? caster
                  .intersectObject(solid)
                  .find(({ object, distance }) => object.visible && distance > this.camera.near)
            : null;
        return hit?.point ?? caster.ray.at(this.distance, new Vector3());
    }

    aboutPixel(clientX, clientY) {
        this.about(this.pick(clientX, clientY));
    }

    /** The camera stays where it is and turns about `point` from now on. */
    about(point) {
        const { camera, handle, controls } = this;
        camera.updateMatrixWorld();
        const seen = camera.worldToLocal(point.clone());
        this.distance = Math.max(-seen.z, camera.near);
        this.beside.set(-seen.x, -seen.y);
        handle.quaternion.copy(camera.quaternion);
        handle.position.set(seen.x, seen.y, 0).applyQuaternion(camera.quaternion).add(camera.position);
        handle.fov = camera.fov;
        controls.target.set(0, 0, -this.distance).applyQuaternion(handle.quaternion).add(handle.position);
        controls.minDistance = Math.min(2 * camera.near, this.distance);
        this.placing = true;
        controls.update();
        this.placing = false;
    }

    /** @param {Vector3} eye @param {Vector3} target in the middle of the picture */
    place(eye, target) {
        this.camera.position.copy(eye);
        this.camera.lookAt(target);
        this.about(target);
    }

    /**
     * Takes the view of a camera of the file.
     * @param {import('three').Camera} from @param {number} distance of what the camera turns about
     */
    take(from, distance) {
        from.updateWorldMatrix(true, false);
        const eye = new Vector3().setFromMatrixPosition(from.matrixWorld);
        const forward = from.getWorldDirection(new Vector3());
        if (Math.abs(forward.y) > 0.9999)
            // Straight down has no heading, so the view leans to the camera's up.
            forward.addScaledVector(new Vector3().setFromMatrixColumn(from.matrixWorld, 1), 0.02).normalize();
        this.place(eye, forward.multiplyScalar(distance).add(eye));
    }

    /** @param {Vector3} step of the camera and of what it turns about */
    move(step) {
        this.place(this.camera.position.clone().add(step), this.target.add(step));
    }

    /** Turns the camera where it stands. @param {number} left @param {number} up radians */
    look(left, up) {
        const forward = this.camera.getWorldDirection(new Vector3());
        const right = new Vector3(1, 0, 0).applyQuaternion(this.camera.quaternion);
        const raised = Math.asin(Math.min(Math.max(forward.y, -1), 1)) + up;
        if (Math.abs(raised) < 1.55) forward.applyAxisAngle(right, up);
        forward.applyAxisAngle(new Vector3(0, 1, 0), left);
        this.place(this.camera.position.clone(), forward.multiplyScalar(this.distance).add(this.camera.position));
    }
}
