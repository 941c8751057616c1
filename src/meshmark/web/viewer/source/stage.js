// The scene: one surface, a camera that orbits it, and lights that go with the camera.

import {
  BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, HemisphereLight, Mesh, MeshStandardMaterial,
  PerspectiveCamera, Scene, Spherical, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { cornerNormals } from "./normals.js";
import { skinMaterials } from "./skin.js";

const FIELD = 28; // degrees, the camera's field of view upright
const START = { azimuth: 0.5585, elevation: 0.2967 }; // radians to the right of the front, and above it
const MARGIN = 1.1;
const TURN = 0.12, STEP = 0.06, CLOSER = 0.85; // of one press of a key: radians, part of the distance, factor
const RESET = 280; // milliseconds

const still = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Stage {
  /** surface: {positions, triangles}; `drawn` is called after each picture. */
  constructor(surface, drawn) {
    this.drawn = drawn;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setClearColor(0x000000, 0);
    this.canvas = this.renderer.domElement;
    this.camera = new PerspectiveCamera(FIELD, 1, 0.01, 100);
    this.scene = new Scene();
    this.#light();
    this.#surface(surface);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = !still();
    this.controls.dampingFactor = 0.14;
    this.controls.screenSpacePanning = true;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.request());
    this.controls.addEventListener("start", () => { this.way = null; });
    this.width = this.height = 0;
  }

  #light() {
    this.scene.add(new HemisphereLight(0xffffff, 0x8f8a82, 1.05));
    const key = new DirectionalLight(0xfffaf2, 2.0);
    key.position.set(-0.9, 1.1, 1.2);
    const fill = new DirectionalLight(0xe6eeff, 0.35);
    fill.position.set(1.2, -0.1, 0.8);
    const rim = new DirectionalLight(0xffffff, 0.45);
    rim.position.set(0.3, 0.6, -1.2);
    for (const light of [key, fill, rim]) { // children of the camera, aimed at what it looks at
      this.camera.add(light, light.target);
      light.target.position.set(0, 0, -1);
      light.position.z -= 1;
    }
    this.scene.add(this.camera);
  }

  #surface({ positions, triangles }) {
    this.triangles = triangles;
    this.points = positions;
    this.geometry = new BufferGeometry();
    const corners = new Float32Array(3 * triangles.length);
    triangles.forEach((vertex, corner) => corners.set(positions.subarray(3 * vertex, 3 * vertex + 3), 3 * corner));
    this.geometry.setAttribute("position", new BufferAttribute(corners, 3));
    this.geometry.setAttribute("normal", new BufferAttribute(cornerNormals(positions, triangles), 3));
    this.geometry.setAttribute("color", new BufferAttribute(new Float32Array(corners.length).fill(0.7), 3));
    this.geometry.computeBoundingBox();
    this.middle = this.geometry.boundingBox.getCenter(new Vector3());
    this.size = this.geometry.boundingBox.getSize(new Vector3()).length() || 1;
    this.material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.72, metalness: 0, side: DoubleSide });
    this.mesh = new Mesh(this.geometry, this.material);
    this.scene.add(this.mesh);
  }

  /** Get images ready that `paint` may show. */
  wear({ images, groups, places }) {
    this.geometry.setAttribute("uv", new BufferAttribute(places, 2));
    for (const { start, count, image } of groups) this.geometry.addGroup(start, count, image);
    this.materials = skinMaterials(images, this.material, () => this.request());
  }

  /** Show linear colours (3 a corner); dressed: times the images. */
  paint(colours, dressed = false) {
    this.mesh.material = dressed ? this.materials : this.material;
    this.geometry.attributes.color.array.set(colours);
    this.geometry.attributes.color.needsUpdate = true;
    this.request();
  }

  resize(width, height) {
    if (!width || !height || (width === this.width && height === this.height)) return;
    const first = !this.width;
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    if (first || this.untouched) this.reset(true);
    this.camera.updateProjectionMatrix();
    this.request();
  }

  /** The place from which all of the surface is seen. */
  #start() {
    const towards = new Vector3().setFromSpherical(new Spherical(1, Math.PI / 2 - START.elevation, START.azimuth));
    const right = new Vector3().crossVectors(new Vector3(0, 1, 0), towards).normalize();
    const up = new Vector3().crossVectors(towards, right);
    const tall = Math.tan((FIELD * Math.PI) / 360);
    const wide = tall * this.camera.aspect;
    const point = new Vector3();
    let away = 0;
    for (let i = 0; i < this.points.length; i += 3) {
      point.fromArray(this.points, i).sub(this.middle);
      const across = Math.abs(point.dot(right)) / wide, along = Math.abs(point.dot(up)) / tall;
      away = Math.max(away, MARGIN * Math.max(across, along) + point.dot(towards));
    }
    return this.middle.clone().addScaledVector(towards, away || this.size);
  }

  reset(atOnce = still()) {
    const [from, to, target] = [this.camera.position.clone(), this.#start(), this.controls.target.clone()];
    this.camera.near = this.size / 1000;
    this.camera.far = this.size * 50;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = this.size / 50;
    this.controls.maxDistance = this.size * 8;
    const began = performance.now();
    this.way = () => {
      const share = atOnce ? 1 : Math.min((performance.now() - began) / RESET, 1);
      const eased = 1 - (1 - share) ** 3;
      this.camera.position.lerpVectors(from, to, eased);
      this.controls.target.lerpVectors(target, this.middle, eased);
      if (share === 1) this.way = null;
    };
    if (atOnce) this.way();
    this.controls.update();
    this.untouched = true;
    this.request();
  }

  /** Turn by steps to the right and upwards. */
  turn(right, up) {
    this.#moved((offset) => {
      const place = new Spherical().setFromVector3(offset);
      place.theta -= right * TURN;
      place.phi = Math.min(Math.max(place.phi + up * TURN, 0.01), Math.PI - 0.01);
      offset.setFromSpherical(place);
    });
  }

  /** Come closer by a step (1), or go away (-1). */
  zoom(closer) {
    this.#moved((offset) => {
      const length = offset.length() * CLOSER ** closer;
      offset.setLength(Math.min(Math.max(length, this.controls.minDistance), this.controls.maxDistance));
    });
  }

  /** Move the surface by steps to the right and upwards. */
  pan(right, up) {
    this.#moved((offset) => {
      const step = offset.length() * STEP;
      const aside = new Vector3().setFromMatrixColumn(this.camera.matrix, 0).multiplyScalar(-right * step);
      aside.addScaledVector(new Vector3().setFromMatrixColumn(this.camera.matrix, 1), -up * step);
      this.controls.target.add(aside);
    });
  }

  #moved(change) {
    this.way = null;
    const offset = this.camera.position.clone().sub(this.controls.target);
    change(offset);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.untouched = false;
    this.request();
  }

  /** Draw soon, once, however often it is asked for. */
  request() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      if (this.way) { this.way(); this.request(); }
      this.controls.update();
      this.renderer.render(this.scene, this.camera);
      this.drawn();
    });
  }

  dispose() {
    cancelAnimationFrame(this.frame);
    this.controls.dispose();
    this.geometry.dispose();
    this.material.dispose();
    for (const each of this.materials ?? []) { each.map?.dispose(); each.dispose(); }
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }
}
