// Makes a sample of report.html from synthetic scans: `node sample.mjs OUT.html [scans] [points]`.
//
// The scans are pieces of two furnished rooms, each room one component, and one scan that fits nowhere. Nothing
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
function quantise(clouds) {
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

function colourOf(index) {
  const hue = (index * 0.618034) % 1;
  return [0, 1 / 3, 2 / 3].map((shift) => {
    const t = Math.abs((((hue + shift) % 1) * 6) - 3) - 1;
    return Math.round(60 + 165 * Math.min(1, Math.max(0, t)));
  });
}

/** Confidence of a pair: high where two sensors of one room look the same way, noise elsewhere. */
function confidenceOf(a, b, random) {
  if (a.room !== b.room) return 0.04 * random();
  const turn = Math.cos(a.heading - b.heading);
  return 0.05 * random() + 0.95 * Math.max(0, (turn + 0.2) / 1.2) ** 2 * (0.75 + 0.25 * random());
}

function edgeOf(i, j, confidence, joinsRooms, iterations, random) {
  const isWrong = joinsRooms || random() < 0.05;
  const initial = confidence * (0.5 + 0.4 * random());
  const weights = [initial];
  for (let k = 0; k < iterations; k++) weights.push(weights[k] * (isWrong ? 0.55 : 0.985 + 0.01 * random()));
  return {
    i,
    j,
    confidence,
    inlier_ratio: isWrong ? 0.1 : 0.4 + 0.5 * random(),
    correspondences: Math.round(20 + 200 * confidence),
    clique_size: Math.round(4 + 12 * confidence),
    cliques_seen: Math.round(1000 * random()),
    budget_exhausted: random() < 0.05,
    initial_weight: initial,
    final_weight: joinsRooms ? 0 : weights.at(-1),
    rotation_residual: joinsRooms ? null : (isWrong ? 25 : 1.5) * random(),
    translation_residual: joinsRooms ? null : (isWrong ? 0.8 : 0.04) * random(),
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

/** Data of a report. Without edges every scan is a component of its own. */
export function sampleData({ scans: n = 24, points = 3000, hasEdges = true, iterations = 10 } = {}) {
  const random = randomNumbers(7);
  const isConnected = hasEdges && n > 1;
  const lone = isConnected && n > 4 ? 1 : 0;
  const inFirst = n > 6 ? Math.ceil(0.7 * (n - lone)) : n - lone;
  const roomOf = (index) => (index >= n - lone ? 2 : index < inFirst ? 0 : 1);
  const sensors = [0, 1, 2].flatMap((room) => {
    const size = Array.from({ length: n }, (_, k) => k).filter((k) => roomOf(k) === room).length;
    return sensorsOfRoom(size).map((sensor) => ({ ...sensor, room }));
  });
  // One scan without a point, where there are enough of them.
  const clouds = sensors.map((sensor, k) => (n > 6 && k === 4 ? [] : scanOfRoom(sensor, points, random)));

  const confidences = [];
  const table = sensors.map(() => []);
  for (let i = 0; i < n; i++) {
    for (let j = i + 1; j < n; j++) {
      table[i][j] = table[j][i] = isConnected ? confidenceOf(sensors[i], sensors[j], random) : 0.02 * random();
      confidences.push(table[i][j]);
    }
  }
  const members = isConnected
    ? [0, 1, 2].map((room) => sensors.flatMap((sensor, k) => (sensor.room === room ? [k] : []))).filter((m) => m.length > 0)
    : sensors.map((_, k) => [k]);
  const pairs = isConnected ? confidentPairs(n, (i, j) => table[i][j], 4).filter(([i, j]) => roomOf(i) === roomOf(j)) : [];
  if (inFirst < n - lone) pairs.push([2, inFirst + 1]);
  const edges = pairs.map(([i, j]) => edgeOf(i, j, table[i][j], roomOf(i) !== roomOf(j), iterations, random));

  const components = members.map((scans) => ({ scans, ...quantise(scans.map((k) => clouds[k])) }));
  const scans = sensors.map((_, index) => {
    const component = components.findIndex((c) => c.scans.includes(index));
    const { scans: all, encoded } = components[component];
    return {
      name: index === 1 ? hostileName : `cloud_bin_${index}.ply`,
      component,
      color: colourOf(index),
      points: clouds[index].length * 4,
      count: clouds[index].length,
      positions: encoded[all.indexOf(index)],
      attention: all.length === 1,
    };
  });
  return {
    title: "synthetic rooms",
    version: "gmpcr 0.1.0",
    features: "FPFH",
    voxel: 0.05,
    scans,
    components: components.map(({ scans, origin, step }) => ({ scans, origin, step })),
    poses: sensors.map(poseOf),
    edges,
    unresolved: isConnected && n > 6 ? [{ i: 0, j: 5, confidence: table[0][5] }] : [],
    confidences,
    stages: [
      { name: "reading", seconds: 0.112 },
      { name: "features", seconds: 0.981 },
      { name: "keypoints", seconds: 0.043 },
      { name: "confidences", seconds: 0.31 },
      { name: "edge motions", seconds: 0.087 },
      { name: "synchronisation", seconds: 0.0041 },
      { name: "writing", seconds: 0.22 },
    ],
    attention: attentionOf(scans, edges),
    frames: null,
  };
}

function attentionOf(scans, edges) {
  const alone = scans.flatMap((scan, k) =>
    scan.attention ? [{ scans: [k], text: `${scan.name} is not registered: no edge of positive weight joins it to another scan.` }] : []);
  const fallen = edges.filter((edge) => edge.final_weight < edge.initial_weight / 2).map(({ i, j }) => ({
    scans: [i, j],
    text: `The edge between ${scans[i].name} and ${scans[j].name} lost more than half of its weight: it contradicts the others.`,
  }));
  return [...alone, ...fallen];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [output, scans = "24", points = "3000"] = process.argv.slice(2);
  if (!output) throw new Error("usage: node sample.mjs OUT.html [scans] [points]");
  writeFileSync(output, fillTemplate(sampleData({ scans: Number(scans), points: Number(points) })));
}
