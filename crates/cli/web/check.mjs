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
  const start = performance.now();
  await page.goto(url);
  await page.waitForSelector('body[data-ready="true"]', { timeout: 120_000 });
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
  window.requestAnimationFrame = (callback) =>
    request((time) => {
      window.frameTimes.push(performance.now());
      callback(time);
    });
}

const frameCount = (page) => page.evaluate(() => window.frameTimes.length);

/** Waits until the page draws no more. */
async function settle(page) {
  for (let before = -1; before !== (await frameCount(page)); ) {
    before = await frameCount(page);
    await page.waitForTimeout(80);
  }
}

const parkPointer = (page) => page.mouse.move(viewport.width - 2, 2);

const margin = 8;

/** Base64 PNG of the part of the canvas that no legend, strip of the selection or focus ring covers. */
async function picture(page) {
  await parkPointer(page);
  await settle(page);
  const box = await page.locator("#canvas-frame").boundingBox();
  const clip = { x: box.x + margin, y: box.y + margin, width: box.width - 260, height: box.height - 150 };
  return (await page.screenshot({ clip })).toString("base64");
}

/** Pixels of a picture that differ from the one in its corner, and where one of them is. */
function inkOf(page, png) {
  return page.evaluate(async (encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer);
    const inked = [...pixels.keys()].filter((k) => pixels[k] !== pixels[0]);
    const middle = inked[inked.length >> 1] ?? 0;
    return { count: inked.length, x: middle % bitmap.width, y: Math.floor(middle / bitmap.width) };
  }, png);
}

// ------------------------------------------------------------------------------------------ the checks

async function checkText({ page, data }) {
  const title = await page.title();
  check("the title names the folder", title.startsWith(data.title), title);
  const summary = (await page.textContent("#summary")).replaceAll("\u202f", "");
  check("the summary counts scans and edges", summary.startsWith(`${data.scans.length} scan`) && summary.includes(`${data.edges.length} edge`), summary);
  const names = await page.$$eval(".scan button", (buttons) => buttons.map((button) => button.textContent));
  check("the list shows every name as it is written", [...names].sort().join("\n") === data.scans.map((scan) => scan.name).sort().join("\n"));
  checkEqual("elements made of names", await page.locator("main img, main script, [onerror]").count(), 0);
  const attention = await page.$$eval("#attention li", (items) => items.map((item) => item.textContent));
  check(`the attention list has its ${data.attention.length} entries`, attention.join("\n") === data.attention.map((a) => a.text).join("\n"));
  if (data.attention.length === 0) {
    check("an empty attention list says so", (await page.textContent("#attention")).includes("Nothing stands out"));
  }
}

async function checkMarks({ page, data }) {
  const marks = (selector) => page.locator(selector).count();
  const { scans, edges, confidences, stages } = data;
  const isPlural = scans.length > 1;
  const strongest = confidences.reduce((a, b) => Math.max(a, b), 0);
  const pairs = Math.min(3000, confidences.filter((c) => c > 0 && c >= 0.02 * strongest).length);
  const isReweighted = edges.some((edge) => edge.weights.length > 1);
  checkEqual("scans in the graph", await marks("#graph circle[data-node]"), isPlural ? scans.length : 0);
  checkEqual("edges in the graph", await marks("#graph path[data-edge]"), edges.length);
  checkEqual("grey pairs in the graph", await marks("#graph .pairs path"), isPlural ? pairs : 0);
  checkEqual("pairs without a motion in the graph", await marks("#graph .unresolved path"), data.unresolved.length);
  checkEqual("pictures of the confidence matrix", await marks("#matrix figure image"), isPlural ? 1 : 0);
  checkEqual("framed cells of the confidence matrix", await marks("#matrix rect[data-edge]"), 2 * edges.length);
  checkEqual("lines of weights", await marks("#weights path[data-edge]"), isReweighted ? edges.length : 0);
  checkEqual("rows of edges", await marks("#edges tr[data-edge]"), edges.length);
  checkEqual("bars of stages", await marks("#stages .bars rect"), stages.length);
}

async function checkScene({ page, data }) {
  const main = Number(await page.inputValue('[data-control="component"]').catch(() => 0));
  const shown = data.components[main].scans.filter((scan) => data.scans[scan].count > 0);
  const scan = shown[0];
  if (scan === undefined) return check("a scene without a point is empty", (await inkOf(page, await picture(page))).count === 0);

  const all = await picture(page);
  const ink = await inkOf(page, all);
  check("the 3-D view shows points", ink.count > 500, `${ink.count} pixels`);
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

  for (const colouring of ["component", "height"]) {
    await page.selectOption('[data-control="colouring"]', colouring);
    check(`colour by ${colouring} changes the picture`, (await picture(page)) !== all);
  }
  await page.selectOption('[data-control="colouring"]', "scan");
  check("colour by scan brings it back", (await picture(page)) === all);

  await page.locator('[data-control="size"]').fill("5");
  check("larger points cover more", (await inkOf(page, await picture(page))).count > ink.count);
  await page.locator('[data-control="size"]').fill("2");
  await page.locator('[data-control="explode"]').fill("1");
  if (shown.length > 1) check("exploding moves the scans", (await picture(page)) !== all);
  await page.locator('[data-control="explode"]').fill("0");
  await page.check('[data-control="frames"]');
  check("sensor frames change the picture", (await picture(page)) !== all);
  await page.uncheck('[data-control="frames"]');
  await page.check('[data-control="edges"]');
  const isJoined = data.edges.some(({ i, j }) => shown.includes(i) && shown.includes(j));
  check("edges show exactly where there are some", ((await picture(page)) !== all) === isJoined);
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
    check(`component ${component} is seen exactly if it has points`, (await inkOf(page, await picture(page))).count > 0 === hasPoints);
  }
  await select.selectOption(first);
  check("the first component looks as before", (await picture(page)) === before);
}

async function checkEvidence({ page, data }) {
  const hit = page.locator("#graph .hit path");
  if ((await hit.count()) === 0) return;
  await page.locator("#graph").scrollIntoViewIfNeeded();
  const at = await hit.last().evaluate((path) => {
    const { x, y } = path.getPointAtLength(path.getTotalLength() / 2).matrixTransform(path.getScreenCTM());
    return { x, y };
  });
  await page.mouse.move(at.x, at.y);
  const evidence = (await page.textContent("#tooltip dl")).toLowerCase();
  const terms = ["confidence", "inlier ratio", "correspondences", "clique size", "cliques seen", "weight", "rotation residual", "translation residual"];
  check("hovering an edge shows its evidence", (await page.isVisible("#tooltip")) && terms.every((term) => evidence.includes(term)), evidence);
  await page.mouse.click(at.x, at.y);
  check("clicking it selects it", (await page.isVisible("#selection")) && (await page.locator("#edges tr.selected").count()) === 1);
  await page.keyboard.press("Escape");

  await checkMatrixHover(page, data);
  await checkSelection(page, data);
  await page.click("#edges th:nth-child(2) button");
  const sorted = await page.$$eval("#edges tbody tr", (rows) => rows.map((row) => Number(row.dataset.edge)));
  check("the table sorts by confidence", sorted.every((e, k) => k === 0 || data.edges[sorted[k - 1]].confidence <= data.edges[e].confidence));
}

/** Hovers the cell of an edge, where a cell is not smaller than the pixels that a pointer moves by. */
async function checkMatrixHover(page, data) {
  if (data.scans.length > 100) return;
  await page.locator("#matrix svg.plot").scrollIntoViewIfNeeded();
  await page.locator('#matrix rect[data-edge="0"]').first().hover({ force: true });
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
  checkEqual("framed cells that stand out", await page.locator("#matrix rect.selected").count(), 2);
  await page.locator("#selection button").click();
  check("clearing brings the picture back", (await picture(page)) === before);
}

async function checkAttention({ page, data }) {
  for (const [k, { scans }] of data.attention.slice(0, 4).entries()) {
    await page.locator("#attention li button").nth(k).click();
    const marked = await page.$$eval(".scan.selected input", (inputs) => inputs.map((input) => Number(input.dataset.scan)));
    check(`entry ${k} of the attention list selects its scans`, marked.sort((a, b) => a - b).join() === [...scans].sort((a, b) => a - b).join(), marked.join());
    await page.keyboard.press("Escape");
  }
}

async function checkReport(browser, file) {
  console.log(basename(file));
  const report = await openReport(browser, file);
  check("the page becomes ready", true);
  console.log(`      ready after ${report.loadTime.toFixed(0)} ms`);
  await checkText(report);
  await checkMarks(report);
  if (report.data.scans.length > 0) await checkScene(report);
  await checkComponents(report);
  await checkEvidence(report);
  await checkAttention(report);
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
  const report = await openReport(browser, file);
  check("a message stands in for the 3-D view", (await report.page.textContent("#canvas-frame .message")).includes("WebGL"));
  await checkText(report);
  await checkMarks(report);
  await checkAttention(report);
  check("no error, no warning and no request but the file", report.troubles.length === 0, report.troubles.join("; "));
  await browser.close();
}

// ---------------------------------------------------------------------------------------- the programme

/** Samples that together reach every branch of the page. */
const samples = {
  rooms: { scans: 24, points: 2000 },
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
