// Runs manifests with the engine of report pages and compares the hashes of their messages with kinetoscope.lock:
//
//     node tests/architectures/engine.mjs target/browser/kinetoscope-engine.wasm experiments/*.toml
//     node tests/architectures/engine.mjs --time MODULE MANIFEST …    processor time of the first run of each, the best of three
//
// Exit code 1 if one differs.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { performance } from "node:perf_hooks";

const FAILED = 3, ENDED = 2;
const words = process.argv.slice(2);
const isTimed = words[0] === "--time";
const [program, ...manifests] = isTimed ? words.slice(1) : words;
const lock = readFileSync(new URL("../../kinetoscope.lock", import.meta.url), "utf8").split("[[experiment]]\n");
const { exports: engine } = await WebAssembly.instantiate(new WebAssembly.Module(readFileSync(program)));

const output = () => {
  const place = engine.output();
  return Buffer.from(engine.memory.buffer, Number(place >> 32n), Number(place & 0xffffffffn));
};

const ask = (name, bytes, argument) => {
  // The memory may grow for the input.
  const place = bytes && engine.input(bytes.length);
  if (bytes) new Uint8Array(engine.memory.buffer, place, bytes.length).set(bytes);
  const status = engine[name](argument);
  if (status === FAILED) throw new Error(output().toString());
  return status;
};

// The hash of all messages of a run.
const messages = (run) => {
  ask("start", undefined, run);
  while (ask("advance", undefined, 1 << 16) !== ENDED);
  return JSON.parse(output()).messages;
};

for (const path of manifests) {
  const text = readFileSync(path);
  ask("plan", text);
  const { runs } = JSON.parse(output());
  if (isTimed) {
    const seconds = [0, 1, 2].map(() => {
      const started = process.cpuUsage();
      messages(0);
      return process.cpuUsage(started).user / 1e6;
    });
    console.log(`${path}: ${Math.min(...seconds).toFixed(3)} s`);
    continue;
  }
  const started = performance.now();
  const found = runs.map((_, run) => messages(run));
  const all = found.length === 1 ? found[0] : createHash("sha256").update(found.join("")).digest("hex").slice(0, 32);
  const entry = lock.find((entry) => entry.includes(`manifest = "experiments/${path.split("/").pop()}"`));
  const isEqual = entry?.includes(`\nmessages = "${all}"\n`);
  const seconds = ((performance.now() - started) / 1000).toFixed(1);
  console.log(`${path}: ${isEqual ? "equal" : "DIFFERENT"}, ${runs.length} runs, ${seconds} s`);
  if (!isEqual) process.exitCode = 1;
}
