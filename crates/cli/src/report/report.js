"use strict";

// Fills report.html from the JSON in #report-data. Names of files are user input: they only ever become
// textContent or attributes, never markup.

(() => {
  const { THREE, OrbitControls, Plot } = gmpcrLibraries;

  // ---------------------------------------------------------------------------------------- the data

  /** The report with what is derived from it: components by kind, edges by pair, largest values. */
  function readReport() {
    const report = JSON.parse(document.getElementById("report-data").textContent);
    const bySize = report.components.map((_, index) => index);
    bySize.sort((a, b) => report.components[b].scans.length - report.components[a].scans.length || a - b);
    report.registered = bySize.filter((c) => report.components[c].scans.length > 1);
    report.singles = bySize.filter((c) => report.components[c].scans.length === 1);
    report.largestWeight = largest(report.edges.map((edge) => edge.final_weight));
    report.largestConfidence = largest(report.confidences);
    report.edges.forEach((edge, index) => {
      edge.index = index;
      edge.relativeWeight = report.largestWeight > 0 ? Math.max(0, edge.final_weight) / report.largestWeight : 0;
      edge.hasFallen = edge.final_weight < edge.initial_weight / 2;
    });
    const edgeOfPair = new Map(report.edges.map((edge) => [pairKey(edge.i, edge.j), edge]));
    report.edgeBetween = (a, b) => edgeOfPair.get(pairKey(a, b)) ?? null;
    report.confidenceBetween = (a, b) => report.confidences[pairIndex(report.scans.length, a, b)];
    return report;
  }

  const largest = (values) => values.reduce((a, b) => Math.max(a, b), 0);
  const pairKey = (a, b) => `${Math.min(a, b)},${Math.max(a, b)}`;

  /** Place of a pair in the upper triangle without diagonal, row by row. */
  function pairIndex(n, a, b) {
    const [i, j] = a < b ? [a, b] : [b, a];
    return (i * (2 * n - i - 1)) / 2 + (j - i - 1);
  }

  /** Every pair (i, j) with i < j, in the order of `confidences`. */
  function allPairs(report) {
    const n = report.scans.length;
    const pairs = [];
    for (let i = 0; i < n; i++) for (let j = i + 1; j < n; j++) pairs.push({ i, j });
    pairs.forEach((pair, k) => (pair.confidence = report.confidences[k]));
    return pairs;
  }

  /** Points of a scan in the frame of its component, relative to the component's origin. */
  function decodePositions(scan, component) {
    const bytes = atob(scan.positions);
    const positions = new Float32Array(scan.count * 3);
    for (let k = 0; k < positions.length; k++) {
      positions[k] = component.step * (bytes.charCodeAt(2 * k) | (bytes.charCodeAt(2 * k + 1) << 8));
    }
    return positions;
  }

  // ----------------------------------------------------------------------------------------- wording

  const thinSpace = "\u202f";
  const minus = "\u2212";
  const dash = "\u2013";

  const count = (n) => n.toLocaleString("en-GB").replaceAll(",", thinSpace);
  const plural = (n, noun) => `${count(n)} ${noun}${n === 1 ? "" : "s"}`;
  const figure = (x) => String(Number(x.toPrecision(3))).replace("-", minus);
  const seconds = (s) => `${figure(s)}${thinSpace}s`;
  const pairName = ({ i, j }) => `${i}${thinSpace}${dash}${thinSpace}${j}`;

  /** What is known of an edge, as rows of term and value. */
  function evidence(edge) {
    const { rotation_residual: rotation, translation_residual: translation } = edge;
    return [
      ["confidence", figure(edge.confidence)],
      ["inlier ratio", figure(edge.inlier_ratio)],
      ["correspondences", count(edge.correspondences)],
      ["clique size", count(edge.clique_size)],
      ["cliques seen", count(edge.cliques_seen) + (edge.budget_exhausted ? " (budget exhausted)" : "")],
      ["weight", `${figure(edge.initial_weight)} → ${figure(edge.final_weight)}`],
      ["rotation residual", rotation === null ? "none: joins two components" : `${figure(rotation)}°`],
      ["translation residual", translation === null ? "none: joins two components" : figure(translation)],
    ];
  }

  // ---------------------------------------------------------------------------------- small DOM tools

  /** A new element; `properties` are set on it, except `data`, which goes to its dataset. */
  function element(tag, { data = {}, ...properties } = {}, ...children) {
    const node = Object.assign(document.createElement(tag), properties);
    Object.assign(node.dataset, data);
    node.append(...children);
    return node;
  }

  const byId = (id) => document.getElementById(id);
  const swatch = (colour) => {
    const node = element("span", { className: "swatch", ariaHidden: "true" });
    node.style.background = colour;
    return node;
  };
  const definitions = (rows) =>
    element("dl", {}, ...rows.map(([term, value]) =>
      element("div", {}, element("dt", { textContent: term }), element("dd", { textContent: value }))));
  const note = (text) => element("p", { className: "note", textContent: text });

  /** The children that Plot drew for the mark of class `className`, in the order of the mark's data. */
  const drawn = (svg, className) => [...svg.querySelectorAll(`.${className} > *`)];

  /** Shows what `describe()` returns, `{ title, rows }`, beside the pointer. */
  function showTooltip(event, { title, rows }) {
    const tooltip = byId("tooltip");
    tooltip.replaceChildren(element("strong", { textContent: title }), definitions(rows));
    tooltip.hidden = false;
    const { width, height } = tooltip.getBoundingClientRect();
    const right = event.clientX + 14 + width < innerWidth;
    tooltip.style.left = `${right ? event.clientX + 14 : Math.max(4, event.clientX - 14 - width)}px`;
    tooltip.style.top = `${Math.max(4, Math.min(event.clientY + 12, innerHeight - height - 6))}px`;
  }

  const hideTooltip = () => (byId("tooltip").hidden = true);

  // ----------------------------------------------------------------------------------------- colours

  const schemes = {
    viridis: Plot.scale({ color: { type: "linear", scheme: "viridis", domain: [0, 1] } }).apply,
    plasma: Plot.scale({ color: { type: "linear", scheme: "plasma", domain: [0, 1] } }).apply,
    blues: Plot.scale({ color: { type: "linear", scheme: "blues", domain: [0, 1] } }).apply,
    components: Plot.scale({ color: { type: "ordinal", scheme: "tableau10", domain: [...Array(10).keys()] } }).apply,
  };

  /** Colour of an edge by its final weight relative to the largest: weak is orange, strong is dark blue. */
  const weightColour = (relative) => schemes.plasma(0.78 * (1 - relative));
  const confidenceColour = schemes.blues;
  const scanColour = (scan) => `rgb(${scan.color.join(",")})`;

  function componentColour(report, component) {
    const rank = report.registered.indexOf(component);
    return rank < 0 ? "#9aa1a9" : schemes.components(rank % 10);
  }

  function rampLegend(label, domain, interpolate) {
    const options = { type: "linear", domain, interpolate, label };
    return Plot.legend({ color: options, width: 210, height: 46, marginTop: 17, ticks: 4, style: { background: "none" } });
  }

  const plotWidth = 560;
  const plotStyle = { className: "plot", width: plotWidth, style: { fontSize: "11.5px", background: "none" } };

  // --------------------------------------------------------------------------------------- selection

  /** What the user has picked: nothing, one or two scans, or an edge with its two scans. */
  class Selection {
    scans = [];
    edge = null;
    #listeners = [];

    onChange(listener) {
      this.#listeners.push(listener);
    }

    selectScans(report, scans) {
      const edge = scans.length === 2 ? report.edgeBetween(...scans) : null;
      const again = scans.length > 0 && scans.join() === this.scans.join();
      this.scans = again ? [] : scans;
      this.edge = again ? null : edge;
      for (const listener of this.#listeners) listener(this);
    }

    clear() {
      this.scans = [];
      this.edge = null;
      for (const listener of this.#listeners) listener(this);
    }
  }

  // ------------------------------------------------------------------------------------- the 3-D view

  const pointVertexShader = `
    uniform float pointSize, heightLow, heightSpan, byHeight, dimmed;
    uniform vec3 scanColour;
    uniform sampler2D ramp;
    varying vec3 colour;
    void main() {
      float height = clamp((position.z - heightLow) / heightSpan, 0.0, 1.0);
      colour = byHeight > 0.5 ? texture2D(ramp, vec2(height, 0.5)).rgb : scanColour;
      colour = mix(colour, vec3(0.88), dimmed);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      gl_PointSize = pointSize;
    }`;

  const pointFragmentShader = `
    uniform float pointSize;
    varying vec3 colour;
    void main() {
      if (pointSize > 2.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
      gl_FragColor = vec4(colour, 1.0);
    }`;

  const screenVertexShader = `
    varying vec2 at;
    void main() {
      at = uv;
      gl_Position = vec4(position.xy, 0.0, 1.0);
    }`;

  // Eye-dome lighting (Boucheny 2009): a pixel darkens by how much its neighbours are nearer to the eye.
  const screenFragmentShader = `
    uniform sampler2D colours, depths;
    uniform vec2 pixel;
    uniform float near, far;
    varying vec2 at;
    float logDepth(vec2 where) {
      return log2(near * far / (far - texture2D(depths, where).r * (far - near)));
    }
    void main() {
      vec4 colour = texture2D(colours, at);
      float shade = 1.0;
      if (texture2D(depths, at).r < 1.0) {
        float here = logDepth(at);
        float nearer = 0.0;
        nearer += max(0.0, here - logDepth(at + pixel * vec2(1.0, 0.0)));
        nearer += max(0.0, here - logDepth(at + pixel * vec2(-1.0, 0.0)));
        nearer += max(0.0, here - logDepth(at + pixel * vec2(0.0, 1.0)));
        nearer += max(0.0, here - logDepth(at + pixel * vec2(0.0, -1.0)));
        shade = 0.45 + 0.55 * exp(-8.0 * nearer);
      }
      gl_FragColor = vec4(colour.rgb * shade, 1.0);
    }`;

  /** Whether this browser can draw in 3-D, asked without making noise on the console. */
  const hasWebGl = () => document.createElement("canvas").getContext("webgl2") !== null;

  /** The merged scans of one component at a time. Draws when something has changed, not continuously. */
  class CloudView {
    #report;
    #renderer;
    #camera;
    #controls;
    #target;
    #screen;
    #shared;
    #scans;
    #clouds = new THREE.Scene();
    #overlay = new THREE.Scene();
    #component = null;
    #highlighted = new Set();
    #colouring = "scan";
    #explosion = 0;
    #overlayShown = { edges: false, frames: false };
    #radius = 1;
    #isScheduled = false;
    #isFitted = true;
    onPick = () => {};
    onFrame = () => {};

    constructor(report, frame) {
      THREE.ColorManagement.enabled = false;
      this.#report = report;
      this.#renderer = createRenderer(frame);
      this.#camera = new THREE.PerspectiveCamera(45, 1, 0.1, 100);
      this.#camera.up.set(0, 0, 1);
      this.#target = createTarget();
      this.#screen = createScreen(this.#target);
      this.#shared = createSharedUniforms();
      this.#scans = report.scans.map((scan, index) => createCloud(report, scan, index, this.#shared));
      for (const { points } of this.#scans) this.#clouds.add(points);
      this.#controls = this.#createControls();
      new ResizeObserver(() => this.#resize(frame)).observe(frame);
      this.#resize(frame);
      this.showComponent(report.registered[0] ?? report.singles[0] ?? null);
    }

    get component() {
      return this.#component;
    }

    /** World heights at the two ends of the colour ramp. */
    get heightRange() {
      const origin = this.#component === null ? 0 : this.#report.components[this.#component].origin[2];
      const { heightLow, heightSpan } = this.#shared;
      return [origin + heightLow.value, origin + heightLow.value + heightSpan.value];
    }

    showComponent(component) {
      this.#component = component;
      const scans = this.#scansShown();
      const heights = sampleHeights(scans);
      this.#shared.heightLow.value = heights[Math.floor(0.02 * heights.length)] ?? 0;
      const high = heights[Math.floor(0.98 * heights.length)] ?? 1;
      this.#shared.heightSpan.value = Math.max(high - this.#shared.heightLow.value, 1e-9);
      this.resetCamera();
      this.#refresh();
    }

    setVisible(scan, visible) {
      this.#scans[scan].isChecked = visible;
      this.#refresh();
    }

    /** Dims all scans but these; an empty list dims none. */
    highlight(scans) {
      this.#highlighted = new Set(scans);
      this.#refresh();
    }

    setColouring(colouring) {
      this.#colouring = colouring;
      this.#refresh();
    }

    setPointSize(pixels) {
      this.#shared.pointSize.value = pixels * this.#renderer.getPixelRatio();
      this.#schedule();
    }

    /** Moves each scan away from the component's centroid by `factor` times its own distance from there. */
    setExplosion(factor) {
      this.#explosion = factor;
      if (this.#isFitted) this.resetCamera();
      this.#refresh();
    }

    setOverlay(name, shown) {
      this.#overlayShown[name] = shown;
      this.#refresh();
    }

    resetCamera() {
      this.#stopDamping();
      this.#isFitted = true;
      const box = boundsOf(this.#scansShown());
      this.#radius = Math.max(box.radius, 1e-6);
      const halfAngle = Math.atan(Math.tan(Math.PI / 8) * Math.min(1, this.#camera.aspect));
      const distance = (this.#radius * (1 + 0.7 * this.#explosion)) / Math.sin(halfAngle);
      this.#controls.target.copy(box.centre);
      this.#camera.position.set(-0.45, -0.75, 0.62).normalize().multiplyScalar(distance).add(box.centre);
      this.#controls.update();
      this.#schedule();
    }

    /** Spends what is left of the last movement of the pointer. */
    #stopDamping() {
      this.#controls.enableDamping = false;
      this.#controls.update();
      this.#controls.enableDamping = true;
    }

    #createControls() {
      const canvas = this.#renderer.domElement;
      const controls = new OrbitControls(this.#camera, canvas);
      controls.enableDamping = true;
      controls.dampingFactor = 0.15;
      controls.zoomToCursor = true;
      controls.listenToKeyEvents(canvas);
      controls.addEventListener("change", () => this.#schedule());
      controls.addEventListener("start", () => (this.#isFitted = false));
      let pressed = null;
      canvas.addEventListener("pointerdown", (event) => (pressed = event));
      canvas.addEventListener("pointerup", (event) => {
        const moved = Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY);
        if (event.button === 0 && moved < 4) this.onPick(this.#scanAt(event.offsetX, event.offsetY));
      });
      return controls;
    }

    #scansShown() {
      return this.#scans.filter((scan) => scan.component === this.#component);
    }

    /** Brings visibility, colours, offsets and overlays in line with the state. */
    #refresh() {
      const shown = this.#scansShown();
      const isFocused = shown.some((scan) => this.#highlighted.has(scan.index));
      const centroid = meanOf(shown.filter((scan) => scan.count > 0).map((scan) => scan.centroid));
      for (const scan of this.#scans) {
        const isHighlighted = this.#highlighted.has(scan.index);
        const { points } = scan;
        points.visible = scan.component === this.#component && (scan.isChecked || isHighlighted);
        scan.isDimmed = isFocused && !isHighlighted;
        points.material.uniforms.dimmed.value = scan.isDimmed ? 1 : 0;
        points.material.uniforms.scanColour.value = this.#colouring === "component" ? scan.componentColour : scan.colour;
        // Dimmed points leave no depth behind, so that they never hide those that are not.
        points.material.depthWrite = !scan.isDimmed;
        points.renderOrder = scan.isDimmed ? -1 : 0;
        points.position.copy(scan.centroid).sub(centroid).multiplyScalar(this.#explosion);
      }
      this.#shared.byHeight.value = this.#colouring === "height" ? 1 : 0;
      this.#refreshOverlay(shown.filter((scan) => scan.points.visible && !scan.isDimmed));
      this.#schedule();
    }

    #refreshOverlay(scans) {
      for (const child of [...this.#overlay.children]) {
        child.geometry.dispose();
        child.material.dispose();
        this.#overlay.remove(child);
      }
      if (this.#overlayShown.edges) this.#addLines(edgeLines(this.#report.edges, scans), 2.5);
      if (this.#overlayShown.frames) this.#addLines(frameLines(scans, 0.06 * this.#radius), 2);
    }

    #addLines({ positions, colours }, linewidth) {
      if (positions.length === 0) return;
      const geometry = new THREE.LineSegmentsGeometry().setPositions(positions).setColors(colours);
      const material = new THREE.LineMaterial({ linewidth, vertexColors: true, depthTest: false });
      this.#overlay.add(new THREE.LineSegments2(geometry, material));
    }

    #resize(frame) {
      const { clientWidth: width, clientHeight: height } = frame;
      if (width === 0 || height === 0) return;
      this.#renderer.setSize(width, height, false);
      const pixels = this.#renderer.getDrawingBufferSize(new THREE.Vector3());
      this.#target.setSize(pixels.x, pixels.y);
      this.#screen.uniforms.pixel.value.set(1.3 / pixels.x, 1.3 / pixels.y, 0);
      this.#camera.aspect = width / height;
      if (this.#isFitted) this.resetCamera();
      this.#schedule();
    }

    #schedule() {
      if (this.#isScheduled) return;
      this.#isScheduled = true;
      requestAnimationFrame(() => {
        this.#isScheduled = false;
        this.#draw();
      });
    }

    #draw() {
      this.#controls.update(); // Schedules the next frame while damping still moves the camera.
      this.#fitClipping();
      const renderer = this.#renderer;
      renderer.setRenderTarget(this.#target);
      renderer.clear();
      renderer.render(this.#clouds, this.#camera);
      renderer.setRenderTarget(null);
      renderer.render(this.#screen.scene, this.#screen.camera);
      renderer.render(this.#overlay, this.#camera);
      this.onFrame();
    }

    /** The tightest clipping planes, which leave the depth buffer the most precision. */
    #fitClipping() {
      const reach = 2 * this.#radius * (1 + this.#explosion);
      const distance = this.#camera.position.distanceTo(this.#controls.target);
      this.#camera.near = Math.max(distance - reach, 0.002 * distance, 1e-4 * this.#radius);
      this.#camera.far = distance + reach;
      this.#camera.updateProjectionMatrix();
      this.#screen.uniforms.near.value = this.#camera.near;
      this.#screen.uniforms.far.value = this.#camera.far;
    }

    /** The scan of the nearest point drawn within a few pixels of a place on the canvas, or `null`. */
    #scanAt(x, y) {
      const { clientWidth: width, clientHeight: height } = this.#renderer.domElement;
      const point = new THREE.Vector3();
      let found = null;
      let nearest = Infinity;
      for (const scan of this.#scansShown().filter(({ points }) => points.visible)) {
        for (let k = 0; k < scan.positions.length; k += 3) {
          point.fromArray(scan.positions, k).add(scan.points.position).project(this.#camera);
          const offset = Math.hypot(((point.x + 1) / 2) * width - x, ((1 - point.y) / 2) * height - y);
          if (offset < 5 && point.z < nearest) [found, nearest] = [scan.index, point.z];
        }
      }
      return found;
    }
  }

  function createRenderer(frame) {
    const renderer = new THREE.WebGLRenderer({ antialias: true });
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    renderer.autoClear = false;
    renderer.setClearColor(0xf6f7f8);
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const canvas = renderer.domElement;
    canvas.tabIndex = 0;
    canvas.role = "img";
    canvas.ariaLabel = "Merged scans. Drag to orbit, drag with the right button to pan, scroll to zoom, click a point to select its scan.";
    frame.prepend(canvas);
    return renderer;
  }

  function createTarget() {
    const target = new THREE.WebGLRenderTarget(1, 1, { minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    target.depthTexture = new THREE.DepthTexture(1, 1);
    return target;
  }

  /** The rectangle that brings the drawn points to the screen, with shading. */
  function createScreen(target) {
    const uniforms = {
      colours: { value: target.texture },
      depths: { value: target.depthTexture },
      pixel: { value: new THREE.Vector3() },
      near: { value: 1 },
      far: { value: 2 },
    };
    const material = new THREE.ShaderMaterial({
      uniforms,
      vertexShader: screenVertexShader,
      fragmentShader: screenFragmentShader,
      depthTest: false,
      depthWrite: false,
    });
    const scene = new THREE.Scene();
    scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
    return { uniforms, scene, camera: new THREE.OrthographicCamera() };
  }

  /** Uniforms that the materials of all scans share. */
  function createSharedUniforms() {
    const size = 256;
    const texels = new Uint8Array(4 * size);
    for (let k = 0; k < size; k++) texels.set([...rgb(schemes.viridis(k / (size - 1))), 255], 4 * k);
    const ramp = new THREE.DataTexture(texels, size, 1);
    ramp.needsUpdate = true;
    return {
      pointSize: { value: 2 },
      heightLow: { value: 0 },
      heightSpan: { value: 1 },
      byHeight: { value: 0 },
      ramp: { value: ramp },
    };
  }

  /** The three bytes of a colour written as #rrggbb or rgb(r, g, b). */
  function rgb(colour) {
    const hex = colour.match(/^#(..)(..)(..)$/);
    return hex ? hex.slice(1).map((byte) => parseInt(byte, 16)) : colour.match(/\d+/g).map(Number);
  }

  const colourVector = (bytes) => new THREE.Vector3(...bytes.map((byte) => byte / 255));

  /** A scan as the view keeps it. */
  function createCloud(report, scan, index, shared) {
    const component = report.components[scan.component];
    const positions = decodePositions(scan, component);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    const colour = colourVector(scan.color);
    const material = new THREE.ShaderMaterial({
      uniforms: { ...shared, scanColour: { value: colour }, dimmed: { value: 0 } },
      vertexShader: pointVertexShader,
      fragmentShader: pointFragmentShader,
    });
    const points = new THREE.Points(geometry, material);
    points.frustumCulled = false;
    return {
      index,
      component: scan.component,
      count: scan.count,
      positions,
      points,
      colour,
      componentColour: colourVector(rgb(componentColour(report, scan.component))),
      pose: localPose(report.poses[index], component.origin),
      isChecked: true,
      isDimmed: false,
      ...extentOf(positions),
    };
  }

  /** Centroid and corners of some points. */
  function extentOf(positions) {
    const [sum, low, high] = [[0, 0, 0], [Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    positions.forEach((value, k) => {
      const axis = k % 3;
      sum[axis] += value;
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    });
    const n = Math.max(1, positions.length / 3);
    return { centroid: new THREE.Vector3(...sum.map((s) => s / n)), low, high };
  }

  /** Centre and radius of the box around some scans. */
  function boundsOf(scans) {
    const filled = scans.filter((scan) => scan.count > 0);
    if (filled.length === 0) return { centre: new THREE.Vector3(), radius: 1 };
    const corner = (pick, side) => new THREE.Vector3(...[0, 1, 2].map((a) => pick(...filled.map((scan) => scan[side][a]))));
    const [low, high] = [corner(Math.min, "low"), corner(Math.max, "high")];
    return { centre: low.clone().add(high).multiplyScalar(0.5), radius: low.distanceTo(high) / 2 };
  }

  function meanOf(vectors) {
    const sum = vectors.reduce((total, vector) => total.add(vector), new THREE.Vector3());
    return sum.divideScalar(Math.max(1, vectors.length));
  }

  /** Up to some thousand heights of some scans, sorted. */
  function sampleHeights(scans) {
    const total = scans.reduce((sum, scan) => sum + scan.count, 0);
    const stride = 3 * Math.max(1, Math.floor(total / 20000));
    const heights = [];
    for (const { positions } of scans) for (let k = 2; k < positions.length; k += stride) heights.push(positions[k]);
    return Float32Array.from(heights).sort();
  }

  /** Position of a scan and its three axes, relative to the component's origin. */
  function localPose(pose, origin) {
    const column = (c) => new THREE.Vector3(pose[c], pose[4 + c], pose[8 + c]);
    return { axes: [column(0), column(1), column(2)], position: column(3).sub(new THREE.Vector3(...origin)) };
  }

  /** Segments between the centroids of scans that an edge joins, coloured by weight. */
  function edgeLines(edges, scans) {
    const centres = new Map(scans.filter((scan) => scan.count > 0).map((scan) => [scan.index, scan.centroid.clone().add(scan.points.position)]));
    const joined = edges.filter(({ i, j }) => centres.has(i) && centres.has(j));
    return {
      positions: joined.flatMap(({ i, j }) => [...centres.get(i), ...centres.get(j)]),
      colours: joined.flatMap((edge) => {
        const colour = rgb(weightColour(edge.relativeWeight)).map((byte) => byte / 255);
        return [...colour, ...colour];
      }),
    };
  }

  /** The sensor frame of every scan: x red, y green, z blue. */
  function frameLines(scans, length) {
    const axisColours = [[0.85, 0.1, 0.1], [0.1, 0.6, 0.1], [0.1, 0.25, 0.9]];
    const positions = scans.flatMap(({ pose, points }) => {
      const start = pose.position.clone().add(points.position);
      return pose.axes.flatMap((axis) => [...start, ...start.clone().addScaledVector(axis, length)]);
    });
    const colours = scans.flatMap(() => axisColours.flatMap((colour) => [...colour, ...colour]));
    return { positions, colours };
  }

  // ------------------------------------------------------------------------ the controls of the view

  function labelled(text, input, before = true) {
    return before ? element("label", {}, text, input) : element("label", {}, input, text);
  }

  function choice(options, onChange, data) {
    const select = element("select", { data }, ...options.map(([value, textContent]) => element("option", { value, textContent })));
    select.addEventListener("change", () => onChange(select.value));
    return select;
  }

  function slider({ min, max, step, value, data }, onInput) {
    const input = element("input", { type: "range", min, max, step, data });
    input.value = value;
    input.addEventListener("input", () => onInput(Number(input.value)));
    return input;
  }

  function checkbox(onChange, data, checked = false) {
    const input = element("input", { type: "checkbox", checked, data });
    input.addEventListener("change", () => onChange(input.checked));
    return input;
  }

  /** Choice of the component to show: those of several scans, then scans on their own. */
  function componentChoice(report, show) {
    const several = report.registered.map((c) => [c, `${c}: ${plural(report.components[c].scans.length, "scan")}`]);
    const alone = report.singles.map((c) => [c, report.scans[report.components[c].scans[0]].name]);
    const select = choice([], (value) => show(Number(value)), { control: "component" });
    for (const [label, options] of [["Components", several], ["Not registered", alone]]) {
      if (options.length === 0) continue;
      const group = element("optgroup", { label }, ...options.map(([value, textContent]) => element("option", { value, textContent })));
      select.append(group);
    }
    return select;
  }

  /** Fills the toolbar; returns what keeps it in line with the component that is shown. */
  function renderControls(report, view, showComponent) {
    const legend = byId("view-legend");
    let colouring = "scan";
    const showLegend = () => {
      legend.hidden = colouring !== "height";
      legend.replaceChildren(rampLegend("Height, unit of the scans", view.heightRange, schemes.viridis));
    };
    const colourings = [["scan", "scan"], ["component", "component"], ["height", "height"]];
    const colour = choice(colourings, (value) => {
      colouring = value;
      view.setColouring(value);
      showLegend();
    }, { control: "colouring" });
    const size = slider({ min: 1, max: 8, step: 0.5, value: 2, data: { control: "size" } }, (value) => view.setPointSize(value));
    const explode = slider({ min: 0, max: 2, step: 0.02, value: 0, data: { control: "explode" } }, (value) => view.setExplosion(value));
    const edges = checkbox((shown) => view.setOverlay("edges", shown), { control: "edges" });
    const frames = checkbox((shown) => view.setOverlay("frames", shown), { control: "frames" });
    const component = componentChoice(report, showComponent);
    const reset = element("button", { type: "button", textContent: "Reset view", data: { control: "reset" } });
    reset.addEventListener("click", () => view.resetCamera());

    const controls = [
      labelled("Colour by", colour),
      labelled("Points", size),
      labelled("Explode", explode),
      labelled("Edges", edges, false),
      labelled("Sensor frames", frames, false),
      reset,
    ];
    if (report.components.length > 1) controls.unshift(labelled("Component", component));
    byId("view-controls").append(...controls);
    view.setPointSize(2);
    return () => {
      component.value = view.component;
      showLegend();
    };
  }

  // ------------------------------------------------------------------------------- header, attention

  function renderHeader(report) {
    document.title = `${report.title} ${dash} registration report`;
    byId("title").textContent = report.title;
    byId("summary").textContent = summary(report);
    const voxel = report.voxel === null ? "" : `, voxel ${figure(report.voxel)}`;
    byId("provenance").textContent = `${report.version}, ${report.features}${voxel}`;
  }

  function summary(report) {
    const total = report.stages.reduce((sum, stage) => sum + stage.seconds, 0);
    const main = report.registered[0];
    const together = main === undefined ? 0 : report.components[main].scans.length;
    const registered = together === 0 ? "none registered" : `${count(together)} registered in one frame`;
    const components = [
      report.registered.length > 1 ? `${plural(report.registered.length, "component")} of several scans` : null,
      report.singles.length > 0 && together > 0 ? `${plural(report.singles.length, "scan")} on ${report.singles.length === 1 ? "its" : "their"} own` : null,
    ].filter(Boolean);
    return [`${plural(report.scans.length, "scan")}, ${registered}`, ...components, plural(report.edges.length, "edge"), `${seconds(total)}.`].join("; ");
  }

  function renderAttention(report, selection) {
    const section = byId("attention");
    if (report.attention.length === 0) {
      section.append(note("Nothing stands out."));
      return;
    }
    const list = element("ul");
    for (const { scans, text } of report.attention) {
      const button = element("button", { type: "button", textContent: text, ariaPressed: "false" });
      button.addEventListener("click", () => selection.selectScans(report, scans));
      selection.onChange(() => (button.ariaPressed = String(scans.join() === selection.scans.join())));
      list.append(element("li", {}, button));
    }
    section.append(list);
  }

  // ------------------------------------------------------------------------------------ list of scans

  /** The list of scans with a checkbox each; returns what greys the scans outside the shown component. */
  function renderScans(report, view, selection) {
    const rows = report.scans.map((scan, index) => scanRow(report, index, view, selection));
    const list = element("div", { className: "scan-list" });
    for (const component of report.registered) {
      const { scans } = report.components[component];
      const title = `Component ${component}: ${plural(scans.length, "scan")}`;
      list.append(element("h3", {}, swatch(componentColour(report, component)), title), ...scans.map((s) => rows[s]));
    }
    if (report.singles.length > 0) {
      const singles = report.singles.map((component) => rows[report.components[component].scans[0]]);
      list.append(element("h3", {}, `Not registered: ${plural(singles.length, "scan")}`), ...singles);
    }
    byId("scans").append(scanTools(report, rows), list);
    selection.onChange(() => {
      rows.forEach((row, index) => row.classList.toggle("selected", selection.scans.includes(index)));
      if (selection.scans.length > 0) scrollWithin(list, rows[selection.scans[0]]);
    });
    return () => {
      rows.forEach((row, index) => {
        const isAway = view !== null && report.scans[index].component !== view.component;
        row.classList.toggle("away", isAway);
        row.querySelector("input").disabled = isAway || view === null;
      });
    };
  }

  function scanRow(report, index, view, selection) {
    const scan = report.scans[index];
    const preview = () => view.highlight(visible.checked ? [index] : selection.scans);
    const visible = checkbox((checked) => {
      view.setVisible(index, checked);
      if (row.matches(":hover")) preview();
    }, { scan: index }, true);
    visible.ariaLabel = `Show ${scan.name}`;
    const name = element("button", { type: "button", textContent: scan.name, title: scan.name });
    name.addEventListener("click", () => selection.selectScans(report, [index]));
    const row = element("div", { className: "scan" },
      visible,
      element("span", { className: "index", textContent: index }),
      swatch(scanColour(scan)),
      name,
      ...(scan.attention ? [element("span", { className: "attention-mark", textContent: "!", title: "Deserves a look" })] : []),
      element("span", { className: "count", textContent: count(scan.points), title: `${plural(scan.points, "point")}, ${count(scan.count)} of them drawn` }));
    if (view !== null) {
      row.addEventListener("mouseenter", preview);
      row.addEventListener("mouseleave", () => view.highlight(selection.scans));
    }
    return row;
  }

  /** Buttons that show or hide all scans of the list, and a filter by name. */
  function scanTools(report, rows) {
    const filter = element("input", { type: "search", placeholder: "Filter by name", ariaLabel: "Filter scans by name" });
    filter.addEventListener("input", () => {
      const wanted = filter.value.toLowerCase();
      rows.forEach((row, index) => (row.hidden = !report.scans[index].name.toLowerCase().includes(wanted)));
    });
    const setAll = (checked) => {
      for (const row of rows.filter((r) => !r.hidden)) {
        const box = row.querySelector("input");
        if (!box.disabled && box.checked !== checked) box.click();
      }
    };
    const button = (textContent, checked) => {
      const node = element("button", { type: "button", textContent, data: { show: textContent.toLowerCase() } });
      node.addEventListener("click", () => setAll(checked));
      return node;
    };
    return element("div", { className: "list-tools" }, "Show", button("All", true), button("None", false), filter);
  }

  /** Scrolls `list`, not the page, until `row` is in sight. */
  function scrollWithin(list, row) {
    const top = row.offsetTop - list.offsetTop;
    if (top < list.scrollTop + 24 || top > list.scrollTop + list.clientHeight - 30) list.scrollTop = top - list.clientHeight / 2;
  }

  // ------------------------------------------------------------------------------------ the selection

  /** The strip below the 3-D view with all that is known of the selection. */
  function renderSelection(report, selection) {
    const strip = byId("selection");
    const clear = element("button", { type: "button", textContent: "Clear", title: "Escape" });
    clear.addEventListener("click", () => selection.clear());
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && selection.scans.length > 0) selection.clear();
    });
    selection.onChange(() => {
      strip.hidden = selection.scans.length === 0;
      if (strip.hidden) return;
      const scans = selection.scans.map((index) => report.scans[index]);
      const names = scans.flatMap((scan, k) => [...(k > 0 ? [` ${dash} `] : []), swatch(scanColour(scan)), scan.name]);
      const parts = [element("h3", {}, ...names), clear, definitions(selectionRows(report, selection))];
      if (new Set(scans.map((scan) => scan.component)).size > 1) {
        parts.push(note("The two are in different components, whose poses do not compare: only one is shown."));
      }
      strip.replaceChildren(...parts);
    });
  }

  function selectionRows(report, { scans, edge }) {
    if (edge !== null) return [["edge", pairName(edge)], ...evidence(edge)];
    if (scans.length === 2) {
      const [i, j] = scans;
      return [["pair", pairName({ i, j })], ["confidence", figure(report.confidenceBetween(i, j))], ["", "no edge joins them"]];
    }
    return scanFacts(report, scans[0]);
  }

  function scanFacts(report, index) {
    const scan = report.scans[index];
    const isAlone = report.components[scan.component].scans.length === 1;
    return [
      ["scan", index],
      ["component", isAlone ? "none: not registered" : scan.component],
      ["points", count(scan.points)],
      ["edges", count(report.edges.filter(({ i, j }) => i === index || j === index).length)],
    ];
  }

  // -------------------------------------------------------------------------------------- pose graph

  const pairsInGraph = { smallestShare: 0.02, most: 3000 };

  /** Places of the scans on a circle, by component and index, with a gap between components. */
  function circleLayout(report) {
    const groups = report.registered.map((component) => report.components[component].scans);
    if (report.singles.length > 0) groups.push(report.singles.map((component) => report.components[component].scans[0]).sort((a, b) => a - b));
    const gap = groups.length > 1 ? Math.max(1, report.scans.length / 40) : 0;
    const slots = report.scans.length + gap * groups.length;
    const places = [];
    let slot = 0;
    for (const scans of groups) {
      for (const index of scans) {
        const angle = (2 * Math.PI * slot) / slots;
        places[index] = { x: Math.sin(angle), y: Math.cos(angle) };
        slot += 1;
      }
      slot += gap;
    }
    return places;
  }

  /** One line per pair between its two scans, bent towards the centre so that neighbours stay apart. */
  function arcs(places, pairs, style) {
    const bend = 0.78;
    const samples = pairs.flatMap((pair, z) => {
      const [from, to] = [places[pair.i], places[pair.j]];
      const middle = { x: (bend * (from.x + to.x)) / 2, y: (bend * (from.y + to.y)) / 2 };
      return [from, middle, to].map(({ x, y }) => ({ x, y, z, pair }));
    });
    return Plot.line(samples, { x: "x", y: "y", z: "z", curve: "basis", strokeWidth: 1, ...style });
  }

  /** The pairs worth a grey line: confident ones, the strongest if there are too many. */
  function confidentPairs(report) {
    const threshold = pairsInGraph.smallestShare * report.largestConfidence;
    const pairs = allPairs(report).filter(({ confidence }) => confidence > 0 && confidence >= threshold);
    return pairs.sort((a, b) => b.confidence - a.confidence).slice(0, pairsInGraph.most).reverse();
  }

  function renderGraph(report, selection) {
    const section = byId("graph");
    if (report.scans.length < 2) return void section.append(note("A pose graph needs two scans."));
    const places = circleLayout(report);
    const edges = [...report.edges].sort((a, b) => a.relativeWeight - b.relativeWeight);
    const indices = report.scans.map((_, index) => index);
    const labelled = indices.filter((index) => index % Math.ceil(report.scans.length / 90) === 0);
    const radius = Math.max(2, Math.min(5.5, 240 / report.scans.length));
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Scans on a circle, joined by the edges of the pose graph",
      height: 560,
      margin: 4,
      axis: null,
      x: { domain: [-1.1, 1.1] },
      y: { domain: [-1.1, 1.1] },
      marks: [
        arcs(places, confidentPairs(report), {
          className: "pairs",
          stroke: "#59636e",
          strokeOpacity: ({ pair }) => (0.5 * pair.confidence) / report.largestConfidence,
        }),
        arcs(places, report.unresolved, { className: "unresolved", stroke: "#c2410c", strokeDasharray: "3,4" }),
        arcs(places, edges, { className: "edges", stroke: ({ pair }) => weightColour(pair.relativeWeight), strokeWidth: 1.7 }),
        arcs(places, edges, { className: "hit", stroke: "transparent", strokeWidth: 8 }),
        Plot.dot(indices, {
          className: "nodes",
          x: (index) => places[index].x,
          y: (index) => places[index].y,
          r: radius,
          fill: (index) => scanColour(report.scans[index]),
          stroke: (index) => (report.scans[index].attention ? "#c2410c" : "#fff"),
          strokeWidth: (index) => (report.scans[index].attention ? 2.4 : 1),
        }),
        Plot.text(labelled, { x: (index) => 1.06 * places[index].x, y: (index) => 1.06 * places[index].y, text: String, fontSize: 10, fill: "#626a73" }),
      ],
    });
    bindEdges(report, svg, edges, drawn(svg, "edges"), drawn(svg, "hit"), selection);
    bindNodes(report, drawn(svg, "nodes"), selection);
    const legends = element("div", { className: "legends" }, rampLegend("Final weight, relative to the largest", [0, 1], weightColour));
    section.append(legends, element("figure", { className: "plot" }, svg), note(graphCaption(report)));
  }

  function graphCaption(report) {
    const unresolved = report.unresolved.length === 0 ? "" : ` Dashed: ${plural(report.unresolved.length, "selected pair")} for which no motion was found.`;
    return `Grey: confidence of a pair.${unresolved} Ringed: scans that deserve a look. Hover an edge for its evidence, click it to see its two scans.`;
  }

  /** Makes edges answer to the pointer, by the wider invisible `hits` over the `lines`. */
  function bindEdges(report, svg, edges, lines, hits, selection) {
    edges.forEach((edge, k) => {
      lines[k].classList.add("edge");
      lines[k].dataset.edge = edge.index;
      bindPointer(hits[k], lines[k], () => ({ title: edgeTitle(report, edge), rows: evidence(edge) }),
        () => selection.selectScans(report, [edge.i, edge.j]));
    });
    selection.onChange(() => markSelected(svg, lines, edges, selection));
  }

  const edgeTitle = (report, edge) => `${pairName(edge)}: ${report.scans[edge.i].name} ${dash} ${report.scans[edge.j].name}`;

  function markSelected(svg, lines, edges, selection) {
    const isSelected = (edge) => edge === selection.edge || (selection.scans.length === 1 && [edge.i, edge.j].includes(selection.scans[0]));
    svg.classList.toggle("selecting", selection.scans.length > 0);
    edges.forEach((edge, k) => lines[k].classList.toggle("selected", isSelected(edge)));
  }

  /** Tooltip and click on `target`, with `mark` emphasised while the pointer is over it. */
  function bindPointer(target, mark, describe, onClick) {
    target.addEventListener("mousemove", (event) => {
      mark.classList.add("hovered");
      showTooltip(event, describe());
    });
    target.addEventListener("mouseleave", () => {
      mark.classList.remove("hovered");
      hideTooltip();
    });
    target.addEventListener("click", onClick);
  }

  function bindNodes(report, nodes, selection) {
    nodes.forEach((node, index) => {
      node.classList.add("node");
      node.dataset.node = index;
      bindPointer(node, node, () => ({ title: report.scans[index].name, rows: scanFacts(report, index) }),
        () => selection.selectScans(report, [index]));
    });
    selection.onChange(() => nodes.forEach((node, index) => node.classList.toggle("selected", selection.scans.includes(index))));
  }

  // ------------------------------------------------------------------------------- confidence matrix

  /** Confidences as the full n x n matrix, row by row; the diagonal is empty. */
  function fullMatrix(report) {
    const n = report.scans.length;
    const values = new Array(n * n).fill(NaN);
    for (const { i, j, confidence } of allPairs(report)) values[i * n + j] = values[j * n + i] = confidence;
    return values;
  }

  function renderMatrix(report, selection) {
    const section = byId("matrix");
    const n = report.scans.length;
    if (n < 2) return void section.append(note("One scan has no pair."));
    const domain = [0, report.largestConfidence || 1];
    const cells = report.edges.flatMap((edge) => [{ edge, row: edge.i, column: edge.j }, { edge, row: edge.j, column: edge.i }]);
    const cell = 518 / n;
    const tickStep = [1, 2, 5, 10, 20, 50, 100, 200].find((step) => n / step <= 16) ?? 500;
    const ticks = Array.from({ length: Math.ceil(n / tickStep) }, (_, k) => k * tickStep);
    const axis = { domain: [0, n], ticks: ticks.map((t) => t + 0.5), tickFormat: (t) => String(Math.floor(t)), tickSize: 3, label: null };
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Confidence of every pair of scans",
      height: 542,
      margin: 4,
      marginTop: 20,
      marginLeft: 32,
      marginRight: 10,
      x: { ...axis, axis: "top" },
      y: { ...axis, reverse: true },
      color: { type: "linear", domain, interpolate: confidenceColour, unknown: "#e9ecef" },
      marks: [
        Plot.raster(fullMatrix(report), { width: n, height: n, imageRendering: "pixelated" }),
        Plot.rect(cells, {
          className: "cells",
          x1: ({ column }) => column,
          x2: ({ column }) => column + 1,
          y1: ({ row }) => row,
          y2: ({ row }) => row + 1,
          fill: "none",
          stroke: "#e8590c",
          strokeWidth: Math.max(0.7, Math.min(1.6, cell / 5)),
          inset: Math.min(1, cell / 10),
          pointerEvents: "none",
        }),
      ],
    });
    bindMatrix(report, svg, cells, selection);
    const legends = element("div", { className: "legends" }, rampLegend("Confidence", domain, confidenceColour));
    section.append(legends, element("figure", { className: "plot" }, svg),
      note("Rows and columns are the scans by index. Framed: the pairs selected as edges."));
  }

  /** The pair under the pointer, or `null` on the diagonal and outside. */
  function pairAt(report, svg, event) {
    const { left, top, width } = svg.getBoundingClientRect();
    const scale = plotWidth / width;
    const j = Math.floor(svg.scale("x").invert((event.clientX - left) * scale));
    const i = Math.floor(svg.scale("y").invert((event.clientY - top) * scale));
    const isScan = (index) => index >= 0 && index < report.scans.length;
    return isScan(i) && isScan(j) && i !== j ? { i: Math.min(i, j), j: Math.max(i, j) } : null;
  }

  function bindMatrix(report, svg, cells, selection) {
    const marks = drawn(svg, "cells");
    cells.forEach(({ edge }, k) => {
      marks[k].classList.add("edge");
      marks[k].dataset.edge = edge.index;
    });
    svg.addEventListener("mousemove", (event) => {
      const pair = pairAt(report, svg, event);
      if (pair === null) return hideTooltip();
      const edge = report.edgeBetween(pair.i, pair.j);
      const rows = edge === null ? [["confidence", figure(report.confidenceBetween(pair.i, pair.j))], ["edge", "no"]] : evidence(edge);
      showTooltip(event, { title: edgeTitle(report, pair), rows });
    });
    svg.addEventListener("mouseleave", hideTooltip);
    svg.addEventListener("click", (event) => {
      const pair = pairAt(report, svg, event);
      if (pair !== null) selection.selectScans(report, [pair.i, pair.j]);
    });
    selection.onChange(() => cells.forEach(({ edge }, k) => marks[k].classList.toggle("selected", edge === selection.edge)));
  }

  // ------------------------------------------------------------------------------------------ weights

  function renderWeights(report, selection) {
    const section = byId("weights");
    const iterations = largest(report.edges.map((edge) => edge.weights.length)) - 1;
    if (report.edges.length === 0) return void section.append(note("There are no edges."));
    if (iterations < 1) return void section.append(note("Nothing was reweighted: every edge keeps its initial weight."));
    const edges = [...report.edges].sort((a, b) => a.hasFallen - b.hasFallen);
    const fallen = edges.filter((edge) => edge.hasFallen);
    const samples = edges.flatMap((edge) => edge.weights.map((weight, iteration) => ({ edge, weight, iteration })));
    const line = { x: "iteration", y: "weight", z: (sample) => sample.edge.index };
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Weight of every edge after each iteration",
      height: 260,
      marginLeft: 40,
      marginRight: 12,
      marginBottom: 36,
      x: { label: "Iteration", ticks: Math.min(iterations, 12), tickFormat: "d", domain: [0, iterations] },
      y: { label: "Weight", grid: true, zero: true, ticks: 5 },
      marks: [
        Plot.ruleY([0], { stroke: "#c8ced4" }),
        Plot.line(samples, {
          ...line,
          className: "edges",
          stroke: (sample) => (sample.edge.hasFallen ? "#c2410c" : "#5b7a99"),
          strokeWidth: 1.4,
          strokeOpacity: (sample) => (sample.edge.hasFallen ? 0.95 : 0.35),
        }),
        Plot.line(samples, { ...line, className: "hit", stroke: "transparent", strokeWidth: 8 }),
      ],
    });
    bindEdges(report, svg, edges, drawn(svg, "edges"), drawn(svg, "hit"), selection);
    const lost = fallen.length === 0 ? "No edge lost more than half of its weight." : `${plural(fallen.length, "edge")} lost more than half of ${fallen.length === 1 ? "its" : "their"} weight.`;
    section.append(element("figure", { className: "plot" }, svg), note(lost));
  }

  // ------------------------------------------------------------------------------------ table of edges

  const edgeColumns = [
    { title: "Edge", value: (edge) => edge.i * 1e6 + edge.j, cell: pairName },
    { title: "Confi\u00addence", value: (edge) => edge.confidence },
    { title: "Inlier ratio", value: (edge) => edge.inlier_ratio },
    { title: "Corr.", value: (edge) => edge.correspondences, cell: (edge) => count(edge.correspondences) },
    { title: "Initial weight", value: (edge) => edge.initial_weight },
    { title: "Final weight", value: (edge) => edge.final_weight },
    { title: "Rot. °", value: (edge) => edge.rotation_residual },
    { title: "Transl.", value: (edge) => edge.translation_residual },
  ];

  function renderEdges(report, selection) {
    const section = byId("edges");
    if (report.edges.length === 0) return void section.append(note("No pair of scans became an edge."));
    const rows = report.edges.map((edge) => edgeRow(report, edge, selection));
    const body = element("tbody", {}, ...rows);
    const headings = edgeColumns.map((column) => sortableHeading(column, report, rows, body));
    const table = element("table", {}, element("thead", {}, element("tr", {}, ...headings)), body);
    const frame = element("div", { className: "table-frame", tabIndex: 0 }, table);
    selection.onChange(() => {
      rows.forEach((row, index) => row.classList.toggle("selected", report.edges[index] === selection.edge));
      if (selection.edge !== null) scrollWithin(frame, rows[selection.edge.index]);
    });
    section.append(frame);
  }

  function edgeRow(report, edge, selection) {
    const cells = edgeColumns.map(({ value, cell }) => {
      const shown = cell ?? ((e) => (value(e) === null ? dash : figure(value(e))));
      return element("td", { textContent: shown(edge) });
    });
    const button = element("button", { type: "button", textContent: pairName(edge), title: edgeTitle(report, edge) });
    cells[0].replaceChildren(swatch(weightColour(edge.relativeWeight)), button);
    cells[5].classList.toggle("fallen", edge.hasFallen);
    const row = element("tr", { data: { edge: edge.index } }, ...cells);
    row.addEventListener("click", () => selection.selectScans(report, [edge.i, edge.j]));
    return row;
  }

  /** A column heading that sorts by its column, the other way round when pressed again. */
  function sortableHeading({ title, value }, report, rows, body) {
    const button = element("button", { type: "button", textContent: title });
    const heading = element("th", { scope: "col" }, button);
    button.addEventListener("click", () => {
      const sign = heading.ariaSort === "ascending" ? -1 : 1;
      for (const other of heading.parentElement.children) other.removeAttribute("aria-sort");
      heading.ariaSort = sign > 0 ? "ascending" : "descending";
      const key = (row) => value(report.edges[row.dataset.edge]) ?? -1;
      body.append(...[...rows].sort((a, b) => sign * (key(a) - key(b))));
    });
    return heading;
  }

  // ------------------------------------------------------------------------------------------- stages

  function renderStages(report) {
    const { stages } = report;
    const total = stages.reduce((sum, stage) => sum + stage.seconds, 0);
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Seconds spent in each stage",
      height: 22 * stages.length + 8,
      margin: 4,
      marginLeft: 120,
      marginRight: 60,
      x: { axis: null },
      y: { domain: stages.map((_, k) => k), tickFormat: (k) => stages[k].name, tickSize: 0, label: null },
      marks: [
        Plot.barX(stages, { className: "bars", x: "seconds", y: (_, k) => k, fill: "#5b7a99", insetTop: 2, insetBottom: 2 }),
        Plot.text(stages, { x: "seconds", y: (_, k) => k, text: (stage) => seconds(stage.seconds), textAnchor: "start", dx: 5 }),
      ],
    });
    byId("stages").append(element("figure", { className: "plot" }, svg), note(`${seconds(total)} in total.`));
  }

  // --------------------------------------------------------------------------------------------- page

  function createView(report) {
    const frame = byId("canvas-frame");
    if (hasWebGl()) return new CloudView(report, frame);
    frame.append(element("p", { className: "message", textContent: "This browser offers no WebGL 2, which the 3-D view needs. The rest of the report works without it." }));
    byId("view-controls").hidden = true;
    return null;
  }

  /** Lets the view follow the selection, and the page the view. */
  function connectView(report, view, selection, followComponent) {
    const show = (component) => {
      view.showComponent(component);
      followComponent.forEach((follow) => follow());
    };
    followComponent.push(renderControls(report, view, show));
    selection.onChange(() => {
      const components = selection.scans.map((index) => report.scans[index].component);
      if (components.length > 0 && !components.includes(view.component)) show(components[0]);
      view.highlight(selection.scans);
    });
    view.onPick = (scan) => (scan === null ? selection.clear() : selection.selectScans(report, [scan]));
    view.onFrame = markReady;
  }

  const markReady = () => (document.body.dataset.ready = "true");

  function main() {
    const report = readReport();
    const selection = new Selection();
    renderHeader(report);
    renderAttention(report, selection);
    const view = createView(report);
    const followComponent = [renderScans(report, view, selection)];
    if (view !== null) connectView(report, view, selection, followComponent);
    renderSelection(report, selection);
    renderGraph(report, selection);
    renderMatrix(report, selection);
    renderWeights(report, selection);
    renderEdges(report, selection);
    renderStages(report);
    followComponent.forEach((follow) => follow());
    if (view === null) markReady();
  }

  main();
})();
