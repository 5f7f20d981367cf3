// Opens reports in a headless browser and asserts what the page promises:
//
//     node check.mjs REPORT.html...    checks these files
//     node check.mjs                   checks samples made by sample.mjs, degenerate ones among them
//
// GMPCR_BROWSER names the Chromium to use, default /usr/bin/chromium. Prints one line per check; the first
// that fails ends the run with exit code 1. Screenshots of the pages go to the folder in GMPCR_SCREENSHOTS.

import { chromium } from "playwright-core";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { fillTemplate, sampleData } from "./sample.mjs";

const executablePath = process.env.GMPCR_BROWSER ?? "/usr/bin/chromium";
const quiet = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
const softwareGl = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const viewport = { width: 1280, height: 800 };

class CheckFailed extends Error {}

function check(what, holds, reason = "") {
  if (!holds) throw new CheckFailed(`${what}${reason === "" ? "" : `: ${reason}`}`);
  console.log(`  ok  ${what}`);
}

function checkEqual(what, actual, expected) {
  check(`${what}: ${expected}`, actual === expected, `found ${actual}`);
}

// ------------------------------------------------------------------------------------------- the page

/** An opened report with its data and all that went wrong while it was open. */
async function openReport(browser, file) {
  const page = await browser.newPage({ viewport });
  const troubles = [];
  const url = pathToFileURL(file).href;
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !isHarmless(message.text())) troubles.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => troubles.push(`page error: ${error.message}`));
  page.on("dialog", (dialog) => {
    troubles.push(`dialog: ${dialog.message()}`);
    dialog.dismiss();
  });
  page.on("request", (request) => {
    if (request.url() !== url && !request.url().startsWith("data:")) troubles.push(`request: ${request.url()}`);
  });
  await page.addInitScript(recordFrames);
  await page.addInitScript(`window.decodePicture = ${decodePicture}`);
  const start = performance.now();
  await page.goto(url);
  await page.waitForSelector('body[data-ready="true"]', { timeout: 2 * mostLoadTime });
  const loadTime = performance.now() - start;
  const data = await page.evaluate(() => JSON.parse(document.getElementById("report-data").textContent));
  return { page, data, troubles, loadTime };
}

/** The browser's own remark that the software renderer is slow at reading pixels back. */
const isHarmless = (text) => text.includes("GPU stall due to ReadPixels");

/** Runs in the page: keeps the times at which the page's own frames were drawn. */
function recordFrames() {
  const request = window.requestAnimationFrame.bind(window);
  window.frameTimes = [];
  window.nextFrame = request;
  window.requestAnimationFrame = (callback) =>
    request((time) => {
      window.frameTimes.push(performance.now());
      callback(time);
    });
}

const frameCount = (page) => page.evaluate(() => window.frameTimes.length);

/** Waits until the page lets four frames pass without drawing. */
const settle = (page) =>
  page.evaluate(async () => {
    for (let before = -1; before !== window.frameTimes.length; ) {
      before = window.frameTimes.length;
      for (let k = 0; k < 4; k++) await new Promise(window.nextFrame);
    }
  });

const parkPointer = (page) => page.mouse.move(viewport.width - 2, 2);

/** Milliseconds in which any report opens, even with a software renderer on a busy machine. */
const mostLoadTime = 30_000;

const margin = 8;

/** Base64 PNG of the canvas without its rim: the part that no legend and no strip of the selection covers, or all. */
async function picture(page, isWhole = false) {
  await parkPointer(page);
  await settle(page);
  const box = await page.locator("#canvas-frame").boundingBox();
  const [right, below] = isWhole ? [margin, margin] : [260 - margin, 150 - margin];
  const clip = { x: box.x + margin, y: box.y + margin, width: box.width - margin - right, height: box.height - margin - below };
  return (await page.screenshot({ clip })).toString("base64");
}

/** Runs in the page: the pixels of a picture. */
async function decodePicture(encoded) {
  const bytes = Uint8Array.from(atob(encoded), (c) => c.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes]));
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  return context.getImageData(0, 0, bitmap.width, bitmap.height);
}

/** Pixels of a picture that differ from the one in its corner, where one is, and how far the bulk of them spans. */
function inkOf(page, png) {
  return page.evaluate(async (encoded) => {
    const { width, height, data } = await window.decodePicture(encoded);
    const pixels = new Uint32Array(data.buffer);
    const inked = [];
    for (let k = 0; k < pixels.length; k++) if (pixels[k] !== pixels[0]) inked.push(k);
    const middle = inked[inked.length >> 1] ?? 0;
    const span = (values) => {
      const sorted = Float64Array.from(values).sort();
      return (sorted[Math.floor(0.98 * sorted.length)] ?? 0) - (sorted[Math.floor(0.02 * sorted.length)] ?? 0);
    };
    return {
      count: inked.length,
      x: middle % width,
      y: Math.floor(middle / width),
      span: Math.max(span(inked.map((k) => k % width)) / width, span(inked.map((k) => Math.floor(k / width))) / height),
    };
  }, png);
}

// ------------------------------------------------------------------------------------------ the checks

const edgeKeys = "i j confidence inlier_ratio correspondences clique_size cliques_seen budget_exhausted initial_weight final_weight rotation_residual translation_residual weights";

/** The keys of every object in the data, alike for the program and for sample.mjs. */
const contract = {
  report: "title version features voxel_size voxel_is_estimated scans components poses edges unresolved scored_pairs stages warnings",
  scans: "name component color points count positions has_warning",
  components: "scans origin step",
  edges: edgeKeys,
  unresolved: "i j confidence cliques_seen budget_exhausted",
  stages: "name seconds",
  warnings: "kind scans edge text",
};

function checkContract({ data }) {
  const keys = (object) => Object.keys(object).sort().join(" ");
  for (const [name, expected] of Object.entries(contract)) {
    const objects = name === "report" ? [data] : data[name];
    const other = objects.map(keys).find((found) => found !== expected.split(" ").sort().join(" "));
    check(`the data keep the contract: ${name}`, other === undefined, other);
  }
  const n = data.scans.length;
  const keysOfPairs = new Set(data.scored_pairs.map(([i, j]) => `${i},${j}`));
  check("scored pairs are pairs, each once", keysOfPairs.size === data.scored_pairs.length && data.scored_pairs.every(([i, j]) => 0 <= i && i < j && j < n));
  check("edges are scored pairs", data.edges.every(({ i, j }) => keysOfPairs.has(`${i},${j}`)));
  const kinds = ["unregistered", "separate_frame", "loose", "bridge", "contradiction"];
  const names = (kind, edge) => (edge !== null) === ["bridge", "contradiction"].includes(kind);
  check("warnings are of known kinds, and name an edge where they should", data.warnings.every(({ kind, edge }) => kinds.includes(kind) && names(kind, edge)));
  const withWarning = new Set(data.warnings.flatMap(({ kind, scans }) => (kind === "contradiction" ? [] : scans)));
  check("the scans of grave warnings are marked", data.scans.every((scan, k) => scan.has_warning === withWarning.has(k)));
}

const keptFraction = (edge) => (edge.initial_weight > 0 ? edge.final_weight / edge.initial_weight : 0);
const isBridge = (data, { i, j }) => data.warnings.some(({ kind, edge }) => kind === "bridge" && edge[0] === i && edge[1] === j);
const plain = (text) => text.replaceAll("\u202f", " ").replaceAll("\u2212", "-").replaceAll("\u2013", "-");

async function checkText({ page, data }) {
  const title = await page.title();
  check("the title names the folder", title.startsWith(data.title), title);
  const summary = plain(await page.textContent("#summary"));
  const n = data.scans.length;
  const largest = data.components.reduce((most, { scans }) => Math.max(most, scans.length), 0);
  const verdict = largest < 2 ? `${n} scan` : largest === n ? `${n} scans in one frame` : `${largest} of ${n} scans in one frame`;
  check("the summary says how many scans share a frame", summary.startsWith(verdict), summary);
  const bridges = data.warnings.filter(({ kind }) => kind === "bridge").length;
  checkEqual("and how many groups a bridge connects", Number(summary.match(/(\d+) groups? connected by a bridge only/)?.[1] ?? 0), bridges);
  const names = await page.$$eval(".scan button", (buttons) => buttons.map((button) => button.textContent));
  check("the list shows every name as it is written", [...names].sort().join("\n") === data.scans.map((scan) => scan.name).sort().join("\n"));
  checkEqual("elements made of names", await page.locator("main img, main script, [onerror]").count(), 0);
  const warnings = await page.$$eval("#warnings li", (items) => items.map((item) => item.textContent));
  check(`the list of warnings has its ${data.warnings.length} entries`, warnings.join("\n") === data.warnings.map((warning) => warning.text).join("\n"));
  if (data.warnings.length === 0) {
    check("an empty list of warnings says so", (await page.textContent("#warnings")).includes("There are none"));
  } else {
    check("its heading counts them", (await page.textContent("#warnings h2")).includes(`(${data.warnings.length})`));
  }
}

async function checkMarks({ page, data }) {
  const marks = (selector) => page.locator(selector).count();
  const { scans, edges, stages } = data;
  const isPlural = scans.length > 1;
  const isReweighted = edges.some((edge) => edge.weights.length > 1);
  checkEqual("scans in the graph", await marks("#graph circle[data-node]"), isPlural ? scans.length : 0);
  checkEqual("edges in the graph", await marks("#graph path[data-edge]"), edges.length);
  checkEqual("pairs without a relative pose in the graph", await marks("#graph .unresolved path"), data.unresolved.length);
  checkEqual("pictures of the confidence matrix", await marks("#matrix figure image"), isPlural ? 1 : 0);
  checkEqual("edges in the confidence matrix", await marks("#matrix rect[data-edge]"), edges.length);
  checkEqual("lines of weights", await marks("#weights path[data-edge]"), isReweighted ? edges.length : 0);
  checkEqual("rows of edges", await marks("#edges tr[data-edge]"), edges.length);
  checkEqual("bars of stages", await marks("#stages .bars rect"), stages.length);
}

/** How dark a color is, of its three channels in 0..255. */
const darkness = ([red, green, blue]) => 255 - (0.3 * red + 0.59 * green + 0.11 * blue);

/** Whether darkness never falls by more than rounding explains, in the order of `values`. */
function darkensWith(entries) {
  const sorted = [...entries].sort((a, b) => a.value - b.value);
  return sorted.every((entry, k) => k === 0 || darkness(entry.color) >= darkness(sorted[k - 1].color) - 1.5);
}

/** Colors of the edges as the graph, the matrix, the weights and the table show them: by what became of each. */
async function checkColors({ page, data }) {
  if (data.edges.length === 0) return;
  const colorsOf = (selector, property) =>
    page.$$eval(selector, (marks, style) => {
      const colors = [];
      for (const mark of marks) {
        const styled = style === "backgroundColor" ? mark.querySelector(".swatch") : mark;
        colors[mark.dataset.edge] = getComputedStyle(styled)[style];
      }
      return colors;
    }, property);
  const colors = await colorsOf("#graph path[data-edge]", "stroke");
  for (const [place, selector, property] of [["matrix", "#matrix rect[data-edge]", "fill"], ["weights", "#weights path[data-edge]", "stroke"], ["table", "#edges tr[data-edge]", "backgroundColor"]]) {
    const others = await colorsOf(selector, property);
    check(`colors of the graph in the ${place}`, others.length === 0 || others.join() === colors.join());
  }
  const state = (edge) => (isBridge(data, edge) ? "bridge" : keptFraction(edge) < 0.1 ? "dropped" : "kept");
  const shown = data.edges.map((edge, k) => ({ state: state(edge), value: keptFraction(edge), text: colors[k], color: colors[k].match(/\d+/g).map(Number) }));
  const texts = (wanted) => new Set(shown.filter((edge) => edge.state === wanted).map((edge) => edge.text));
  const [bridges, dropped, kept] = ["bridge", "dropped", "kept"].map(texts);
  check("bridges have one color, dropped edges another", bridges.size <= 1 && dropped.size <= 1 && [...bridges].every((text) => !dropped.has(text)));
  check("which no other edge has", [...bridges, ...dropped].every((text) => !kept.has(text)));
  check("kept edges are the darker, the more they kept", darkensWith(shown.filter((edge) => edge.state === "kept")));
}

/** Colors of the cells of the confidence matrix, where the pointer finds them. */
async function checkHeatMap({ page, data }) {
  const n = data.scans.length;
  if (n < 2 || n > 100) return;
  const figure = page.locator("#matrix svg.plot");
  await figure.scrollIntoViewIfNeeded();
  await parkPointer(page);
  const [frame, image] = [await figure.boundingBox(), await page.locator("#matrix figure image").boundingBox()];
  const place = (row, column) => ({
    x: image.x - frame.x + ((column + 0.5) * image.width) / n,
    y: image.y - frame.y + ((row + 0.5) * image.height) / n,
  });
  const pairs = Array.from({ length: n }, (_, i) => Array.from({ length: n - i - 1 }, (_, k) => [i, i + 1 + k])).flat();
  const isEdge = new Set(data.edges.map(({ i, j }) => `${i},${j}`));
  const isScored = new Set(data.scored_pairs.map(([i, j]) => `${i},${j}`));
  const empty = pairs.filter((pair) => !isEdge.has(pair.join())).map(([i, j]) => place(j, i));
  const unscored = pairs.filter((pair) => !isScored.has(pair.join())).map(([i, j]) => place(i, j));
  const colors = await page.evaluate(async ({ encoded, places }) => {
    const { width, data: bytes } = await window.decodePicture(encoded);
    return places.map(({ x, y }) => [...bytes.slice(4 * (Math.floor(y) * width + Math.floor(x))).slice(0, 3)]);
  }, {
    encoded: (await figure.screenshot()).toString("base64"),
    places: [...data.scored_pairs.map(([i, j]) => place(i, j)), ...empty, ...unscored],
  });
  const cells = data.scored_pairs.map(([, , value], k) => ({ value, color: colors[k] }));
  check("cells above the diagonal are the darker, the more confident their pair is", darkensWith(cells));
  const values = cells.map(({ value }) => value);
  if (Math.max(...values) > 4 * Math.min(...values)) {
    const [least, most] = [Math.min, Math.max].map((pick) => cells.find(({ value }) => value === pick(...values)).color);
    check("and their colors differ", darkness(most) > darkness(least) + 60, `${least} and ${most}`);
  }
  check("cells without an edge below it, and without a confidence above it, are white", colors.slice(cells.length).every((color) => color.join() === "255,255,255"));
}

/** Heights of the lines of weights at their ends. */
async function checkWeights({ page, data }) {
  const lines = await page.$$eval("#weights path[data-edge]", (paths) => paths.map((path) => {
    const points = path.getAttribute("d").slice(1).split("L").map((point) => point.split(",").map(Number));
    return { edge: Number(path.dataset.edge), heights: points.map(([, y]) => y) };
  }));
  if (lines.length === 0) return;
  const samples = lines.flatMap(({ edge, heights }) => data.edges[edge].weights.map((weight, k) => ({
    lost: 1 - Math.min(1, data.edges[edge].initial_weight > 0 ? weight / data.edges[edge].initial_weight : 0),
    depth: heights[k] - heights[0],
  })));
  const deepest = samples.reduce((a, b) => (b.lost > a.lost ? b : a));
  check("lines of weights fall by what the edges lost", samples.every(({ lost, depth }) => Math.abs(depth * deepest.lost - lost * deepest.depth) < 1) && deepest.depth >= 0);
  check("with a value for every iteration", lines.every(({ edge, heights }) => heights.length === data.edges[edge].weights.length));
}

/** Whether `text` is `value` rounded to the decimals or digits that it shows. */
function shows(text, value) {
  const [, below, digits, decimals = ""] = plain(text).match(/^(< )?(-?\d[\d ]*(?:\.(\d+))?(?:e-?\d+)?)/) ?? [];
  if (digits === undefined) return false;
  const number = Number(digits.replaceAll(" ", ""));
  if (below !== undefined) return value > 0 && value < number;
  return Math.abs(number - value) <= Math.max(0.5 * 10 ** -decimals.length, 0.006 * Math.abs(value)) * 1.0001;
}

const hasResidual = (data, edge) => edge.rotation_residual !== null && !isBridge(data, edge);

async function checkTable({ page, data }) {
  if (data.edges.length === 0) return;
  const headings = (await page.$$eval("#edges th", (cells) => cells.map((cell) => cell.textContent))).map((text) => text.replaceAll("\u00ad", ""));
  checkEqual("headings of the table", headings.join(" | "), "Edge | Confidence | Corr. | Inliers | Weight | Kept | Rot. ° | Transl.");
  const rows = await page.$$eval("#edges tr[data-edge]", (all) => all.map((row) => ({ edge: Number(row.dataset.edge), cells: [...row.cells].map((cell) => cell.textContent) })));
  for (const { edge: index, cells } of rows) {
    const edge = data.edges[index];
    const expected = [edge.confidence, edge.correspondences, 100 * edge.inlier_ratio, edge.final_weight, 100 * keptFraction(edge), edge.rotation_residual, edge.translation_residual];
    const isShown = expected.every((value, k) => (k > 4 && !hasResidual(data, edge) ? cells[k + 1] === "\u2013" : shows(cells[k + 1], value)));
    if (!isShown || plain(cells[0]) !== `${edge.i} - ${edge.j}`) check(`row ${index} of the table shows its edge`, false, cells.join(" | "));
  }
  const rank = (edge) => (isBridge(data, edge) ? 0 : keptFraction(edge) < 0.1 ? 2 : 1);
  const order = rows.map(({ edge }) => rank(data.edges[edge]));
  check("every row of the table shows its edge, bridges first and dropped edges last", order.every((r, k) => k === 0 || order[k - 1] <= r));
  const { scrollWidth, clientWidth } = await page.$eval(".table-frame", ({ scrollWidth, clientWidth }) => ({ scrollWidth, clientWidth }));
  check("no column is cut", scrollWidth <= clientWidth, `${scrollWidth} of ${clientWidth} px`);
}

async function checkScene({ page, data }) {
  const choice = page.locator('[data-control="component"]');
  const main = (await choice.count()) === 0 ? 0 : Number(await choice.inputValue());
  const shown = data.components[main].scans.filter((scan) => data.scans[scan].count > 0);
  const scan = shown[0];
  checkEqual("a message stands in for points", await page.isVisible("#canvas-frame .message"), scan === undefined);
  if (scan === undefined) return;

  const all = await picture(page);
  const ink = await inkOf(page, all);
  check("the 3-D view shows points", ink.count > 500, `${ink.count} pixels`);
  const { span } = await inkOf(page, await picture(page, true));
  check("and they fill it", span > 0.6, `${(100 * span).toFixed(0)} %`);
  const frames = await frameCount(page);
  await page.waitForTimeout(400);
  checkEqual("frames drawn while nothing moves", (await frameCount(page)) - frames, 0);

  const box = page.locator(`input[data-scan="${scan}"]`);
  await box.click();
  check("hiding a scan changes the picture", (await picture(page)) !== all);
  await box.click();
  check("showing it again brings the picture back", (await picture(page)) === all);
  await box.focus();
  await page.keyboard.press("Space");
  check("the space bar hides a scan, too", (await picture(page)) !== all);
  await page.click('[data-show="none"]');
  checkEqual("pixels with every scan hidden", (await inkOf(page, await picture(page))).count, 0);
  await page.click('[data-show="all"]');
  check("showing all brings the picture back", (await picture(page)) === all);

  await page.selectOption('[data-control="coloring"]', "height");
  check("color by height changes the picture", (await picture(page)) !== all);
  await page.selectOption('[data-control="coloring"]', "scan");
  check("color by scan brings it back", (await picture(page)) === all);

  await page.locator('[data-control="size"]').fill("5");
  check("larger points cover more", (await inkOf(page, await picture(page))).count > ink.count);
  await page.locator('[data-control="size"]').fill("2");
  await page.locator('[data-control="explode"]').fill("1");
  if (shown.length > 1) check("exploding moves the scans", (await picture(page)) !== all);
  await page.locator('[data-control="explode"]').fill("0");
  await page.check('[data-control="edges"]');
  const isConnected = data.edges.some((edge) => keptFraction(edge) >= 0.1 && shown.includes(edge.i) && shown.includes(edge.j));
  check("kept edges show exactly where there are some", ((await picture(page)) !== all) === isConnected);
  await page.uncheck('[data-control="edges"]');
  check("without them the picture is back", (await picture(page)) === all);

  const frame = await page.locator("#canvas-frame").boundingBox();
  await page.mouse.click(frame.x + margin + ink.x, frame.y + margin + ink.y);
  check("a click on a point selects its scan", await page.isVisible("#selection"));
  await page.keyboard.press("Escape");
  check("escape clears the selection", !(await page.isVisible("#selection")) && (await picture(page)) === all);

  const frameTime = await orbit(page, frame);
  check("orbiting changes the picture", (await picture(page)) !== all);
  await page.click('[data-control="reset"]');
  check("resetting the view brings it back", (await picture(page)) === all);
  await page.mouse.move(frame.x + 200, frame.y + 200);
  await page.mouse.wheel(0, 2000); // Sensors may stand outside of what they saw.
  const far = await picture(page);
  await page.check('[data-control="frames"]');
  check("sensor frames change the picture", (await picture(page)) !== far);
  await page.uncheck('[data-control="frames"]');
  await page.click('[data-control="reset"]');
  check("and go away again", (await picture(page)) === all);
  console.log(`      median frame while orbiting ${frameTime.toFixed(1)} ms (software renderer)`);
}

/** Drags across the view; the median time between the frames drawn meanwhile, in milliseconds. */
async function orbit(page, frame) {
  const first = await frameCount(page);
  await page.mouse.move(frame.x + 200, frame.y + 200);
  await page.mouse.down();
  for (let k = 1; k <= 40; k++) await page.mouse.move(frame.x + 200 + 4 * k, frame.y + 200 + k);
  await page.mouse.up();
  await settle(page);
  const times = (await page.evaluate(() => window.frameTimes)).slice(first);
  const intervals = times.slice(1).map((time, k) => time - times[k]).sort((a, b) => a - b);
  return intervals[intervals.length >> 1] ?? 0;
}

async function checkComponents({ page, data }) {
  if (data.components.length < 2) return;
  const select = page.locator('[data-control="component"]');
  const first = await select.inputValue();
  const before = await picture(page);
  for (const [component, { scans }] of data.components.entries()) {
    if (component > 3 && component < data.components.length - 1) continue;
    await select.selectOption(String(component));
    checkEqual(`scans to tick with component ${component} shown`, await page.locator("input[data-scan]:enabled").count(), scans.length);
    const hasPoints = scans.some((scan) => data.scans[scan].count > 0);
    checkEqual(`a message instead of component ${component}`, await page.isVisible("#canvas-frame .message"), !hasPoints);
    if (hasPoints) check(`component ${component} is seen`, (await inkOf(page, await picture(page))).count > 0);
  }
  await select.selectOption(first);
  check("the first component looks as before", (await picture(page)) === before);
}

async function checkFacts({ page, data }) {
  const line = page.locator("#graph path[data-edge]").last();
  if ((await line.count()) === 0) return;
  await page.locator("#graph").scrollIntoViewIfNeeded();
  const at = await line.evaluate((path) => {
    const { x, y } = path.getPointAtLength(path.getTotalLength() / 2).matrixTransform(path.getScreenCTM());
    return { x, y };
  });
  await page.mouse.move(at.x, at.y);
  const edge = data.edges[await page.locator("#graph path.hovered").getAttribute("data-edge")];
  await checkTooltip(page, data, edge);
  await page.mouse.click(at.x, at.y);
  const selected = Number(await page.locator("#edges tr.selected").getAttribute("data-edge"));
  check("clicking it selects it", (await page.isVisible("#selection")) && data.edges[selected] === edge);
  await page.keyboard.press("Escape");

  await checkOrdinaryEdge(page, data);
  await checkPairs(page, data);
  await checkMatrixHover(page, data);
  await checkSelection(page, data);
  await page.click("#edges th:nth-child(2) button");
  const sorted = await page.$$eval("#edges tbody tr", (rows) => rows.map((row) => Number(row.dataset.edge)));
  check("the table sorts by confidence", sorted.every((e, k) => k === 0 || data.edges[sorted[k - 1]].confidence <= data.edges[e].confidence));
}

/** The tooltip of an edge with residuals, which others may cover. */
async function checkOrdinaryEdge(page, data) {
  const lines = await page.$$eval("#graph .kept path", (paths) => paths.map((path) => Number(path.dataset.edge)));
  const k = lines.findIndex((edge) => hasResidual(data, data.edges[edge]));
  if (k < 0) return;
  const hit = page.locator("#graph .hit-kept path").nth(k);
  await hit.dispatchEvent("mousemove", { clientX: 10, clientY: 10 });
  await checkTooltip(page, data, data.edges[lines[k]]);
  await hit.dispatchEvent("mouseleave");
}

async function checkTooltip(page, data, edge) {
  const facts = await page.$$eval("#tooltip dl > div", (all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
  const rows = Object.fromEntries(facts);
  const expected = {
    confidence: edge.confidence,
    "inlier ratio": 100 * edge.inlier_ratio,
    correspondences: edge.correspondences,
    "clique size": edge.clique_size,
    "cliques seen": edge.cliques_seen,
    weight: edge.initial_weight,
    kept: 100 * keptFraction(edge),
    "rotation residual": edge.rotation_residual,
    "translation residual": edge.translation_residual,
  };
  checkEqual("facts shown when an edge is hovered", Object.keys(rows).join(), Object.keys(expected).join());
  for (const [term, value] of Object.entries(expected)) {
    const isOpen = term.endsWith("residual") && !hasResidual(data, edge);
    check(`${term}: ${rows[term]}`, isOpen ? rows[term].startsWith("\u2013") : shows(rows[term], value), `expected ${value}`);
  }
  check("and the final weight", shows(rows.weight.split("→ ")[1], edge.final_weight));
}

/** Gray lines: they answer to the pointer; they and the dropped edges can be switched off. */
async function checkPairs(page, data) {
  const hit = page.locator("#graph .hit-pairs path").last();
  if ((await hit.count()) > 0) {
    await hit.dispatchEvent("mousemove", { clientX: 10, clientY: 10 });
    const [i, j] = plain(await page.textContent("#tooltip strong")).match(/\d+/g).map(Number);
    const [, , confidence] = data.scored_pairs.find((pair) => pair[0] === i && pair[1] === j);
    check("a gray line tells the confidence of its pair", shows(await page.textContent("#tooltip dd"), confidence));
    check("which is no edge", !data.edges.some((edge) => edge.i === i && edge.j === j));
    await hit.dispatchEvent("mouseleave");
  }
  for (const name of ["pairs", "dropped"]) {
    const box = page.locator(`input[data-graph="${name}"]`);
    if ((await box.count()) === 0) continue;
    const line = page.locator(`#graph .${name} path`).first();
    await box.uncheck();
    const isHidden = !(await line.isVisible());
    await box.check();
    check(`a box hides the lines "${name}" and brings them back`, isHidden && (await line.isVisible()));
  }
}

/** Hovers the cell of an edge, where a cell is not smaller than the pixels that a pointer moves by. */
async function checkMatrixHover(page, data) {
  if (data.scans.length > 100) return;
  await page.locator("#matrix svg.plot").scrollIntoViewIfNeeded();
  await page.locator('#matrix rect[data-edge="0"]').hover({ force: true });
  const { i, j } = data.edges[0];
  const title = await page.textContent("#tooltip strong");
  check("hovering a cell names its pair", title.replaceAll("\u202f", "").startsWith(`${i}\u2013${j}:`), title);
  await parkPointer(page);
}

/** Selects an edge of the component that is shown, if there is one with points beside it to dim. */
async function checkSelection(page, data) {
  const main = data.scans[await page.locator("input[data-scan]:enabled").first().getAttribute("data-scan")].component;
  const filled = data.components[main].scans.filter((scan) => data.scans[scan].count > 0);
  const index = data.edges.findIndex(({ i, j }) => filled.includes(i) && filled.includes(j));
  if (index < 0 || filled.length < 3) return;
  const before = await picture(page);
  await page.locator(`#edges tr[data-edge="${index}"] button`).click();
  const strip = await page.textContent("#selection");
  const names = [data.edges[index].i, data.edges[index].j].map((scan) => data.scans[scan].name);
  check("selecting an edge names its scans", names.every((name) => strip.includes(name)), strip);
  check("and dims the others", (await picture(page)) !== before);
  checkEqual("cells that stand out", await page.locator("#matrix rect.selected").count(), 1);
  await page.locator("#selection button").click();
  check("clearing brings the picture back", (await picture(page)) === before);
}

/** Clicks the first warning of every kind, and the one with most scans. */
async function checkWarnings({ page, data }) {
  const { warnings } = data;
  if (await page.isVisible("#warnings .more")) {
    await page.click("#warnings .more");
    checkEqual("entries after \"show all\"", await page.locator("#warnings li:visible").count(), warnings.length);
  }
  const most = warnings.reduce((best, { scans }, k) => (scans.length > (warnings[best]?.scans.length ?? 0) ? k : best), 0);
  const empty = warnings.findIndex(({ kind, scans }) => kind === "unregistered" && data.scans[scans[0]].count === 0);
  const chosen = warnings.flatMap(({ kind }, k) => (warnings.findIndex((other) => other.kind === kind) === k || k === most || k === empty ? [k] : []));
  for (const k of chosen) {
    const { kind, scans, edge, text } = warnings[k];
    await page.locator("#warnings li button").nth(k).click();
    const marked = await page.$$eval(".scan.selected input", (inputs) => inputs.map((input) => Number(input.dataset.scan)));
    check(`entry ${k}, "${kind}", selects its scans`, marked.sort((a, b) => a - b).join() === [...scans].sort((a, b) => a - b).join(), marked.join());
    const rows = await page.$$eval("#edges tr.selected", (all) => all.map((row) => Number(row.dataset.edge)));
    const expected = edge === null ? -1 : data.edges.findIndex(({ i, j }) => i === edge[0] && j === edge[1]);
    checkEqual("and its edge", rows.join(), expected < 0 ? "" : String(expected));
    const strip = plain(await page.textContent("#selection"));
    if (scans.length > 2) {
      const points = scans.reduce((sum, scan) => sum + data.scans[scan].points, 0);
      const among = data.edges.filter((e) => keptFraction(e) >= 0.1 && scans.includes(e.i) && scans.includes(e.j)).length;
      check("the strip sums up a group", strip.startsWith(`${scans.length} scans`) && strip.replaceAll(" ", "").includes(`points${points}keptedgesamongthem${among}`), strip);
    }
    if (kind === "unregistered") check("the strip says why", strip.includes(plain(text)), strip);
    const hasPicture = (await page.locator("#canvas-frame canvas").count()) > 0 && data.scans.some((scan) => scan.count > 0);
    if (k === empty && hasPicture) check("and the picture stays", !(await page.isVisible("#canvas-frame .message")));
    await page.keyboard.press("Escape");
  }
}

async function checkReport(browser, file) {
  console.log(basename(file));
  const report = await openReport(browser, file);
  check(`ready within ${mostLoadTime / 1000} s`, report.loadTime < mostLoadTime, `${report.loadTime.toFixed(0)} ms`);
  console.log(`      ready after ${report.loadTime.toFixed(0)} ms`);
  checkContract(report);
  await checkText(report);
  await checkMarks(report);
  await checkColors(report);
  await checkHeatMap(report);
  await checkWeights(report);
  await checkTable(report);
  if (report.data.scans.length > 0) await checkScene(report);
  await checkComponents(report);
  await checkFacts(report);
  await checkWarnings(report);
  if (process.env.GMPCR_SCREENSHOTS) await takeScreenshots(report.page, join(process.env.GMPCR_SCREENSHOTS, basename(file, ".html")));
  check("no error, no warning and no request but the file", report.troubles.length === 0, report.troubles.join("; "));
  await report.page.close();
}

async function takeScreenshots(page, stem) {
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({ path: `${stem}.png` });
  await page.screenshot({ path: `${stem}-whole.png`, fullPage: true });
}

/** Without WebGL the 3-D view gives way to a message, and the rest is there. */
async function checkWithoutWebGl(file) {
  console.log(`${basename(file)}, without WebGL`);
  const browser = await chromium.launch({ executablePath, args: [...quiet, "--disable-3d-apis"] });
  try {
    const report = await openReport(browser, file);
    check("a message stands in for the 3-D view", (await report.page.textContent("#canvas-frame .message")).includes("WebGL"));
    await checkText(report);
    await checkMarks(report);
    await checkWarnings(report);
    check("no error, no warning and no request but the file", report.troubles.length === 0, report.troubles.join("; "));
  } finally {
    await browser.close();
  }
}

// ---------------------------------------------------------------------------------------- the program

/** Samples that together reach every branch of the page. */
const samples = {
  rooms: { scans: 24, points: 2000 },
  "sixty-scans": { scans: 60, points: 5000, hasRetrieval: true },
  "one-scan": { scans: 1, points: 2000 },
  "two-scans-not-reweighted": { scans: 2, points: 2000, iterations: 0 },
  "no-edges": { scans: 5, points: 500, hasEdges: false },
  "no-points": { scans: 3, points: 0 },
  "no-scans": { scans: 0 },
};

async function main(files) {
  const folder = mkdtempSync(join(tmpdir(), "gmpcr-report-"));
  const browser = await chromium.launch({ executablePath, args: [...quiet, ...softwareGl] });
  try {
    const isSampled = files.length === 0;
    for (const [name, options] of isSampled ? Object.entries(samples) : []) {
      files.push(join(folder, `${name}.html`));
      writeFileSync(files.at(-1), fillTemplate(sampleData(options)));
    }
    for (const file of files) await checkReport(browser, resolve(file));
    if (isSampled) await checkWithoutWebGl(files[0]);
  } catch (error) {
    console.error(error instanceof CheckFailed ? `FAILED  ${error.message}` : error);
    process.exitCode = 1;
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true });
  }
}

await main(process.argv.slice(2));
