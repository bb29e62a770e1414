// A worker with the engine; what it answers, and why it ends. A module is compiled once, and later workers of the page receive it.
self.kinetoscopeCompiled = {};
self.kinetoscopeWorker = (show, stop) => {
  const source = URL.createObjectURL(new Blob([document.querySelector("script.engine-worker").textContent], { type: "text/javascript" }));
  const worker = new Worker(source);
  URL.revokeObjectURL(source);
  const module = self.kinetoscopeEngine, { module: hash } = document.querySelector("[data-module]").dataset, known = self.kinetoscopeCompiled;
  worker.onmessage = (event) => (event.data.compiled ? (self.kinetoscopeCompiled = { module, hash, ...event.data }) : show(event));
  worker.onerror = (event) => stop(`the engine cannot be started (${event.message ?? "the browser allows no worker"})`);
  worker.postMessage(known.module === module && known.hash === hash ? { compiled: known.compiled } : { module, hash });
  return worker;
};

// Why no engine can run here; empty where one can.
self.kinetoscopeLack = !self.kinetoscopeEngine
  ? "The file kinetoscope-engine.js is missing next to this page, or damaged: copy it from the folder of the results, or write the report with --single-file."
  : !self.WebAssembly || !self.DecompressionStream ? "This browser has no WebAssembly or cannot unpack gzip: a newer one can run the engine." : "";
