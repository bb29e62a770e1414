// Takes the pictures of docs/replay_gallery.md: opens a recording of each experiment with its layout in Lichtblick, and makes a screenshot.
//
// Usage: node docs/replay/take_pictures.mjs LICHTBLICK RECORDINGS OUTPUT [EXPERIMENT ...]
//   LICHTBLICK: the folder that `yarn web:build:prod` of Lichtblick makes (web/.webpack); RECORDINGS: a folder per experiment.
// Needs playwright-core (npm) where node finds it, and the programs chromium and pngquant.

import { spawnSync } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import path from "node:path";

const { chromium } = createRequire(path.join(process.cwd(), "package.json"))("playwright-core");

const [viewer, recordings, output, ...names] = process.argv.slice(2);
const SETTLE_MS = 4000;
// A busy machine takes minutes to load the viewer.
const TIMEOUT_MS = 300000;
const SIZE = { width: 1280, height: 900 };
// The ends of the slider below the panels, in pixels.
const SLIDER = { left: 8, right: 1272, y: 843 };
// Part of the playback at which the picture is taken, where the middle shows little.
const MOMENT = { dem_column_collapse: 0.3, dem_twenty_discs: 0.2, first_run: 0.25, dem_thousand_discs: 0.12, dem_newtons_cradle: 0.55,
  dem_exercise_damping: 0.35, dem_heap: 0.9, dem_hopper_discharge: 0.3, dem_incline: 0.8, dem_restitution: 0.3, dem_silo: 0.9, gas_free_expansion: 0.1, gas_mixing: 0.15 };
// The run of a sweep, by a part of its name; otherwise, the middle one.
const RUNS = { dem_heap: "friction=0.5", orbit_trojans: "60-degrees", packing_self_diffusion: "0.05__r000" };
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".wasm": "application/wasm",
  ".svg": "image/svg+xml", ".png": "image/png" };

// The viewer at /, the recordings at /rec/. Recordings are read in parts.
const server = http.createServer((request, response) => {
  const name = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
  const file = name.startsWith("/rec/") ? path.join(recordings, name.slice(5)) : path.join(viewer, name === "/" ? "index.html" : name);
  if (!fs.existsSync(file)) return response.writeHead(404).end();
  const { size } = fs.statSync(file), range = /bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "");
  const [start, end] = range ? [Number(range[1]), range[2] ? Number(range[2]) : size - 1] : [0, size - 1];
  const headers = { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream", "content-length": end - start + 1, "accept-ranges": "bytes" };
  if (range) headers["content-range"] = `bytes ${start}-${end}/${size}`;
  response.writeHead(range ? 206 : 200, headers);
  if (request.method === "HEAD") return response.end();
  fs.createReadStream(file, { start, end }).pipe(response);
});
await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
const origin = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] });
const all = fs.readdirSync(recordings).filter((name) => fs.existsSync(path.join(recordings, name, `${name}.layout.json`)));
for (const name of names.length ? names : all) {
  const runs = fs.readdirSync(path.join(recordings, name)).filter((file) => file.endsWith(".mcap")).sort();
  const run = runs.find((file) => RUNS[name] && file.includes(RUNS[name])) ?? runs[Math.floor(runs.length / 2)];
  const page = await browser.newPage({ viewport: SIZE, colorScheme: "dark" }), messages = [];
  page.setDefaultTimeout(TIMEOUT_MS);
  page.on("console", (message) => { if (message.type() === "error") messages.push(message.text()); });
  page.on("pageerror", (error) => messages.push(String(error)));
  const query = new URLSearchParams({ ds: "remote-file", "ds.url": `${origin}/rec/${name}/${run}`, layoutUrl: `${origin}/rec/${name}/${name}.layout.json` });
  await page.goto(`${origin}/?${query}`);
  await page.getByText("playback time").or(page.getByText("Log")).first().waitFor().catch(() => {});
  await page.waitForTimeout(SETTLE_MS);
  // Closes the sidebar.
  await page.mouse.click(305, 58);
  const picture = path.join(output, `${name}.png`);
  // Until the whole recording is read and drawn.
  for (let before, now, tries = 0; tries < 20 && !(before && now.equals(before)); tries++) {
    before = now;
    // Again, because a viewer that is still loading ignores it.
    if (tries < 2) await page.mouse.click(SLIDER.left + (MOMENT[name] ?? 0.5) * (SLIDER.right - SLIDER.left), SLIDER.y);
    await page.mouse.move(640, 20);
    await page.waitForTimeout(SETTLE_MS);
    now = await page.screenshot({ path: picture });
  }
  spawnSync("pngquant", ["--force", "--ext", ".png", "--nofs", "--speed", "1", "96", picture], { stdio: "inherit" });
  console.log(`${name} ${run} ${fs.statSync(picture).size} bytes; messages: ${[...new Set(messages)].join(" | ").slice(0, 300)}`);
  await page.close();
}
await browser.close();
server.close();
