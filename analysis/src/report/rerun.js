// Change and rerun: the engine runs a changed manifest in a worker. Its frames and numbers are shown apart from those of the recording.
{
  const box = document.querySelector(".rerun"), find = (place) => box.querySelector(place);
  const runs = JSON.parse(find("script").textContent);
  const [menu, fields, text, status, canvas, table] = ["select", ".keys", "textarea", "[role=status]", "canvas", "table"].map(find);
  const [button, reset, save] = box.querySelectorAll("button");
  // Up to so many particles without a radius leave a path.
  const MOST_WITH_PATH = 20;
  let worker, run, view, isRunning, path, hasPath, awaited, discs = [];

  const say = (words, quality = "") => ([status.textContent, status.className] = [words.slice(0, 4000), quality]);

  // The lines with another value than in the recorded run.
  const changes = () => {
    const of = (lines) => new Map(lines.split("\n").map((line) => line.split(/ = (.*)/)).filter(([, value]) => value !== undefined));
    const before = of(run.manifest);
    return [...of(text.value)].filter(([key, value]) => before.get(key) !== value).map(([key, value]) => `${key} ${before.get(key) ?? "(none)"} → ${value}`);
  };

  const lineOf = (key) => new RegExp(`^${key} = (.*)$`, "m");

  function field([key, name]) {
    const label = fields.appendChild(document.createElement("label"));
    label.textContent = `${name} `;
    const input = label.appendChild(document.createElement("input"));
    Object.assign(input, { type: "number", step: "any", value: lineOf(key).exec(text.value)[1], autocomplete: "off" });
    input.oninput = () => (text.value = text.value.replace(lineOf(key), `${key} = ${input.value}`));
  }

  function choose(index) {
    run = runs[index];
    text.value = run.manifest;
    fields.textContent = "";
    run.keys.forEach(field);
  }

  function stop(words, quality) {
    isRunning = false;
    button.textContent = "Run";
    if (words) say(words, quality);
  }

  function end(words) {
    worker?.terminate();
    worker = undefined;
    stop(words, "bad");
  }

  // The particles of a frame, in the smallest square around all frames so far.
  function take({ columns, state }) {
    const width = columns.length, [x, y, radius] = ["x", "y", "radius"].map((name) => columns.indexOf(name));
    discs = [];
    for (let at = 0; at < state.length; at += width) discs.push([state[at + x], state[at + y], radius < 0 ? 0 : state[at + radius]]);
    for (const [px, py] of discs.filter((disc) => disc.every(Number.isFinite))) {
      view = view ? [min(view[0], px), min(view[1], py), max(view[2], px), max(view[3], py)] : [px, py, px, py];
    }
    hasPath = radius < 0 && discs.length <= MOST_WITH_PATH;
    if (hasPath) path.push(...discs);
    if (!awaited) awaited = requestAnimationFrame(draw);
  }

  function draw() {
    awaited = undefined;
    if (!view) return;
    const size = canvas.width, scale = size / (1.1 * (max(view[2] - view[0], view[3] - view[1]) || 1));
    const paint = canvas.getContext("2d");
    const fill = (color, least) => ([px, py, r]) => {
      paint.fillStyle = color;
      paint.beginPath();
      paint.arc(size / 2 + scale * (px - (view[0] + view[2]) / 2), size / 2 - scale * (py - (view[1] + view[3]) / 2), max(least, scale * r), 0, 7);
      paint.fill();
    };
    paint.clearRect(0, 0, size, size);
    path.forEach(fill("#8a8f98", 1));
    discs.forEach(fill("#e8a33d", hasPath ? 5 : 1.5));
  }

  function tell(metrics) {
    const body = find("tbody");
    body.textContent = "";
    for (const recorded of run.numbers) {
      const now = metrics.find(({ name }) => name === recorded.name);
      const row = body.insertRow(), theory = now?.theory ?? null;
      const measured = ({ value, standard_error: error }) => number(value, error);
      const cells = [recorded.label + (recorded.unit && recorded.unit !== "1" ? ` (${recorded.unit})` : ""), measured(recorded),
        now && !now.reason ? measured(now) : now?.reason ?? "no value", theory === null ? "" : number(theory)];
      for (const [index, words] of cells.entries()) {
        const cell = row.insertCell();
        cell.textContent = words.slice(0, 300);
        if (words) cell.dataset.label = ["", "recorded", "changed by you", "theory"][index];
      }
    }
    table.hidden = false;
  }

  function show({ data }) {
    if (!isRunning) return;
    if (data.failed) return stop(data.failed, "bad");
    if (data.state) {
      canvas.hidden = false;
      take(data);
      const more = data.planned > 1 ? `; the text plans ${data.planned} runs, of which only the first is run` : "";
      say(`frame ${data.frame} of ${data.of}${more}`);
    }
    if (data.metrics) {
      tell(data.metrics);
      const words = `${data.fault ? `the changed run fails: ${data.fault}` : "the changed run is complete"} (${data.frames} frames, ${data.seconds.toFixed(1)} s)`;
      stop(words, data.fault ? "bad" : "good");
    }
  }

  function start() {
    try {
      if (!worker) {
        worker = self.kinetoscopeWorker(show, end);
        worker.postMessage({ module: self.kinetoscopeEngine, hash: document.querySelector(".engine").dataset.module });
      }
    } catch (error) {
      end(`the engine cannot be started (${error.message})`);
    }
  }

  button.onclick = () => {
    if (isRunning) return end("stopped by you");
    start();
    if (!worker) return;
    const changed = changes();
    find(".mark").hidden = false;
    find(".changes").textContent = changed.length ? changed.slice(0, 20).join("; ") : "nothing is changed yet: this is the manifest of the recording";
    isRunning = true;
    [view, path] = [undefined, []];
    table.hidden = canvas.hidden = true;
    button.textContent = "Stop";
    say("starting");
    worker.postMessage({ manifest: text.value });
  };
  reset.onclick = () => choose(menu ? menu.selectedIndex : 0);
  save.onclick = () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text.value], { type: "text/plain" }));
    link.download = "changed.toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  if (menu) menu.onchange = () => choose(menu.selectedIndex);
  choose(0);
  // The engine is ready when the first number is changed.
  box.ontoggle = () => box.open && start();
  box.hidden = !self.kinetoscopeEngine || !self.WebAssembly || !self.DecompressionStream;
}
