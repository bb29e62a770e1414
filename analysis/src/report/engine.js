// A worker with the engine; what it answers, and why it ends.
self.kinetoscopeWorker = (show, stop) => {
  const source = URL.createObjectURL(new Blob([document.querySelector("script.engine-worker").textContent], { type: "text/javascript" }));
  const worker = new Worker(source);
  URL.revokeObjectURL(source);
  worker.onmessage = show;
  worker.onerror = (event) => stop(`the engine cannot be started (${event.message ?? "the browser allows no worker"})`);
  return worker;
};

// Why no engine can run here; empty where one can.
self.kinetoscopeLack = !self.kinetoscopeEngine
  ? "The file kinetoscope-engine.js is not next to this page: copy it from the folder of the results, or write the report with --single-file."
  : !self.WebAssembly || !self.DecompressionStream ? "This browser has no WebAssembly or cannot unpack gzip: a newer one can run the engine." : "";
