// Makes a sample of report.html from synthetic scans: `node sample.mjs OUT.html [scans] [points]`.
//
// The scans are pieces of two furnished rooms, each room one component, and two scans that fit nowhere, one of
// them without a point. In the larger room a bridge connects some scans, and dropped edges connect one scan. Nothing
// is registered here: the numbers of the edges only look like those of a registration.

import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const report = join(dirname(fileURLToPath(import.meta.url)), "../src/report");

/** A name that must show as it is written, and never become markup. */
export const hostileName = "<img src=x onerror=alert(1)>.ply";

/** The page with `data`, as the program writes it. */
export function fillTemplate(data) {
  const read = (name) => readFileSync(join(report, name), "utf8");
  const parts = {
    "/*{{style}}*/": read("report.css"),
    "/*{{libraries}}*/": read("libraries.min.js"),
    "{{data}}": JSON.stringify(data).replaceAll("<", "\\u003c"),
    "/*{{program}}*/": read("report.js"),
  };
  const places = /\/\*\{\{(?:style|libraries|program)\}\}\*\/|\{\{data\}\}/g;
  return read("report.html").replace(places, (place) => parts[place]);
}

/** Numbers in [0, 1) that are the same on every run (mulberry32). */
function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const [roomLength, roomWidth, roomHeight] = [8, 6, 2.6];

/** Boxes of a room: lowest corner and size of each. */
const furniture = [
  [1.0, 1.0, 0, 1.8, 0.9, 0.75],
  [3.4, 4.6, 0, 2.2, 1.0, 0.45],
  [6.6, 0.6, 0, 0.7, 2.4, 1.9],
  [4.2, 2.2, 0, 1.2, 1.2, 0.5],
  [0.3, 4.4, 0, 0.6, 1.2, 1.6],
];

/** A random point on the floor, a wall or a piece of furniture. */
function pointOfRoom(random) {
  const kind = random();
  if (kind < 0.3) return [random() * roomLength, random() * roomWidth, 0];
  if (kind < 0.6) {
    const along = random() * 2 * (roomLength + roomWidth);
    const height = random() * roomHeight;
    if (along < roomLength) return [along, 0, height];
    if (along < roomLength + roomWidth) return [roomLength, along - roomLength, height];
    if (along < 2 * roomLength + roomWidth) return [along - roomLength - roomWidth, roomWidth, height];
    return [0, along - 2 * roomLength - roomWidth, height];
  }
  const [x, y, z, dx, dy, dz] = furniture[Math.floor(random() * furniture.length)];
  const at = [x + random() * dx, y + random() * dy, z + random() * dz];
  const face = Math.floor(random() * 5);
  if (face === 4) at[2] = z + dz;
  else at[face >> 1] = face % 2 === 0 ? [x, y][face >> 1] : [x + dx, y + dy][face >> 1];
  return at;
}

/** Points of a room that a sensor sees within its range and opening angle. */
function scanOfRoom(sensor, points, random) {
  const seen = [];
  for (let attempt = 0; seen.length < points && attempt < 60 * points; attempt++) {
    const [x, y, z] = pointOfRoom(random);
    const [dx, dy] = [x - sensor.x, y - sensor.y];
    const range = Math.hypot(dx, dy);
    const cosine = (dx * Math.cos(sensor.heading) + dy * Math.sin(sensor.heading)) / (range || 1);
    if (range < 5.5 && cosine > 0.8) seen.push([x, y, z].map((value) => value + 0.006 * (random() - 0.5)));
  }
  return seen;
}

/** Sensors along a loop through a room, looking outwards. */
function sensorsOfRoom(n) {
  return Array.from({ length: n }, (_, k) => {
    const angle = (2 * Math.PI * k) / n;
    return {
      x: roomLength / 2 + 1.6 * Math.cos(angle),
      y: roomWidth / 2 + 1.0 * Math.sin(angle),
      heading: angle + 0.5 * Math.sin(3 * angle),
    };
  });
}

/** Row-major 3 x 4 pose of a level sensor: z forward, y down. */
function poseOf({ x, y, heading }) {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return [s, 0, c, x, -c, 0, s, y, 0, -1, 0, 1.4];
}

/** Points as u16 steps from the lowest corner of their component. */
function quantize(clouds) {
  const all = clouds.flat();
  if (all.length === 0) return { origin: [0, 0, 0], step: 0, encoded: clouds.map(() => "") };
  const origin = [0, 1, 2].map((axis) => all.reduce((low, p) => Math.min(low, p[axis]), Infinity));
  const reach = all.reduce((most, p) => Math.max(most, ...p.map((value, axis) => value - origin[axis])), 0);
  const step = reach / 65535;
  const encode = (cloud) => {
    const steps = Uint16Array.from(cloud.flatMap((p) => p.map((value, axis) => Math.round((value - origin[axis]) / step))));
    return Buffer.from(steps.buffer).toString("base64");
  };
  return { origin, step, encoded: clouds.map(encode) };
}

function colorOf(index) {
  const hue = (index * 0.618034) % 1;
  return [0, 1 / 3, 2 / 3].map((shift) => {
    const t = Math.abs((((hue + shift) % 1) * 6) - 3) - 1;
    return Math.round(60 + 165 * Math.min(1, Math.max(0, t)));
  });
}

/** Confidence of a pair: high where two sensors of one room look the same way, noise elsewhere. */
function confidenceOf(a, b, random) {
  if (a.room !== b.room) return 0.04 * random();
  const alignment = Math.cos(a.heading - b.heading);
  return 0.05 * random() + 0.95 * Math.max(0, (alignment + 0.2) / 1.2) ** 2 * (0.75 + 0.25 * random());
}

/** Fractions of its weight that an edge has after each iteration; that of an outlier falls by orders of magnitude. */
function fractionsOf(isOutlier, iterations, random) {
  const last = isOutlier ? 10 ** (-2 - 10 * random()) : 0.15 + 0.83 * random();
  return Array.from({ length: iterations }, (_, k) => (isOutlier ? last ** ((k + 1) / iterations) : last * (k === 0 ? 0.6 : 1)));
}

function edgeOf(i, j, confidence, { isOutlier, connectsRooms }, iterations, random) {
  const initial = confidence * (0.1 + 0.5 * random());
  const weights = [initial, ...fractionsOf(isOutlier, iterations, random).map((fraction) => fraction * initial)];
  return {
    i,
    j,
    confidence,
    inlier_ratio: isOutlier ? 0.1 : 0.4 + 0.5 * random(),
    correspondences: Math.round(20 + 200 * confidence),
    clique_size: Math.round(4 + 12 * confidence),
    cliques_seen: Math.round(1000 * random()),
    budget_exhausted: random() < 0.05,
    initial_weight: initial,
    final_weight: connectsRooms ? 0 : weights.at(-1),
    rotation_residual: connectsRooms ? null : isOutlier ? 25 + 150 * random() : 1.5 * random(),
    translation_residual: connectsRooms ? null : isOutlier ? 0.8 + 3 * random() : 0.04 * random(),
    weights,
  };
}

/** Indices of the pairs among the `k` most confident of either scan. */
function confidentPairs(n, confidence, k) {
  const chosen = new Set();
  for (let i = 0; i < n; i++) {
    const others = Array.from({ length: n }, (_, j) => j).filter((j) => j !== i);
    others.sort((a, b) => confidence(i, b) - confidence(i, a));
    for (const j of others.slice(0, k)) chosen.add(`${Math.min(i, j)},${Math.max(i, j)}`);
  }
  return [...chosen].map((key) => key.split(",").map(Number)).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
}

/**
 * Data of a report. Without edges every scan is a component of its own. With retrieval only the pairs of one room
 * are scored, and the edges.
 */
export function sampleData({ scans: n = 24, points = 3000, hasEdges = true, iterations = 10, hasRetrieval = false } = {}) {
  const random = randomNumbers(7);
  const isConnected = hasEdges && n > 1;
  const lone = !isConnected || n < 5 ? 0 : n < 12 ? 1 : 2;
  const inFirst = n > 6 ? Math.ceil(0.7 * (n - lone)) : n - lone;
  const roomOf = (index) => (index >= n - lone ? 2 : index < inFirst ? 0 : 1);
  const sensors = [0, 1, 2].flatMap((room) => {
    const size = Array.from({ length: n }, (_, k) => k).filter((k) => roomOf(k) === room).length;
    return sensorsOfRoom(size).map((sensor) => ({ ...sensor, room }));
  });
  const isEmpty = (index) => lone === 2 && index === n - 1;
  const clouds = sensors.map((sensor, k) => (isEmpty(k) ? [] : scanOfRoom(sensor, points, random)));

  const table = sensors.map(() => []);
  for (let i = 0; i < n; i++) {
    for (let j = i + 1; j < n; j++) {
      table[i][j] = table[j][i] = isConnected ? confidenceOf(sensors[i], sensors[j], random) : 0.02 * random();
    }
  }
  const rooms = [0, 1].map((room) => sensors.flatMap((sensor, k) => (sensor.room === room ? [k] : []))).filter((room) => room.length > 0);
  const single = (k) => [k];
  const members = isConnected ? [...rooms, ...sensors.map((_, k) => k).slice(n - lone).map(single)] : sensors.map((_, k) => [k]);
  const pairs = isConnected ? confidentPairs(n, (i, j) => table[i][j], 5).filter(([i, j]) => roomOf(i) === roomOf(j) && j < n - lone) : [];
  const loose = n < 12 ? -1 : inFirst - 1;
  const kept = n < 12 ? pairs : withOneEdgeTo(new Set([loose - 3, loose - 2, loose - 1]), pairs, loose);
  if (inFirst < n - lone) kept.push([2, inFirst + 1]);
  const edges = kept.map(([i, j]) => {
    const connectsRooms = roomOf(i) !== roomOf(j);
    const isOutlier = connectsRooms || i === loose || j === loose || (n > 6 && j > i + 4 && random() < 0.15);
    return edgeOf(i, j, table[i][j], { isOutlier, connectsRooms }, iterations, random);
  });

  const components = members.map((scans) => ({ scans, ...quantize(scans.map((k) => clouds[k])) }));
  const scans = sensors.map((_, index) => {
    const component = components.findIndex((c) => c.scans.includes(index));
    const { scans: all, encoded } = components[component];
    return {
      name: index === 1 ? hostileName : `cloud_bin_${index}.ply`,
      component,
      color: colorOf(index),
      points: clouds[index].length * 4,
      count: clouds[index].length,
      positions: encoded[all.indexOf(index)],
    };
  });
  const scored = scoredPairs(n, edges, (i, j) => !hasRetrieval || roomOf(i) === roomOf(j));
  const warnings = warningsOf(scans, members, edges);
  const withWarning = new Set(warnings.flatMap(({ kind, scans: all }) => (kind === "contradiction" ? [] : all)));
  return {
    title: "synthetic rooms",
    version: "gmpcr 0.1.0",
    features: "FPFH",
    voxel_size: 0.05,
    voxel_is_estimated: true,
    scans: scans.map((scan, k) => ({ ...scan, has_warning: withWarning.has(k) })),
    components: components.map(({ scans, origin, step }) => ({ scans, origin, step })),
    poses: sensors.map(poseOf),
    edges,
    unresolved: isConnected && n > 6 ? [{ i: 0, j: 5, confidence: table[0][5], cliques_seen: 3, budget_exhausted: false }] : [],
    scored_pairs: scored.map(([i, j]) => [i, j, table[i][j]]),
    stages: [
      { name: "reading", seconds: 0.112 },
      { name: "features", seconds: 0.981 },
      { name: "sampling", seconds: 0.043 },
      { name: "pair scoring", seconds: 0.31 },
      { name: "pose estimation", seconds: 0.087 },
      { name: "synchronization", seconds: 0.0041 },
      { name: "writing", seconds: 0.22 },
    ],
    warnings,
  };
}

/** The pairs that are retrieved, and those of the edges. */
function scoredPairs(n, edges, isRetrieved) {
  const isEdge = new Set(edges.map(({ i, j }) => `${i},${j}`));
  const pairs = Array.from({ length: n }, (_, i) => Array.from({ length: n - i - 1 }, (_, k) => [i, i + 1 + k])).flat();
  return pairs.filter((pair) => isRetrieved(...pair) || isEdge.has(pair.join()));
}

/** The pairs without those between `part` and the others but for the first; `loose` is no other. */
function withOneEdgeTo(part, pairs, loose) {
  const leaves = ([i, j]) => part.has(i) !== part.has(j) && i !== loose && j !== loose;
  const first = pairs.find(leaves);
  return pairs.filter((pair) => pair === first || !leaves(pair));
}

/** The parts of `n` scans that edges connect. */
function partsOf(n, edges) {
  const labels = Array.from({ length: n }, (_, k) => k);
  for (const { i, j } of edges) {
    const [a, b] = [labels[i], labels[j]];
    if (a !== b) labels.forEach((label, k) => label === b && (labels[k] = a));
  }
  return [...new Set(labels)].map((label) => labels.flatMap((other, k) => (other === label ? [k] : [])));
}

function warningsOf(scans, members, edges) {
  const n = scans.length;
  const name = (k) => scans[k].name;
  const kept = edges.filter((edge) => edge.final_weight > 0 && edge.final_weight >= 0.1 * edge.initial_weight);
  const unregistered = members.length < 2 ? [] : members.filter(({ length }) => length === 1).map(([k]) => ({
    kind: "unregistered", scans: [k], edge: null, text: `${name(k)} is not registered: ${scans[k].count === 0 ? "it holds no points" : "no other scan has correspondences with it that agree"}`,
  }));
  const frames = members.slice(1).filter(({ length }) => length > 1).map((all) => ({
    kind: "separate_frame", scans: all, edge: null, text: `${all.length} scans share a frame of their own`,
  }));
  const parts = partsOf(n, kept).filter((part) => members.some((all) => all.includes(part[0]) && part.length < all.length / 2));
  const loose = parts.map((part) => ({
    kind: "loose", scans: part, edge: null, text: `${part.map(name).join(", ")} may be misplaced: only dropped edges connect it to the rest`,
  }));
  const bridges = kept.flatMap((edge) => {
    const halves = partsOf(n, kept.filter((other) => other !== edge)).filter((part) => part.includes(edge.i) !== part.includes(edge.j));
    if (halves.length < 2) return [];
    const [part] = halves.sort((a, b) => a.length - b.length);
    return [{ kind: "bridge", scans: part, edge: [edge.i, edge.j], text: `${part.map(name).join(", ")} are connected by the edge ${name(edge.i)} – ${name(edge.j)} only: nothing confirms it` }];
  });
  const contradictions = edges.filter((edge) => !kept.includes(edge) && edge.final_weight > 0).slice(0, 10).map(({ i, j }) => ({
    kind: "contradiction", scans: [i, j], edge: [i, j], text: `the relative pose of ${name(i)} and ${name(j)} contradicts the result`,
  }));
  return [...unregistered, ...frames, ...loose, ...bridges, ...contradictions];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [output, scans = "24", points = "3000"] = process.argv.slice(2);
  if (!output) throw new Error("usage: node sample.mjs OUT.html [scans] [points]");
  writeFileSync(output, fillTemplate(sampleData({ scans: Number(scans), points: Number(points) })));
}
