// Repeats the claimed runs in a worker. A call takes about 20 ms, so that it answers; the page ends it with terminate().
const FRAME = 1, ENDED = 2, FAILED = 3;
// Runs that take longer are not started without a question, s.
const LONG_S = 10;

// The bytes of an answer, in the memory of the engine.
const answer = (engine) => {
  const place = engine.output();
  return new Uint8Array(engine.memory.buffer, Number(place >> 32n), Number(place & 0xffffffffn));
};

const output = (engine) => new TextDecoder().decode(answer(engine));

const failure = (engine) => {
  const { error, help } = JSON.parse(output(engine));
  return new Error(help ? `${error}; ${help}` : error);
};

// A call that traps leaves the text of a defect, or nothing if the memory was not sufficient.
const ask = (engine, name, argument) => {
  let status;
  try {
    status = engine[name](argument);
  } catch (error) {
    throw new Error(output(engine) || `the engine stopped (${error.message}): 512 MB of memory were probably not enough`);
  }
  if (status === FAILED) throw failure(engine);
  return status;
};

// Numbers of a state that the page draws.
const MOST_NUMBERS = 40_000;
// Time between two frames of a changed run that the page shows, ms; of few particles, it shows so many frames in any case, for their paths.
const SHOWN_MS = 40, FEW_NUMBERS = 200, PATH_FRAMES = 1000;

let answered, kept;
self.addEventListener("message", ({ data }) => {
  const failed = (error) => postMessage({ failed: error.message });
  if ("module" in data || "compiled" in data) (kept = instance(data)).catch(() => {});
  else if ("claims" in data) kept.then((engine) => verify(engine, data)).catch(failed);
  else if ("manifest" in data) kept.then((engine) => rerun(engine, data.manifest)).catch(failed);
  else if ("recording" in data) kept.then((engine) => ask(engine, "recording") || postMessage({ recording: answer(engine).slice() })).catch(failed);
  else answered?.(data.frames);
});

const decoded = (text, what) => {
  try {
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let index = 0; index < bytes.length; index += 1) bytes[index] = letters.charCodeAt(index);
    return bytes;
  } catch {
    throw new Error(`${what} in this page is damaged: nothing was computed`);
  }
};

const isIntact = async (packed, hash) => {
  if (!crypto.subtle) throw new Error("at an address without https, the browser cannot check it: open the file itself");
  const found = new Uint8Array(await crypto.subtle.digest("SHA-256", packed));
  return Array.from(found, (byte) => byte.toString(16).padStart(2, "0")).join("") === hash;
};

// The engine of a page's module, and that module for its other workers.
const instance = async ({ module, hash, compiled }) => {
  if (compiled) return (await WebAssembly.instantiate(compiled, {})).exports;
  const packed = decoded(module, "the engine");
  try {
    if (!(await isIntact(packed, hash))) throw new Error("it is not the one of this page");
    const unpacked = new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip")));
    compiled = await WebAssembly.compile(await unpacked.arrayBuffer());
    postMessage({ compiled });
    return (await WebAssembly.instantiate(compiled, {})).exports;
  } catch (error) {
    throw new Error(`the engine is damaged or cannot be run here (${error.message}): nothing was computed`);
  }
};

const verify = async (engine, { claims, shown }) => {
  for (const [run, claim] of claims.entries()) {
    await Promise.resolve()
      .then(() => compare(engine, run, decoded(claim, "the list of hashes"), shown[run]))
      .catch((error) => postMessage({ run, error: error.message }));
  }
  postMessage({ done: true });
};

const hand = (engine, bytes) => {
  const place = engine.input(bytes.length);
  new Uint8Array(engine.memory.buffer, place, bytes.length).set(bytes);
};

// The steps or events of the next call, after one that took some ms.
const nextBudget = (budget, took) => (took < 10 ? Math.min(2 * budget, 2 ** 31) : took > 40 ? Math.max(1, budget >> 1) : budget);

// Runs the first run that a manifest plans, and hands its frames and its metrics to the page, which ends it with terminate().
const rerun = (engine, manifest) => {
  const started = performance.now(), bytes = new TextEncoder().encode(manifest);
  hand(engine, bytes);
  ask(engine, "plan");
  const planned = JSON.parse(output(engine)).runs.length;
  ask(engine, "start", 0);
  const { frames: of, columns } = JSON.parse(output(engine));
  const send = (frame) => {
    ask(engine, "columns");
    const rows = answer(engine).length / 8 / columns.length, most = Math.floor(MOST_NUMBERS / columns.length);
    const state = new Float64Array(answer(engine).slice(0, 8 * columns.length * most).buffer);
    postMessage({ frame, of, columns, state, rows, planned });
    return state.length <= FEW_NUMBERS ? Math.ceil(of / PATH_FRAMES) : Infinity;
  };
  let frame = 1, budget = 1, shown = performance.now();
  const every = send(frame);
  for (;;) {
    const before = performance.now();
    const status = ask(engine, "advance", budget);
    const now = performance.now(), seconds = (now - started) / 1000;
    budget = nextBudget(budget, now - before);
    if (status === FRAME) frame += 1;
    if (status === FRAME && (now - shown > SHOWN_MS || frame % every === 0)) {
      shown = now;
      send(frame);
    }
    if (status === ENDED) {
      const { frames, fault } = JSON.parse(output(engine));
      ask(engine, "metrics");
      postMessage({ ...JSON.parse(output(engine)), frames, fault, seconds });
      return;
    }
  }
};

const compare = async (engine, run, claim, texts) => {
  const started = performance.now();
  hand(engine, claim);
  ask(engine, "verify");
  const { version, claimed, messages: all, every, run_key: key, manifest } = JSON.parse(output(engine));
  if (texts.some((text) => text.trim() !== manifest.trim())) throw new Error("this page shows another manifest than that of the recorded run: it was changed");
  if (String(version) !== String(claimed)) postMessage({ run, versions: [claimed, version] });
  let frames = 1, budget = 1, shown = started, most = all, waited = 0, isAsked = false;
  // Frames between two hashes are compared with the second one.
  const compared = () => frames - (frames % every);
  const spent = () => (performance.now() - started - waited) / 1000;
  for (;;) {
    const before = performance.now();
    const status = ask(engine, "advance", budget);
    const now = performance.now();
    budget = nextBudget(budget, now - before);
    if (status === FRAME) frames += 1;
    if (status === ENDED) {
      postMessage({ run, all, key, seconds: spent(), ...JSON.parse(output(engine)) });
      return;
    }
    if (status === FRAME && compared() >= most && most < all) {
      postMessage({ run, all, key, frames: compared(), seconds: spent(), part: true });
      return;
    }
    if (now - shown > 100) {
      shown = now;
      postMessage({ run, all, frames: compared(), seconds: spent() });
      const expected = (spent() * all) / frames;
      if (!isAsked && spent() > 1 && expected > LONG_S) {
        isAsked = true;
        const few = every * Math.ceil(Math.max(frames + 1, (LONG_S * all) / expected) / every);
        postMessage({ run, all, few, expected });
        most = await new Promise((answer) => (answered = answer));
        waited += performance.now() - now;
      }
    }
  }
};
