// SPDX-License-Identifier: MIT
// One canvas behind several panes: each pane is an element of the page with a scene, a camera and
// its own mouse and touch, drawn into its rectangle of the canvas when something has changed.
import * as THREE from './three.module.min.js';
import { OrbitControls } from './OrbitControls.js';

const FIELD_OF_VIEW = 32;
const TURN = Math.PI / 24; // an arrow key
const ASLANT = 0.5; // how much a look at a cell leans towards home's direction
const SAMPLES = 4000; // points that framing looks at
const SLOW = 25; // ms that a picture may take the graphics card
const STUCK = 100; // ms after which one that is not done yet takes too long, whatever came before
const COARSE = 0.5; // of the pixels a side, where it takes longer, while something moves
const REST_MS = 250; // without a move, after which the picture is drawn in full
const POLL_MS = 2;
// From where a part may be seen at first, the most liked first.
const HOMES = [
  [0.55, -1.1],
  [1.1, -0.55],
  [1.1, 0.55],
  [0.55, 1.1],
  [-0.55, -1.1],
  [-1.1, -0.55],
  [-1.1, 0.55],
  [-0.55, 1.1],
].map(([x, y]) => new THREE.Vector3(x, y, 0.85).normalize());
const LIKED = 1.1; // so much better another one has to be

/** The direction that shows the most of a part whose area vectors add up to `area`. */
function homeOf(area) {
  const shown = (home) => Math.abs(home.dot(area));
  return HOMES.reduce((best, home) => (shown(home) > LIKED * shown(best) ? home : best));
}

/** The same vertices with other triangles between them. */
export function withIndex(geometry, index) {
  const other = new THREE.BufferGeometry();
  other.setIndex(new THREE.BufferAttribute(index, 1));
  for (const [name, attribute] of Object.entries(geometry.attributes))
    other.setAttribute(name, attribute);
  other.boundingSphere = geometry.boundingSphere;
  return other;
}

/** Whether a processor stands in for the graphics card. */
function isEmulated() {
  const options = { failIfMajorPerformanceCaveat: true };
  const context = document.createElement('canvas').getContext('webgl2', options);
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return !context;
}

/** What draws a texture over the whole viewport. */
function makeEnlarger() {
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: { map: { value: null } },
    vertexShader: `
      out vec2 at;
      void main() {
        at = uv;
        gl_Position = vec4(position.xy, 0.0, 1.0);
      }`,
    fragmentShader: `
      uniform sampler2D map;
      in vec2 at;
      layout(location = 0) out vec4 colour;
      void main() { colour = texture(map, at); }`,
    depthTest: false,
    depthWrite: false,
    blending: THREE.NoBlending,
  });
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
  mesh.frustumCulled = false;
  return mesh;
}

class Pane {
  /** `flat`: seen straight from above, without turning. `twin`: shares that pane's camera. */
  constructor(stage, element, { flat = false, twin = null } = {}) {
    this.stage = stage;
    this.element = element;
    this.flat = flat;
    this.scene = new THREE.Scene();
    this.camera = twin
      ? twin.camera
      : flat
        ? new THREE.OrthographicCamera()
        : new THREE.PerspectiveCamera(FIELD_OF_VIEW);
    if (!flat) this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, element);
    if (twin) this.controls.target = twin.controls.target;
    this.controls.enableRotate = !flat;
    if (flat) {
      this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN;
      this.controls.touches.ONE = THREE.TOUCH.PAN;
    }
    this.controls.zoomToCursor = true;
    this.turning = false; // by the pointer
    this.turned = false; // so: a click alone turns nothing
    this.controls.addEventListener('start', () => {
      this.turning = true;
      this.turned = false;
    });
    this.controls.addEventListener('change', () => {
      this.turned ||= this.turning;
      if (this.turning) stage.move(this.camera);
      else stage.redraw(this.camera);
    });
    this.controls.addEventListener('end', () => {
      this.turning = false;
      if (this.turned) stage.onView();
    });
    element.addEventListener('keydown', (event) => this.#key(event));
    this.radius = 1;
    this.points = [0, 0, 0];
    [this.direction] = HOMES;
    this.half = [1, 1];
    this.centre = [0, 0];
    this.stale = true; // its picture is to be drawn anew
    this.coarse = false; // so was it drawn
    this.costs = [0, 0]; // ms of its last pictures in full
  }

  /** ms of a picture in full, of two, because the first one with a shader also waits for that. */
  get cost() {
    return Math.min(...this.costs);
  }

  get visible() {
    return this.element.offsetWidth > 0 && this.element.offsetHeight > 0;
  }

  /** What `home` shows: points (x, y, z, x, ...) within `radius` of the origin, with normals. */
  frame({ radius, position, normal }) {
    this.radius = radius;
    this.points = position;
    const area = new THREE.Vector3();
    for (let k = 0; k < normal.length; k++)
      area.setComponent(k % 3, area.getComponent(k % 3) + normal[k]);
    this.direction = homeOf(area);
  }

  /** The same for a flat pane: a rectangle. */
  frameFlat(half, centre) {
    this.radius = Math.hypot(...half);
    this.half = half;
    this.centre = centre;
    this.home();
  }

  /** Where the eye looks and how far away it is to see all points from its direction. */
  #fitAll() {
    const back = this.direction;
    const right = new THREE.Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const point = new THREE.Vector3();
    const seen = [];
    const step = 3 * Math.ceil(this.points.length / 3 / SAMPLES);
    for (let k = 0; k < this.points.length; k += step) {
      point.fromArray(this.points, k);
      seen.push([point.dot(right), point.dot(up), point.dot(back)]);
    }
    const middle = [0, 1].map((axis) => {
      const values = seen.map((place) => place[axis]);
      return (Math.min(...values) + Math.max(...values)) / 2;
    });
    const slope = Math.tan((FIELD_OF_VIEW * Math.PI) / 360) / 1.12;
    const { offsetWidth, offsetHeight } = this.element;
    const aspect = offsetWidth / offsetHeight || 1;
    const need = ([x, y, z]) =>
      z + Math.max(Math.abs(x - middle[0]) / aspect, Math.abs(y - middle[1])) / slope;
    const target = right.multiplyScalar(middle[0]).addScaledVector(up, middle[1]);
    return { target, away: Math.max(...seen.map(need)) };
  }

  home() {
    const { camera, controls, radius } = this;
    if (this.flat) {
      controls.target.set(...this.centre, 0);
      camera.position.set(...this.centre, radius * 10);
      camera.zoom = 1;
    } else {
      const { target, away } = this.#fitAll();
      controls.target.copy(target);
      camera.position.copy(this.direction).multiplyScalar(away).add(target);
    }
    camera.near = radius / 500;
    camera.far = radius * 60;
    controls.update();
    this.stage.redraw(camera);
  }

  /** Looks at the middle of four corners, aslant from that side of them which no part of `body` hides,
   *  of two free ones the one where the eye is, from half as far as home. */
  lookAt(corners, body) {
    const { camera, controls, radius } = this;
    const [a, b, c, d] = corners.map((corner) => new THREE.Vector3(...corner));
    const middle = a.clone().add(b).add(c).add(d).multiplyScalar(0.25);
    const normal = c.clone().sub(a).cross(d.sub(b)).normalize();
    if (normal.dot(camera.position.clone().sub(middle)) < 0) normal.negate();
    const wayTo = (side) => side.clone().addScaledVector(this.direction, ASLANT).normalize();
    const hidden = (way) => {
      const caster = new THREE.Raycaster(middle.clone().addScaledVector(way, 0.02 * radius), way);
      return body && caster.intersectObject(body).length > 0;
    };
    const ways = [normal, normal.clone().negate()].map(wayTo);
    const way = ways.find((one) => !hidden(one)) ?? ways[0];
    controls.target.copy(middle);
    camera.position.copy(middle).addScaledVector(way, this.#fitAll().away / 2);
    controls.update();
    this.stage.redraw(camera);
  }

  /** The view as numbers that do not depend on the size of the part. */
  get view() {
    const { camera, controls, radius } = this;
    const numbers = [...camera.position.toArray(), ...controls.target.toArray()];
    return numbers.map((value) => Number((value / radius).toFixed(3)));
  }

  set view(numbers) {
    const { camera, controls, radius } = this;
    camera.position.fromArray(numbers).multiplyScalar(radius);
    controls.target.fromArray(numbers, 3).multiplyScalar(radius);
    controls.update();
    this.stage.redraw(camera);
  }

  #key(event) {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.target !== this.element || event.altKey || event.ctrlKey || event.metaKey) return;
    if (moves[event.key]) this.#turn(...moves[event.key]);
    else if (event.key === '+' || event.key === '=') this.#zoom(0.85);
    else if (event.key === '-') this.#zoom(1 / 0.85);
    else if (event.key === 'Home' || event.key === '0') this.home();
    else return;
    event.preventDefault();
    this.controls.update();
    this.stage.move(this.camera);
    this.stage.onView();
  }

  #turn(aside, down) {
    const { camera, controls } = this;
    if (this.flat) {
      const step = (0.1 * this.radius) / camera.zoom;
      for (const point of [camera.position, controls.target])
        point.add(new THREE.Vector3(aside * step, -down * step, 0));
      return;
    }
    const offset = camera.position.clone().sub(controls.target);
    const sphere = new THREE.Spherical().setFromVector3(
      new THREE.Vector3(offset.x, offset.z, -offset.y),
    );
    sphere.theta += aside * TURN;
    sphere.phi = Math.min(Math.max(sphere.phi + down * TURN, 0.01), Math.PI - 0.01);
    const turned = new THREE.Vector3().setFromSpherical(sphere);
    camera.position.set(turned.x, -turned.z, turned.y).add(controls.target);
  }

  #zoom(factor) {
    if (this.flat) this.camera.zoom /= factor;
    else
      this.camera.position
        .sub(this.controls.target)
        .multiplyScalar(factor)
        .add(this.controls.target);
  }

  /** Fits the camera to the pane's shape. */
  fit(width, height) {
    const { camera } = this;
    if (this.flat) {
      const [x, y] = this.half.map((value) => value * 1.08);
      const scale = Math.max(x / width, y / height);
      Object.assign(camera, {
        left: -scale * width,
        right: scale * width,
        top: scale * height,
        bottom: -scale * height,
      });
    } else {
      camera.aspect = width / height;
    }
    camera.updateProjectionMatrix();
  }

  /** Pixels in the pane of a point in the scene, and whether it lies before the eye. */
  project(point) {
    const { offsetWidth, offsetHeight } = this.element;
    this.fit(offsetWidth, offsetHeight); // panes that share the camera differ in shape
    this.camera.updateMatrixWorld();
    const p = new THREE.Vector3(...point).project(this.camera);
    return { x: ((p.x + 1) / 2) * offsetWidth, y: ((1 - p.y) / 2) * offsetHeight, shown: p.z < 1 };
  }

  /** The pixels of a unit of length where the eye looks. */
  get pixelsOfUnit() {
    const { camera, controls, radius } = this;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const aside = controls.target.clone().addScaledVector(right, radius);
    const [a, b] = [controls.target, aside].map((point) => this.project(point.toArray()));
    return Math.hypot(b.x - a.x, b.y - a.y) / radius;
  }

  /** The ray through a place of the window. */
  ray(clientX, clientY) {
    const box = this.element.getBoundingClientRect();
    const x = ((clientX - box.left) / box.width) * 2 - 1;
    const y = 1 - ((clientY - box.top) / box.height) * 2;
    const caster = new THREE.Raycaster();
    this.fit(box.width, box.height);
    caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return caster;
  }
}

export class Stage {
  /** Throws where there is no WebGL 2. */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({
      canvas,
      alpha: true,
      antialias: !isEmulated(),
      preserveDrawingBuffer: true, // panes that have not changed keep their pictures
    });
    this.renderer.setScissorTest(true);
    this.target = new THREE.WebGLRenderTarget(1, 1);
    this.enlarger = makeEnlarger();
    this.panes = [];
    this.onView = () => {};
    this.onFrame = () => {};
    this.onCoarse = () => {};
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  addPane(element, options) {
    const pane = new Pane(this, element, options);
    this.panes.push(pane);
    return pane;
  }

  /** Draws soon, once for all calls until then: the panes of a camera, or all. */
  redraw(camera = null) {
    for (const pane of this.panes) pane.stale ||= !camera || pane.camera === camera;
    this.pending ||= requestAnimationFrame(() => {
      this.pending = null;
      this.draw();
    });
  }

  /** As `redraw`, for a picture that is soon followed by another: with fewer pixels and triangles
   *  where the graphics card is slow. */
  move(camera = null) {
    this.moving = true;
    this.redraw(camera);
    this.#rest();
  }

  /** Draws in full what was not, when nothing has moved for a while, no pointer is still about to
   *  turn it, and all that was asked for is drawn. */
  #rest() {
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      if (this.pending || this.fence || this.panes.some(({ turning }) => turning)) this.#rest();
      else this.#restore();
    }, REST_MS);
  }

  #restore() {
    this.moving = false;
    for (const pane of this.panes) if (pane.coarse) this.redraw(pane.camera);
  }

  /** ms that the graphics card takes for the pictures in full. */
  get cost() {
    const age = this.fence ? performance.now() - this.begun : 0;
    const costs = this.panes.filter(({ visible }) => visible).map(({ cost }) => cost);
    return Math.max(age > STUCK ? age : 0, ...costs);
  }

  get slow() {
    return this.cost > SLOW;
  }

  /** Notes how long the graphics card takes for what was drawn. */
  #clock(drawn) {
    if (this.fence) return;
    const gl = this.renderer.getContext();
    const begun = (this.begun = performance.now());
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      const done = gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.UNSIGNALED;
      if (!done && !gl.isContextLost()) return setTimeout(look, POLL_MS);
      gl.deleteSync(this.fence);
      this.fence = null;
      const cost = performance.now() - begun;
      for (const pane of drawn) pane.costs = [pane.costs[1], cost];
    };
    setTimeout(look, POLL_MS);
  }

  #resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const size = this.renderer.getSize(new THREE.Vector2());
    const ratio = Math.min(window.devicePixelRatio, 2);
    const same = this.renderer.getPixelRatio() === ratio;
    if (same && size.x === clientWidth && size.y === clientHeight) return;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(clientWidth, clientHeight, false);
    for (const pane of this.panes) pane.stale = true;
  }

  draw() {
    this.#resize();
    const { renderer, canvas } = this;
    const box = canvas.getBoundingClientRect();
    if (this.panes.every(({ stale }) => stale)) {
      renderer.setScissor(0, 0, box.width, box.height);
      renderer.clear();
    }
    const coarse = Boolean(this.moving && this.slow);
    const drawn = this.panes.filter((pane) => pane.stale && pane.visible);
    for (const pane of drawn) {
      const own = pane.element.getBoundingClientRect();
      const rectangle = [own.left - box.left, box.bottom - own.bottom, own.width, own.height];
      pane.fit(own.width, own.height);
      pane.stale = false;
      pane.coarse = coarse;
      this.onCoarse(coarse);
      if (coarse) this.#enlarge(pane, rectangle);
      else this.#render(pane.scene, pane.camera, rectangle);
    }
    this.#clock(coarse ? [] : drawn);
    this.onFrame();
  }

  #render(scene, camera, rectangle) {
    this.renderer.setViewport(...rectangle);
    this.renderer.setScissor(...rectangle);
    this.renderer.render(scene, camera);
  }

  /** Draws a pane with fewer pixels, and these larger. */
  #enlarge({ scene, camera }, [x, y, width, height]) {
    const { renderer, enlarger } = this;
    const { map } = enlarger.material.uniforms;
    const ratio = renderer.getPixelRatio();
    const [wide, high] = [width, height].map((side) => Math.ceil(side * ratio * COARSE));
    if (map.value?.image.width !== wide || map.value?.image.height !== high) {
      map.value?.dispose();
      map.value = new THREE.FramebufferTexture(wide, high);
      map.value.minFilter = map.value.magFilter = THREE.LinearFilter;
    }
    this.#render(scene, camera, [x, y, wide / ratio, high / ratio]);
    renderer.copyFramebufferToTexture(
      map.value,
      new THREE.Vector2(Math.round(x * ratio), Math.round(y * ratio)),
    );
    this.#render(enlarger, camera, [x, y, width, height]);
  }

  /** The vertex that owns what `mesh` shows at a place of the window, -1 for nothing: the mesh is
   *  drawn once more, into one pixel, with numbers for colours. `within`: the group it is in. */
  pick(pane, mesh, clientX, clientY, within = mesh) {
    const { renderer, target } = this;
    this.onCoarse(false);
    const box = pane.element.getBoundingClientRect();
    const material = mesh.material;
    const others = [...pane.scene.children, ...within.children].filter(
      (object) => object !== mesh && object !== within && object.visible,
    );
    for (const object of others) object.visible = false;
    mesh.material = mesh.userData.picking;
    pane.fit(box.width, box.height);
    pane.camera.setViewOffset(box.width, box.height, clientX - box.left, clientY - box.top, 1, 1);
    renderer.setRenderTarget(target);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.render(pane.scene, pane.camera);
    const bytes = new Uint8Array(4);
    renderer.readRenderTargetPixels(target, 0, 0, 1, 1, bytes);
    renderer.setRenderTarget(null);
    renderer.setScissorTest(true);
    pane.camera.clearViewOffset();
    mesh.material = material;
    for (const object of others) object.visible = true;
    return new DataView(bytes.buffer).getInt32(0, true) - 1;
  }
}
