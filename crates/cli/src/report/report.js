"use strict";

// Fills report.html from the JSON in #report-data. Names of files are user input: they only ever become
// textContent or attributes, never markup.

(() => {
  const { THREE, OrbitControls, Plot } = gmpcrLibraries;

  // ---------------------------------------------------------------------------------------- the data

  /** An edge that kept less than this fraction of its weight is dropped: it contradicts the result. */
  const smallestKeptFraction = 0.1;

  /** The report with what is derived from it: components by kind, edges by pair and by what became of them. */
  function readReport() {
    const report = JSON.parse(document.getElementById("report-data").textContent);
    const bySize = report.components.map((_, index) => index);
    bySize.sort((a, b) => report.components[b].scans.length - report.components[a].scans.length || a - b);
    report.registered = bySize.filter((c) => report.components[c].scans.length > 1);
    report.singles = bySize.filter((c) => report.components[c].scans.length === 1);
    report.scoredPairs = report.scored_pairs.map(([i, j, confidence]) => ({ i, j, confidence }));
    report.largestConfidence = largest(report.scoredPairs.map(({ confidence }) => confidence));
    const bridges = new Set(report.warnings.filter(({ kind }) => kind === "bridge").map(({ edge }) => pairKey(...edge)));
    report.edges.forEach((edge, index) => {
      edge.index = index;
      edge.keptFraction = fractionOf(edge.final_weight, edge);
      edge.isKept = edge.keptFraction >= smallestKeptFraction;
      edge.isBridge = bridges.has(pairKey(edge.i, edge.j));
    });
    report.kept = report.edges.filter((edge) => edge.isKept);
    report.dropped = report.edges.filter((edge) => !edge.isKept);
    const edgeOfPair = new Map(report.edges.map((edge) => [pairKey(edge.i, edge.j), edge]));
    report.edgeBetween = (a, b) => edgeOfPair.get(pairKey(a, b)) ?? null;
    const confidenceOfPair = new Map(report.scoredPairs.map(({ i, j, confidence }) => [pairKey(i, j), confidence]));
    report.confidenceBetween = (a, b) => confidenceOfPair.get(pairKey(a, b)) ?? null;
    return report;
  }

  /** A weight of an edge, relative to its initial one. */
  const fractionOf = (weight, edge) => (edge.initial_weight > 0 ? Math.min(1, Math.max(0, weight / edge.initial_weight)) : 0);
  const largest = (values) => values.reduce((a, b) => Math.max(a, b), 0);
  const pairKey = (a, b) => `${Math.min(a, b)},${Math.max(a, b)}`;

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
  const seconds = (s) => (s < 0.1 ? `${(1e3 * s).toFixed(1)}${thinSpace}ms` : `${s.toFixed(2)}${thinSpace}s`);
  const list = (parts) => parts.join(", ").replace(/, ([^,]*)$/, " and $1");

  /** With so many decimals, or as less than the smallest number that they can tell from 0. */
  function decimals(x, digits) {
    const smallest = 10 ** -digits;
    return x > 0 && x < smallest ? `< ${smallest.toFixed(digits)}` : x.toFixed(digits).replace("-", minus);
  }

  const confidenceText = (confidence) => (confidence === null ? "not scored" : decimals(confidence, 3));
  const weightText = (weight) => decimals(weight, 4);
  const percent = (fraction) => `${decimals(100 * fraction, 0)}${thinSpace}%`;
  const pairName = ({ i, j }) => `${i}${thinSpace}${dash}${thinSpace}${j}`;

  /** Support and diagnostics of an edge, as rows of term and value. */
  function edgeFacts(edge) {
    return [
      ["confidence", confidenceText(edge.confidence)],
      ["inlier ratio", percent(edge.inlier_ratio)],
      ["correspondences", count(edge.correspondences)],
      ["clique size", count(edge.clique_size)],
      ["cliques seen", count(edge.cliques_seen) + (edge.budget_exhausted ? " (budget exhausted)" : "")],
      ["weight", `${weightText(edge.initial_weight)} → ${weightText(edge.final_weight)}`],
      ["kept", percent(edge.keptFraction) + (edge.isKept ? "" : " (dropped)")],
      ["rotation residual", residual(edge, edge.rotation_residual, (angle) => `${decimals(angle, 2)}°`)],
      ["translation residual", residual(edge, edge.translation_residual, figure)],
    ];
  }

  /** By how much the result differs from the relative pose of an edge. */
  function residual(edge, value, format) {
    if (value === null) return `${dash} (connects two components)`;
    return edge.isBridge ? `${dash} (nothing to compare with)` : format(value);
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
  const swatch = (color) => {
    const node = element("span", { className: "swatch", ariaHidden: "true" });
    node.style.background = color;
    return node;
  };
  const definitions = (rows) =>
    element("dl", {}, ...rows.map(([term, value]) =>
      element("div", {}, element("dt", { textContent: term }), element("dd", { textContent: value }))));
  const note = (text) => element("p", { className: "note", textContent: text });

  /** The children that Plot drew for the mark of class `className`, in the order of the mark's data. */
  const drawn = (svg, className) => [...svg.querySelectorAll(`.${className} > *`)];

  /** Shows a title and rows of term and value beside the pointer. */
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

  // ----------------------------------------------------------------------------------------- colors

  const schemes = {
    viridis: Plot.scale({ color: { type: "linear", scheme: "viridis", domain: [0, 1] } }).apply,
    gnbu: Plot.scale({ color: { type: "linear", scheme: "gnbu", domain: [0, 1] } }).apply,
    grays: Plot.scale({ color: { type: "linear", scheme: "greys", domain: [0, 1] } }).apply,
  };

  const bridgeColor = "#d9480f";
  const droppedColor = "#e3bfa6";
  const pairColor = "#59636e";

  /** Color of a kept edge by the fraction of its weight that it kept, and of any edge by what became of it. */
  const keptColor = (fraction) => schemes.gnbu(0.35 + 0.65 * fraction);
  const edgeColor = (edge) => (edge.isBridge ? bridgeColor : edge.isKept ? keptColor(edge.keptFraction) : droppedColor);
  const scanColor = (scan) => `rgb(${scan.color.join(",")})`;

  function rampLegend(options) {
    return Plot.legend({ color: options, width: 210, height: 46, marginTop: 17, ticks: 4, style: { background: "none" } });
  }

  const keptLegend = () =>
    rampLegend({ type: "linear", domain: [smallestKeptFraction, 1], interpolate: (t) => keptColor(smallestKeptFraction + (1 - smallestKeptFraction) * t), label: "Fraction of its weight that an edge kept", tickFormat: "%" });

  /** The confidences: most are small, so that their square roots are told apart. */
  const confidenceScale = (report) => ({ type: "sqrt", domain: [0, report.largestConfidence || 1], interpolate: schemes.grays, label: "Confidence" });

  const plotWidth = 560;
  const plotStyle = { className: "plot", width: plotWidth, style: { fontSize: "11.5px", background: "none" } };

  // --------------------------------------------------------------------------------------- selection

  /** What the user has picked: nothing, or some scans, perhaps with an edge: between the two, or their bridge to the rest. */
  class Selection {
    scans = [];
    edge = null;
    #listeners = [];

    onChange(listener) {
      this.#listeners.push(listener);
    }

    /** Selects scans and an edge, or nothing if they are selected already. */
    select(scans, edge = null) {
      const isSame = edge === this.edge && scans.join() === this.scans.join();
      [this.scans, this.edge] = isSame ? [[], null] : [scans, edge];
      for (const listener of this.#listeners) listener(this);
    }

    selectEdge(edge) {
      this.select([edge.i, edge.j], edge);
    }

    clear() {
      this.select([], null);
    }

    /** Whether an edge is the selected one or, where none is, ends at a selected scan. */
    includes(edge) {
      if (this.edge !== null) return edge === this.edge;
      return this.scans.includes(edge.i) || this.scans.includes(edge.j);
    }
  }

  // ------------------------------------------------------------------------------------- the 3-D view

  const pointVertexShader = `
    uniform float pointSize, heightLow, heightSpan, byHeight, dimmed;
    uniform vec3 scanColor;
    uniform sampler2D ramp;
    varying vec3 pointColor;
    void main() {
      float height = clamp((position.z - heightLow) / heightSpan, 0.0, 1.0);
      pointColor = byHeight > 0.5 ? texture2D(ramp, vec2(height, 0.5)).rgb : scanColor;
      pointColor = mix(pointColor, vec3(0.88), dimmed);
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      gl_PointSize = pointSize;
    }`;

  const pointFragmentShader = `
    uniform float pointSize;
    varying vec3 pointColor;
    void main() {
      if (pointSize > 2.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
      gl_FragColor = vec4(pointColor, 1.0);
    }`;

  const screenVertexShader = `
    varying vec2 at;
    void main() {
      at = uv;
      gl_Position = vec4(position.xy, 0.0, 1.0);
    }`;

  // Eye-dome lighting (Boucheny 2009): a pixel darkens by how much its neighbors are nearer to the eye.
  const screenFragmentShader = `
    uniform sampler2D colors, depths;
    uniform vec2 pixel;
    uniform float near, far;
    varying vec2 at;
    float logDepth(vec2 where) {
      return log2(near * far / (far - texture2D(depths, where).r * (far - near)));
    }
    void main() {
      vec4 color = texture2D(colors, at);
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
      gl_FragColor = vec4(color.rgb * shade, 1.0);
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
    #coloring = "scan";
    #explosion = 0;
    #overlayShown = { edges: false, frames: false };
    #radius = 1;
    #isScheduled = false;
    #isFitted = true;
    #message;
    onPick = () => {};
    onFrame = () => {};

    constructor(report, frame) {
      THREE.ColorManagement.enabled = false;
      this.#report = report;
      this.#message = element("p", { className: "message", hidden: true });
      frame.append(this.#message);
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

    /** World heights at the two ends of the color ramp. */
    get heightRange() {
      const origin = this.#component === null ? 0 : this.#report.components[this.#component].origin[2];
      const { heightLow, heightSpan } = this.#shared;
      return [origin + heightLow.value, origin + heightLow.value + heightSpan.value];
    }

    showComponent(component) {
      this.#component = component;
      const scans = this.#scansShown();
      const heights = bulk(samplePoints(scans).map((point) => point.z));
      this.#shared.heightLow.value = heights.low;
      this.#shared.heightSpan.value = Math.max(heights.high - heights.low, 1e-9);
      this.#message.hidden = scans.some((scan) => scan.count > 0);
      this.#message.textContent = `No points to show: ${list(scans.map(({ index }) => this.#report.scans[index].name)) || "there are no scans"}.`;
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

    setColoring(coloring) {
      this.#coloring = coloring;
      this.#refresh();
    }

    setPointSize(pixels) {
      this.#shared.pointSize.value = pixels * this.#renderer.getPixelRatio();
      this.#schedule();
    }

    /** Moves each scan away from the component's centroid by `factor` times its own distance from there. */
    setExplosion(factor) {
      this.#explosion = factor;
      this.#isFitted = false;
      this.#refresh();
    }

    setOverlay(name, shown) {
      this.#overlayShown[name] = shown;
      this.#refresh();
    }

    /** Looks from the front, left and above at the bulk of the points, so that it fills the view. */
    resetCamera() {
      this.#stopDamping();
      this.#isFitted = true;
      const scans = this.#scansShown();
      this.#radius = Math.max(radiusOf(scans), 1e-6);
      const backward = new THREE.Vector3(-0.45, -0.75, 0.62).normalize();
      const right = new THREE.Vector3().crossVectors(this.#camera.up, backward).normalize();
      const axes = [right, new THREE.Vector3().crossVectors(backward, right), backward];
      const points = samplePoints(scans).map((point) => axes.map((axis) => point.dot(axis)));
      const middles = [0, 1, 2].map((k) => bulk(points.map((point) => point[k])).middle);
      const tangent = Math.tan((this.#camera.fov * Math.PI) / 360);
      const distances = points.map((point) => {
        const [across, upwards, nearer] = point.map((value, k) => value - middles[k]);
        return Math.max(Math.abs(upwards), Math.abs(across) / this.#camera.aspect) / tangent + nearer;
      });
      const distance = Math.max(1.04 * bulk(distances).high, 1e-3 * this.#radius);
      this.#controls.target.set(0, 0, 0);
      axes.forEach((axis, k) => this.#controls.target.addScaledVector(axis, middles[k]));
      this.#camera.position.copy(backward).multiplyScalar(distance).add(this.#controls.target);
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

    /** Brings visibility, colors, offsets and overlays in line with the state. */
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
        // Dimmed points leave no depth behind, so that they never hide those that are not.
        points.material.depthWrite = !scan.isDimmed;
        points.renderOrder = scan.isDimmed ? -1 : 0;
        points.position.copy(scan.centroid).sub(centroid).multiplyScalar(this.#explosion);
      }
      this.#shared.byHeight.value = this.#coloring === "height" ? 1 : 0;
      this.#refreshOverlay(shown.filter((scan) => scan.points.visible && !scan.isDimmed));
      this.#schedule();
    }

    #refreshOverlay(scans) {
      for (const child of [...this.#overlay.children]) {
        child.geometry.dispose();
        child.material.dispose();
        this.#overlay.remove(child);
      }
      if (this.#overlayShown.edges) this.#addLines(edgeLines(this.#report.kept, scans), 2.5);
      if (this.#overlayShown.frames) this.#addLines(frameLines(scans, 0.06 * this.#radius), 2);
    }

    #addLines({ positions, colors }, linewidth) {
      if (positions.length === 0) return;
      const geometry = new THREE.LineSegmentsGeometry().setPositions(positions).setColors(colors);
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
      colors: { value: target.texture },
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

  /** The three bytes of a color written as #rrggbb or rgb(r, g, b). */
  function rgb(color) {
    const hex = color.match(/^#(..)(..)(..)$/);
    return hex ? hex.slice(1).map((byte) => parseInt(byte, 16)) : color.match(/\d+/g).map(Number);
  }

  /** A scan as the view keeps it. */
  function createCloud(report, scan, index, shared) {
    const component = report.components[scan.component];
    const positions = decodePositions(scan, component);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    const material = new THREE.ShaderMaterial({
      uniforms: { ...shared, scanColor: { value: new THREE.Vector3(...scan.color.map((byte) => byte / 255)) }, dimmed: { value: 0 } },
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

  /** Half the diagonal of the box around some scans. */
  function radiusOf(scans) {
    const filled = scans.filter((scan) => scan.count > 0);
    if (filled.length === 0) return 1;
    const extents = [0, 1, 2].map((a) => Math.max(...filled.map(({ high }) => high[a])) - Math.min(...filled.map(({ low }) => low[a])));
    return Math.hypot(...extents) / 2;
  }

  function meanOf(vectors) {
    const sum = vectors.reduce((total, vector) => total.add(vector), new THREE.Vector3());
    return sum.divideScalar(Math.max(1, vectors.length));
  }

  /** Up to some thousand points of some scans, where they are drawn. */
  function samplePoints(scans) {
    const total = scans.reduce((sum, scan) => sum + scan.count, 0);
    const stride = 3 * Math.max(1, Math.floor(total / 20000));
    const samples = [];
    for (const { positions, points } of scans) {
      for (let k = 0; k < positions.length; k += stride) samples.push(new THREE.Vector3().fromArray(positions, k).add(points.position));
    }
    return samples;
  }

  /** The range of some values, a hundredth left out at either end. */
  function bulk(values) {
    const sorted = Float32Array.from(values).sort();
    const low = sorted[Math.floor(0.01 * sorted.length)] ?? 0;
    const high = sorted[Math.floor(0.99 * sorted.length)] ?? 1;
    return { low, high, middle: (low + high) / 2 };
  }

  /** Position of a scan and its three axes, relative to the component's origin. */
  function localPose(pose, origin) {
    const column = (c) => new THREE.Vector3(pose[c], pose[4 + c], pose[8 + c]);
    return { axes: [column(0), column(1), column(2)], position: column(3).sub(new THREE.Vector3(...origin)) };
  }

  /** Segments between the centroids of scans that an edge connects. */
  function edgeLines(edges, scans) {
    const centers = new Map(scans.filter((scan) => scan.count > 0).map((scan) => [scan.index, scan.centroid.clone().add(scan.points.position)]));
    const connected = edges.filter(({ i, j }) => centers.has(i) && centers.has(j));
    return {
      positions: connected.flatMap(({ i, j }) => [...centers.get(i), ...centers.get(j)]),
      colors: connected.flatMap((edge) => {
        const color = rgb(edgeColor(edge)).map((byte) => byte / 255);
        return [...color, ...color];
      }),
    };
  }

  /** The sensor frame of every scan: x red, y green, z blue. */
  function frameLines(scans, length) {
    const axisColors = [[0.85, 0.1, 0.1], [0.1, 0.6, 0.1], [0.1, 0.25, 0.9]];
    const positions = scans.flatMap(({ pose, points }) => {
      const start = pose.position.clone().add(points.position);
      return pose.axes.flatMap((axis) => [...start, ...start.clone().addScaledVector(axis, length)]);
    });
    const colors = scans.flatMap(() => axisColors.flatMap((color) => [...color, ...color]));
    return { positions, colors };
  }

  // ------------------------------------------------------------------------ the controls of the view

  function labelled(text, input, before = true) {
    return before ? element("label", {}, text, input) : element("label", {}, input, text);
  }

  const option = ([value, textContent]) => element("option", { value, textContent });

  function choice(options, onChange, data) {
    const select = element("select", { data }, ...options);
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
    const groups = [["Components", several], ["Not registered", alone]].filter(([, options]) => options.length > 0);
    return choice(groups.map(([label, options]) => element("optgroup", { label }, ...options.map(option))),
      (value) => show(Number(value)), { control: "component" });
  }

  /** Fills the toolbar; returns what keeps it in line with the component that is shown. */
  function renderControls(report, view, showComponent) {
    const legend = byId("view-legend");
    let coloring = "scan";
    const showLegend = () => {
      legend.hidden = coloring !== "height";
      legend.replaceChildren(rampLegend({ type: "linear", domain: view.heightRange, interpolate: schemes.viridis, label: "Height (z), unit of the scans" }));
    };
    const color = choice([["scan", "scan"], ["height", "height"]].map(option), (value) => {
      coloring = value;
      view.setColoring(value);
      showLegend();
    }, { control: "coloring" });
    const size = slider({ min: 1, max: 8, step: 0.5, value: 2, data: { control: "size" } }, (value) => view.setPointSize(value));
    const explode = slider({ min: 0, max: 5, step: 0.05, value: 0, data: { control: "explode" } }, (value) => view.setExplosion(value));
    const edges = checkbox((shown) => view.setOverlay("edges", shown), { control: "edges" });
    const frames = checkbox((shown) => view.setOverlay("frames", shown), { control: "frames" });
    const component = componentChoice(report, showComponent);
    const reset = element("button", { type: "button", textContent: "Reset", title: "Look at the whole again", data: { control: "reset" } });
    reset.addEventListener("click", () => view.resetCamera());

    const controls = [
      labelled("Color by", color),
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

  // ------------------------------------------------------------------------------- header, warnings

  function renderHeader(report) {
    document.title = `${report.title} ${dash} registration report`;
    byId("title").textContent = report.title;
    byId("summary").textContent = summary(report);
    const doubts = doubtsOf(report);
    if (doubts !== "") byId("summary").append("; ", element("strong", { textContent: doubts }));
    const voxelSize = `voxel size ${figure(report.voxel_size)} in the unit of the scans (${report.voxel_is_estimated ? "estimated" : "given"})`;
    const total = report.stages.reduce((sum, stage) => sum + stage.seconds, 0);
    const edges = plural(report.edges.length, "edge") + (report.dropped.length > 0 ? ` (${count(report.dropped.length)} dropped)` : "");
    byId("provenance").textContent = [report.version, report.features, voxelSize, edges, seconds(total)].join(", ");
  }

  /** How many scans share a frame, and what became of the others. */
  function summary(report) {
    const n = report.scans.length;
    const sizes = report.registered.map((component) => report.components[component].scans.length);
    if (sizes.length === 0) return `${plural(n, "scan")}, none registered`;
    const inFirst = sizes[0] === n ? `${plural(n, "scan")} in one frame` : `${count(sizes[0])} of ${plural(n, "scan")} in one frame`;
    const inOthers = sizes.slice(1).map((size) => `${count(size)} in another`);
    const alone = report.singles.length > 0 ? [`${count(report.singles.length)} not registered`] : [];
    return list([inFirst, ...inOthers, ...alone]);
  }

  /** What makes the result doubtful, or nothing. */
  function doubtsOf(report) {
    const groups = (kind, ending) => {
      const n = report.warnings.filter((warning) => warning.kind === kind).length;
      return n === 0 ? [] : [`${plural(n, "group")} connected by ${ending}`];
    };
    return list([...groups("loose", "dropped edges only"), ...groups("bridge", "a bridge only")]);
  }

  const entriesShown = 5;

  function renderWarnings(report, selection) {
    const section = byId("warnings");
    if (report.warnings.length === 0) {
      section.append(note("There are none."));
      return;
    }
    section.querySelector("h2").append(` (${report.warnings.length})`);
    const items = report.warnings.map((warning, k) => {
      const edge = warning.edge === null ? null : report.edgeBetween(...warning.edge);
      const button = element("button", { type: "button", textContent: warning.text, ariaPressed: "false", data: { kind: warning.kind } });
      button.addEventListener("click", () => selection.select(warning.scans, edge));
      selection.onChange(() => (button.ariaPressed = String(edge === selection.edge && warning.scans.join() === selection.scans.join())));
      return element("li", { hidden: k >= entriesShown }, button);
    });
    section.append(element("ul", {}, ...items));
    if (items.length > entriesShown) section.append(showAllButton(items));
    const contradictions = report.warnings.filter(({ kind }) => kind === "contradiction").length;
    if (report.dropped.length > contradictions) {
      section.append(note(`The table of edges lists all ${plural(report.dropped.length, "dropped edge")}.`));
    }
  }

  function showAllButton(items) {
    const button = element("button", { type: "button", className: "more", textContent: `Show all ${items.length}` });
    button.addEventListener("click", () => {
      for (const item of items) item.hidden = false;
      button.remove();
    });
    return button;
  }

  // ------------------------------------------------------------------------------------ list of scans

  /** The list of scans with a checkbox each; returns what grays out the scans outside the shown component. */
  function renderScans(report, view, selection) {
    const rows = report.scans.map((scan, index) => scanRow(report, index, view, selection));
    const frame = element("div", { className: "scan-list" });
    for (const component of report.registered) {
      const { scans } = report.components[component];
      const name = report.components.length === 1 ? "One frame" : `Component ${component}`;
      frame.append(element("h3", {}, `${name}: ${plural(scans.length, "scan")}`), ...scans.map((s) => rows[s]));
    }
    if (report.singles.length > 0) {
      const singles = report.singles.map((component) => rows[report.components[component].scans[0]]);
      frame.append(element("h3", {}, `Not registered: ${plural(singles.length, "scan")}`), ...singles);
    }
    byId("scans").append(scanTools(report, rows), frame);
    selection.onChange(() => {
      rows.forEach((row, index) => row.classList.toggle("selected", selection.scans.includes(index)));
      if (selection.scans.length > 0) scrollWithin(frame, rows[selection.scans[0]]);
    });
    return () => {
      rows.forEach((row, index) => {
        const isAway = view !== null && report.scans[index].component !== view.component;
        row.classList.toggle("away", isAway);
        const box = row.querySelector("input");
        box.disabled = isAway || view === null;
        box.title = isAway ? "In another component than the one that is shown" : "";
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
    name.addEventListener("click", () => selection.select([index]));
    const row = element("div", { className: "scan" },
      visible,
      element("span", { className: "index", textContent: index }),
      swatch(scanColor(scan)),
      name,
      ...(scan.has_warning ? [element("span", { className: "warning-mark", textContent: "!", title: "See the warnings" })] : []),
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
      const title = `${textContent} of the scans below that belong to the component shown`;
      const node = element("button", { type: "button", textContent, title, data: { show: textContent.toLowerCase() } });
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
      strip.replaceChildren(selectionTitle(report, selection.scans), clear,
        definitions(selectionRows(report, selection)), ...selectionNotes(report, selection.scans).map(note));
    });
  }

  /** The scans by name; three and more on one line, as far as it goes. */
  function selectionTitle(report, indices) {
    const scans = indices.map((index) => report.scans[index]);
    if (scans.length > 2) {
      const names = list(scans.map((scan) => scan.name));
      return element("h3", { className: "group", textContent: `${plural(scans.length, "scan")}: ${names}`, title: names });
    }
    return element("h3", {}, ...scans.flatMap((scan, k) => [...(k > 0 ? [` ${dash} `] : []), swatch(scanColor(scan)), scan.name]));
  }

  function selectionRows(report, { scans, edge }) {
    const isBetween = edge !== null && scans.length === 2 && scans.includes(edge.i) && scans.includes(edge.j);
    if (isBetween) return [["edge", pairName(edge)], ...edgeFacts(edge)];
    const bridge = edge === null ? [] : [["bridge to the rest", pairName(edge)], ...edgeFacts(edge)];
    if (scans.length === 1) return [...scanFacts(report, scans[0]), ...bridge];
    if (scans.length > 2 || edge !== null) return [...groupFacts(report, scans), ...bridge];
    const [i, j] = scans;
    return [["pair", pairName({ i, j })], ["confidence", confidenceText(report.confidenceBetween(i, j))], ["", "no edge connects them"]];
  }

  /** Why a scan is not registered, or that poses of the scans do not compare. */
  function selectionNotes(report, scans) {
    const reasons = report.warnings.filter((warning) => warning.kind === "unregistered" && scans.join() === warning.scans.join());
    const isSplit = new Set(scans.map((scan) => report.scans[scan].component)).size > 1;
    const split = isSplit ? ["They are in different components, whose poses do not compare: only one is shown."] : [];
    return [...reasons.map(({ text }) => text), ...split];
  }

  function groupFacts(report, scans) {
    const group = new Set(scans);
    const ends = report.kept.map(({ i, j }) => group.has(i) + group.has(j));
    return [
      ["points", count(scans.reduce((sum, index) => sum + report.scans[index].points, 0))],
      ["kept edges among them", count(ends.filter((n) => n === 2).length)],
      ["to the rest", count(ends.filter((n) => n === 1).length)],
    ];
  }

  function scanFacts(report, index) {
    const scan = report.scans[index];
    const isUnregistered = report.components[scan.component].scans.length === 1;
    const ofScan = ({ i, j }) => i === index || j === index;
    const component = report.components.length === 1 ? [] : [["component", isUnregistered ? "none: not registered" : scan.component]];
    return [
      ["scan", index],
      ...component,
      ["points", count(scan.points)],
      ["edges kept", `${count(report.kept.filter(ofScan).length)} of ${count(report.edges.filter(ofScan).length)}`],
    ];
  }

  // -------------------------------------------------------------------------------------- pose graph

  const pairsInGraph = { smallestRatio: 0.02, most: 1500 };

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

  /** One line per pair between its two scans, bent towards the center so that neighbors stay apart. */
  function arcs(places, pairs, style) {
    const bend = 0.78;
    const samples = pairs.flatMap((pair, z) => {
      const [from, to] = [places[pair.i], places[pair.j]];
      const middle = { x: (bend * (from.x + to.x)) / 2, y: (bend * (from.y + to.y)) / 2 };
      return [from, middle, to].map(({ x, y }) => ({ x, y, z, pair }));
    });
    return Plot.line(samples, { x: "x", y: "y", z: "z", curve: "basis", strokeWidth: 1, ...style });
  }

  /** The scored pairs without an edge that get a gray line: confident ones, the most confident if there are too many. */
  function confidentPairs(report) {
    const threshold = pairsInGraph.smallestRatio * report.largestConfidence;
    const pairs = report.scoredPairs.filter(({ i, j, confidence }) => confidence > 0 && confidence >= threshold && report.edgeBetween(i, j) === null);
    return pairs.sort((a, b) => b.confidence - a.confidence).slice(0, pairsInGraph.most).reverse();
  }

  function renderGraph(report, selection) {
    const section = byId("graph");
    if (report.scans.length < 2) return void section.append(note("A pose graph needs two scans."));
    const places = circleLayout(report);
    const pairs = confidentPairs(report);
    const kept = [...report.kept].sort((a, b) => a.isBridge - b.isBridge || a.keptFraction - b.keptFraction);
    const indices = report.scans.map((_, index) => index);
    const numbered = indices.filter((index) => index % Math.ceil(report.scans.length / 90) === 0);
    const hit = { stroke: "transparent", strokeWidth: 7 };
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Scans on a circle, connected by the edges of the pose graph",
      height: 560,
      margin: 4,
      axis: null,
      x: { domain: [-1.1, 1.1] },
      y: { domain: [-1.1, 1.1] },
      marks: [
        arcs(places, pairs, {
          className: "pairs",
          stroke: pairColor,
          strokeOpacity: ({ pair }) => 0.75 * Math.sqrt(pair.confidence / report.largestConfidence),
        }),
        arcs(places, report.unresolved, { className: "unresolved", stroke: pairColor, strokeDasharray: "3,4" }),
        arcs(places, report.dropped, { className: "dropped", stroke: droppedColor }),
        arcs(places, kept, {
          className: "kept",
          stroke: ({ pair }) => edgeColor(pair),
          strokeWidth: ({ pair }) => (pair.isBridge ? 3 : 1.8),
        }),
        arcs(places, pairs, { className: "hit-pairs", ...hit, strokeWidth: 4 }),
        arcs(places, report.dropped, { className: "hit-dropped", ...hit }),
        arcs(places, kept, { className: "hit-kept", ...hit }),
        Plot.dot(indices, {
          className: "nodes",
          x: (index) => places[index].x,
          y: (index) => places[index].y,
          r: Math.max(2, Math.min(5.5, 240 / report.scans.length)),
          fill: (index) => scanColor(report.scans[index]),
          stroke: (index) => (report.scans[index].has_warning ? bridgeColor : "#fff"),
          strokeWidth: (index) => (report.scans[index].has_warning ? 2.4 : 1),
        }),
        Plot.text(numbered, { x: (index) => 1.06 * places[index].x, y: (index) => 1.06 * places[index].y, text: String, fontSize: 10, fill: "#626a73" }),
      ],
    });
    bindPairs(report, drawn(svg, "pairs"), drawn(svg, "hit-pairs"), pairs, selection);
    bindEdges(report, report.dropped, drawn(svg, "dropped"), drawn(svg, "hit-dropped"), selection);
    bindEdges(report, kept, drawn(svg, "kept"), drawn(svg, "hit-kept"), selection);
    bindNodes(report, drawn(svg, "nodes"), selection);
    selection.onChange(() => svg.classList.toggle("selecting", selection.scans.length > 0));
    section.append(graphLegends(report, svg, pairs.length), element("figure", { className: "plot" }, svg), note(graphCaption(report)));
  }

  /** The colors of the graph; those that may hide others come with a box to switch them off. */
  function graphLegends(report, svg, numPairs) {
    const legends = element("div", { className: "legends" });
    if (report.edges.length > 0) legends.append(keptLegend());
    if (report.edges.some((edge) => edge.isBridge)) legends.append(element("span", { className: "key" }, swatch(bridgeColor), "bridge"));
    const switchable = [
      ["dropped", droppedColor, `${count(report.dropped.length)} dropped`, report.dropped.length],
      ["pairs", pairColor, "confidence of other pairs", numPairs],
    ];
    for (const [name, color, text, n] of switchable.filter((entry) => entry[3] > 0)) {
      const box = checkbox((shown) => svg.classList.toggle(`without-${name}`, !shown), { graph: name }, true);
      legends.append(element("label", { className: "key" }, box, swatch(color), text));
    }
    return legends;
  }

  function graphCaption(report) {
    return [
      report.edges.some((edge) => edge.isBridge) ? "A bridge is the only edge between two groups of scans: nothing confirms it." : "",
      report.dropped.length > 0 ? "An edge is dropped if it kept less than a tenth of its weight: the result contradicts it." : "",
      report.unresolved.length > 0 ? `Dashed: ${plural(report.unresolved.length, "selected pair")} without a relative pose.` : "",
      report.scans.some((scan) => scan.has_warning) ? "Ringed: scans with a warning." : "",
      "Hover over a line for its support, click it to see its two scans.",
    ].filter(Boolean).join(" ");
  }

  function bindPairs(report, lines, hits, pairs, selection) {
    pairs.forEach(({ i, j, confidence }, k) => {
      bindPointer(hits[k], lines[k], () => ({ title: edgeTitle(report, { i, j }), rows: [["confidence", confidenceText(confidence)], ["edge", "no"]] }),
        () => selection.select([i, j]));
    });
  }

  /** Makes edges answer to the pointer, by the wider invisible `hits` over the `lines`. */
  function bindEdges(report, edges, lines, hits, selection) {
    edges.forEach((edge, k) => {
      lines[k].classList.add("edge");
      lines[k].dataset.edge = edge.index;
      bindPointer(hits[k], lines[k], () => ({ title: edgeTitle(report, edge), rows: edgeFacts(edge) }), () => selection.selectEdge(edge));
    });
    selection.onChange(() => edges.forEach((edge, k) => lines[k].classList.toggle("selected", selection.includes(edge))));
  }

  const edgeTitle = (report, edge) => `${pairName(edge)}: ${report.scans[edge.i].name} ${dash} ${report.scans[edge.j].name}`;

  /** Tooltip and click on `target`, with `mark` emphasized while the pointer is over it. */
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
        () => selection.select([index]));
    });
    selection.onChange(() => nodes.forEach((node, index) => node.classList.toggle("selected", selection.scans.includes(index))));
  }

  // ------------------------------------------------------------------------------- confidence matrix

  /** Confidences of the scored pairs above the diagonal of an n x n matrix, row by row; the rest is empty. */
  function upperTriangle(report) {
    const n = report.scans.length;
    const values = new Array(n * n).fill(NaN);
    for (const { i, j, confidence } of report.scoredPairs) values[i * n + j] = confidence;
    return values;
  }

  function renderMatrix(report, selection) {
    const section = byId("matrix");
    const n = report.scans.length;
    if (n < 2) return void section.append(note("One scan has no pair."));
    const tickStep = [1, 2, 5, 10, 20, 50, 100, 200].find((step) => n / step <= 16) ?? 500;
    const ticks = Array.from({ length: Math.ceil(n / tickStep) }, (_, k) => k * tickStep);
    const axis = { domain: [0, n], ticks: ticks.map((t) => t + 0.5), tickFormat: (t) => String(Math.floor(t)), tickSize: 3, label: null };
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Confidence of the scored pairs of scans, and the edges",
      height: 542,
      margin: 4,
      marginTop: 20,
      marginLeft: 32,
      marginRight: 10,
      x: { ...axis, axis: "top" },
      y: { ...axis, reverse: true },
      color: { ...confidenceScale(report), unknown: "#fff" },
      marks: [
        Plot.raster(upperTriangle(report), { width: n, height: n, imageRendering: "pixelated" }),
        Plot.rect(report.edges, {
          className: "cells",
          x1: ({ i }) => i,
          x2: ({ i }) => i + 1,
          y1: ({ j }) => j,
          y2: ({ j }) => j + 1,
          fill: report.edges.map(edgeColor),
          pointerEvents: "none",
        }),
        Plot.line([[0, 0], [n, n]], { stroke: "#c8ced4" }),
      ],
    });
    bindMatrix(report, svg, selection);
    const legends = element("div", { className: "legends" }, rampLegend(confidenceScale(report)));
    section.append(legends, element("figure", { className: "plot" }, svg),
      note(matrixCaption(report)));
  }

  function matrixCaption(report) {
    const [n, scored] = [report.scans.length, report.scoredPairs.length];
    const numPairs = (n * (n - 1)) / 2;
    const unscored = scored === numPairs ? [] : [`${count(scored)} of ${plural(numPairs, "pair")} were scored, the others are empty.`];
    return ["Rows and columns are the scans by index. Above the diagonal: confidence.", ...unscored, "Below: the edges, in their colors of the graph."].join(" ");
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

  function bindMatrix(report, svg, selection) {
    const cells = drawn(svg, "cells");
    cells.forEach((cell, k) => {
      cell.classList.add("edge");
      cell.dataset.edge = k;
    });
    svg.addEventListener("mousemove", (event) => {
      const pair = pairAt(report, svg, event);
      if (pair === null) return hideTooltip();
      const edge = report.edgeBetween(pair.i, pair.j);
      const rows = edge === null ? [["confidence", confidenceText(report.confidenceBetween(pair.i, pair.j))], ["edge", "no"]] : edgeFacts(edge);
      showTooltip(event, { title: edgeTitle(report, pair), rows });
    });
    svg.addEventListener("mouseleave", hideTooltip);
    svg.addEventListener("click", (event) => {
      const pair = pairAt(report, svg, event);
      if (pair !== null) selection.select([pair.i, pair.j], report.edgeBetween(pair.i, pair.j));
    });
    selection.onChange(() => cells.forEach((cell, k) => cell.classList.toggle("selected", report.edges[k] === selection.edge)));
  }

  // ------------------------------------------------------------------------------------------ weights

  function renderWeights(report, selection) {
    const section = byId("weights");
    const iterations = largest(report.edges.map((edge) => edge.weights.length)) - 1;
    if (report.edges.length === 0) return void section.append(note("There are no edges."));
    if (iterations < 1) return void section.append(note("No edge was reweighted: every edge keeps its initial weight."));
    const edges = [...report.dropped, ...report.kept];
    const samples = edges.flatMap((edge) => edge.weights.map((weight, iteration) => ({ edge, fraction: fractionOf(weight, edge), iteration })));
    const line = { x: "iteration", y: "fraction", z: (sample) => sample.edge.index };
    const svg = Plot.plot({
      ...plotStyle,
      ariaLabel: "Weight of every edge after each iteration, relative to its initial weight",
      height: 280,
      marginLeft: 46,
      marginRight: 12,
      marginBottom: 36,
      x: { label: "Iteration", ticks: Math.min(iterations, 12), tickFormat: "d", domain: [0, iterations] },
      y: { label: "Fraction of its initial weight", grid: true, domain: [0, 1], ticks: 5, tickFormat: "%" },
      marks: [
        Plot.ruleY([0], { stroke: "#c8ced4" }),
        Plot.ruleY([smallestKeptFraction], { stroke: bridgeColor, strokeDasharray: "4,4" }),
        Plot.line(samples, {
          ...line,
          className: "edges",
          stroke: (sample) => edgeColor(sample.edge),
          strokeWidth: (sample) => (sample.edge.isKept ? 1.5 : 1),
        }),
        Plot.line(samples, { ...line, className: "hit", stroke: "transparent", strokeWidth: 8 }),
      ],
    });
    bindEdges(report, edges, drawn(svg, "edges"), drawn(svg, "hit"), selection);
    selection.onChange(() => svg.classList.toggle("selecting", selection.scans.length > 0));
    section.append(element("figure", { className: "plot" }, svg),
      note(`${count(report.dropped.length)} of ${plural(report.edges.length, "edge")} fell below the dashed line and ${report.dropped.length === 1 ? "is" : "are"} dropped.`));
  }

  // ------------------------------------------------------------------------------------ table of edges

  const edgeColumns = [
    { title: "Edge", meaning: "Indices of the two scans", value: (edge) => edge.i * 1e6 + edge.j, cell: pairName },
    { title: "Confi\u00addence", meaning: "How alike the two scans are, from their features alone: 0 to 1", value: (edge) => edge.confidence, cell: (edge) => confidenceText(edge.confidence) },
    { title: "Corr.", meaning: "Correspondences: points of the two scans whose descriptors match", value: (edge) => edge.correspondences, cell: (edge) => count(edge.correspondences) },
    { title: "Inliers", meaning: "Inlier ratio: the fraction of the retained correspondences that the relative pose of the edge explains", value: (edge) => edge.inlier_ratio, cell: (edge) => percent(edge.inlier_ratio) },
    { title: "Weight", meaning: "Final weight of the edge", value: (edge) => edge.final_weight, cell: (edge) => weightText(edge.final_weight) },
    { title: "Kept", meaning: "Final weight, relative to the initial weight", value: (edge) => edge.keptFraction, cell: (edge) => percent(edge.keptFraction) },
    { title: "Rot. °", meaning: "Rotation residual: the angle between the relative pose of the edge and that of the result", value: (edge) => edge.rotation_residual, cell: (edge) => tableResidual(edge, edge.rotation_residual, 2) },
    { title: "Transl.", meaning: "Translation residual: the distance between the relative pose of the edge and that of the result, in the unit of the scans", value: (edge) => edge.translation_residual, cell: (edge, digits) => tableResidual(edge, edge.translation_residual, digits) },
  ];

  const tableResidual = (edge, value, digits) => (value === null || edge.isBridge ? dash : decimals(value, digits));

  /** Decimals that give a typical translation residual two digits. */
  function translationDigits(report) {
    const residuals = report.kept.map((edge) => edge.translation_residual).filter((value) => value > 0).sort((a, b) => a - b);
    const typical = residuals[residuals.length >> 1] ?? 0.1;
    return Math.max(0, Math.min(9, 1 - Math.floor(Math.log10(typical))));
  }

  /** The edges on which most depends first: bridges, kept edges from the weakest on, dropped edges. */
  function byImportance(a, b) {
    return b.isBridge - a.isBridge || b.isKept - a.isKept || a.final_weight - b.final_weight;
  }

  function renderEdges(report, selection) {
    const section = byId("edges");
    if (report.edges.length === 0) return void section.append(note("No pair of scans became an edge."));
    const digits = translationDigits(report);
    const rows = report.edges.map((edge) => edgeRow(report, edge, digits, selection));
    const body = element("tbody", {}, ...[...report.edges].sort(byImportance).map((edge) => rows[edge.index]));
    const headings = edgeColumns.map((column) => sortableHeading(column, report, rows, body));
    const table = element("table", {}, element("thead", {}, element("tr", {}, ...headings)), body);
    const frame = element("div", { className: "table-frame", tabIndex: 0 }, table);
    selection.onChange(() => {
      rows.forEach((row, index) => row.classList.toggle("selected", report.edges[index] === selection.edge));
      if (selection.edge !== null) scrollWithin(frame, rows[selection.edge.index]);
    });
    section.append(frame, note("First the bridges, which nothing can contradict. Then the kept edges, the weakest first. Then the dropped edges. A heading explains itself when hovered over, and sorts when pressed."));
  }

  function edgeRow(report, edge, digits, selection) {
    const [first, ...others] = edgeColumns.map(({ cell }) => element("td", { textContent: cell(edge, digits) }));
    const button = element("button", { type: "button", textContent: pairName(edge), title: edgeTitle(report, edge) });
    first.replaceChildren(swatch(edgeColor(edge)), button);
    const row = element("tr", { data: { edge: edge.index } }, first, ...others);
    row.classList.toggle("dropped", !edge.isKept);
    row.addEventListener("click", () => selection.selectEdge(edge));
    return row;
  }

  /** A column heading that sorts by its column, the other way round when pressed again. */
  function sortableHeading({ title, meaning, value }, report, rows, body) {
    const button = element("button", { type: "button", textContent: title, title: meaning });
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
      const components = selection.scans.filter((index) => report.scans[index].count > 0).map((index) => report.scans[index].component);
      if (components.length > 0 && !components.includes(view.component)) show(components[0]);
      view.highlight(selection.scans);
    });
    view.onPick = (scan) => (scan === null ? selection.clear() : selection.select([scan]));
    view.onFrame = markReady;
  }

  const markReady = () => (document.body.dataset.ready = "true");

  function main() {
    const report = readReport();
    const selection = new Selection();
    renderHeader(report);
    renderWarnings(report, selection);
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
