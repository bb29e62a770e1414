// Repeats the claimed runs in a worker. A call takes about 20 ms, so that it answers; the page ends it with terminate().
const FRAME = 1, ENDED = 2, FAILED = 3;
// Runs that take longer are not started without a question, s.
const LONG_S = 10;

const output = (engine) => {
  const place = engine.output();
  return new TextDecoder().decode(new Uint8Array(engine.memory.buffer, Number(place >> 32n), Number(place & 0xffffffffn)));
};

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

let answered;
self.addEventListener("message", ({ data }) => {
  if ("module" in data) verify(data).catch((error) => postMessage({ failed: error.message }));
  else answered?.(data.frames);
});

const decoded = (text, what) => {
  try {
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let index = 0; index < bytes.length; index += 1) bytes[index] = letters.charCodeAt(index);
    return bytes;
  } catch {
    throw new Error(`${what} in this page is damaged: nothing was compared`);
  }
};

const isIntact = async (packed, hash) => {
  if (!crypto.subtle) throw new Error("at an address without https, the browser cannot check it: open the file itself");
  const found = new Uint8Array(await crypto.subtle.digest("SHA-256", packed));
  return Array.from(found, (byte) => byte.toString(16).padStart(2, "0")).join("") === hash;
};

const instance = async (text, hash) => {
  const packed = decoded(text, "the engine");
  if (!(await isIntact(packed, hash))) throw new Error("it is not the one of this page");
  const unpacked = new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip")));
  const module = await WebAssembly.compile(await unpacked.arrayBuffer());
  return (await WebAssembly.instantiate(module, {})).exports;
};

const verify = async ({ module, hash, claims }) => {
  const engine = await instance(module, hash).catch((error) => {
    throw new Error(`the engine is damaged or cannot be run here (${error.message}): nothing was compared`);
  });
  for (const [run, claim] of claims.entries()) {
    await Promise.resolve()
      .then(() => compare(engine, run, decoded(claim, "the list of hashes")))
      .catch((error) => postMessage({ run, error: error.message }));
  }
  postMessage({ done: true });
};

const compare = async (engine, run, claim) => {
  const started = performance.now();
  const place = engine.input(claim.length);
  new Uint8Array(engine.memory.buffer, place, claim.length).set(claim);
  ask(engine, "verify");
  const { version, claimed, messages: all, every, run_key: key } = JSON.parse(output(engine));
  if (String(version) !== String(claimed)) postMessage({ run, versions: [claimed, version] });
  let frames = 1, budget = 1, shown = started, most = all, waited = 0, isAsked = false;
  // Frames between two hashes are compared with the second one.
  const compared = () => frames - (frames % every);
  const spent = () => (performance.now() - started - waited) / 1000;
  for (;;) {
    const before = performance.now();
    const status = ask(engine, "advance", budget);
    const now = performance.now();
    if (now - before < 10) budget = Math.min(2 * budget, 2 ** 31);
    else if (now - before > 40) budget = Math.max(1, budget >> 1);
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
