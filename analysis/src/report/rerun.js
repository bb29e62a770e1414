// Change and rerun: the engine runs a changed manifest in a worker. Its frames and numbers are shown apart from those of the recording. The play page has no
// recording: its manifest is that of its address, or one of those that it offers.
{
  const box = document.querySelector(".rerun"), find = (place) => box.querySelector(place);
  const { runs, keys: known } = JSON.parse(find("script").textContent);
  const [menu, fields, text, status, canvas, table, plots] = ["select", ".keys", "textarea", "[role=status]", "canvas", "table", ".plots"].map(find);
  const [button, reset, save, copy, keep] = box.querySelectorAll("button");
  const isPlay = "play" in box.dataset;
  // Longest run, s; longest manifest, bytes; longest address that is offered, characters; most numbers of a table; most charts and keys.
  const MOST_S = 60, MOST_BYTES = 256 << 10, MOST_ADDRESS = 8192, MOST_ROWS = 12, MOST_CHARTS = 2, MOST_KEYS = 8;
  // Places of a slider, and the largest end of a range that it shows whole.
  const PLACES = 200, LARGEST_END = 10;
  // Up to so many particles without a radius leave a path.
  const MOST_WITH_PATH = 20;
  let worker, run, view, isRunning, path, hasPath, awaited, timer, place = "", more = "", discs = [], drawn = [], before = [], sent = "", turn = 0;

  const say = (words, quality = "") => ([status.textContent, status.className] = [words.slice(0, 9000), quality]);

  // The values of a text, by table and key. Each line is read once: a text from a link may be hostile.
  const valuesOf = (words) => {
    const found = new Map();
    let table = "", tables = 0;
    for (const line of words.split("\n").map((line) => line.trim())) {
      const at = line.indexOf("=");
      if (line[0] === "[" && !line.endsWith(",")) table = line.startsWith("[[") ? `${line} ${(tables += 1)}` : line;
      else if (line[0] !== "#" && at > 0) found.set(`${table} ${line.slice(0, at).trim()}`, line.slice(at + 1).split(" #")[0].trim());
    }
    return found;
  };

  // What a reader knows of a key of the model: its words, the ends of its range, and whether it is a whole number.
  const wordsOf = (key) => {
    const keys = known[/^\[model\.(\w+)\]/m.exec(text.value)?.[1]] ?? {};
    return Object.hasOwn(keys, key) ? keys[key] : [key, null, null];
  };

  // Whether two values are the same text or number.
  const isSame = (one, other) => one === other || (Boolean(one && other) && Number(one) === Number(other));

  // What differs from the recorded run.
  const changes = () => {
    const [before, now] = [valuesOf(run.manifest), valuesOf(text.value)], key = (place) => wordsOf(place.split(" ").pop())[0];
    return [...[...now].filter(([place, value]) => !isSame(before.get(place), value)).map(([place, value]) => `${key(place)} ${before.get(place) ?? "(none)"} → ${value}`),
      ...[...before].filter(([place]) => !now.has(place)).map(([place, value]) => `${key(place)} ${value} → (none)`)];
  };

  // Where the lines of the model's table begin and end in a text.
  const tableOf = (words) => {
    const head = /^\[model\.\w+\].*$/m.exec(words);
    if (!head) return [0, 0];
    const start = head.index + head[0].length, length = words.slice(start).search(/^\[/m);
    return [start, length < 0 ? words.length : start + length];
  };

  // Where the value of a key of this table begins and ends in the text.
  const spotOf = (key) => {
    const [from, to] = tableOf(text.value), head = new RegExp(`^${key}[ \\t]*=[ \\t]*`, "m").exec(text.value.slice(from, to));
    if (!head) return [0, 0];
    const start = from + head.index + head[0].length, rest = text.value.slice(start, to);
    return [start, start + rest.slice(0, rest.search(/[#\n]|$/)).trimEnd().length];
  };

  // The numeric keys of the model's table in a text, those that differ between the recorded runs first. One integrator reads the tolerance.
  const keysOf = (words, swept = []) => {
    const lines = words.slice(...tableOf(words)), isRead = (key) => key !== "tolerance" || lines.includes("dop853");
    return [...lines.matchAll(/^(\w+)[ \t]*=[ \t]*[-+]?[.\d]\S*[ \t]*(#.*)?$/gm)].map(([, key]) => key).filter(isRead)
      .sort((one, other) => swept.includes(other) - swept.includes(one)).slice(0, MOST_KEYS);
  };

  // The value at a place of a slider, between 0 and 1: over the whole range of a fraction, else up to ten times the value, which is in the middle.
  const valueAt = (low, high, value) => {
    if (low !== null && high !== null && high <= LARGEST_END && low >= 0.001 * high - 1e-9) return (at) => Math.max(low, high * at);
    if (value === 0 && low === 0) return (at) => at;
    const least = Math.max(low ?? 0, value / 10), most = Math.min(high ?? Infinity, 10 * value);
    return least > 0 && most > least && ((at) => (at === 0.5 && most / value === value / least ? value : least * (most / least) ** at));
  };

  function field(key) {
    const [name, low, high, isWhole] = wordsOf(key);
    const group = fields.appendChild(document.createElement("div")), label = group.appendChild(document.createElement("label"));
    label.textContent = `${name} `;
    const input = label.appendChild(document.createElement("input"));
    Object.assign(input, { type: "number", step: "any", value: text.value.slice(...spotOf(key)).replaceAll("_", ""), autocomplete: "off" });
    // A number that is being typed is empty at times: its line stays.
    const write = () => {
      const [start, stop] = spotOf(key);
      if (start) text.value = text.value.slice(0, start) + input.value + text.value.slice(stop);
      aged();
    };
    let scale = valueAt(low, high, Number(input.value));
    if (!scale) return (input.oninput = write);
    const slider = group.appendChild(document.createElement("input"));
    Object.assign(slider, { type: "range", max: PLACES, autocomplete: "off", ariaLabel: name });
    const follow = () => {
      const value = Number(input.value);
      // A value outside of the slider has a range of its own.
      if (value < scale(0) || value > scale(1)) scale = valueAt(low, high, value) || scale;
      let at = 0;
      while (at < PLACES && scale(at / PLACES) < value) at += 1;
      Object.assign(slider, { value: at, ariaValueText: input.value });
    };
    input.oninput = () => (write(), follow());
    slider.oninput = () => {
      const value = scale(slider.value / PLACES), short = Number(value.toPrecision(3));
      input.value = slider.ariaValueText = isWhole ? Math.max(low ?? 0, Math.round(short)) : short;
      write();
    };
    // A slider that is let go shows what it has changed.
    slider.onchange = () => {
      if (button.disabled) return;
      if (isRunning) end("");
      button.click();
    };
    follow();
  }

  function refill(swept) {
    fields.textContent = "";
    keysOf(text.value, swept).forEach(field);
  }

  function choose(index) {
    run = runs[index];
    before = [];
    restore();
  }

  const restore = () => edit(run.manifest, run.swept);

  // Results belong to the text of their run.
  function clear(words) {
    if (isRunning) end("stopped");
    table.hidden = canvas.hidden = keep.hidden = find(".mark").hidden = true;
    plot([]);
    if (words !== undefined) say(words);
  }

  const aged = () => !isRunning && !keep.hidden && text.value !== sent && say("The results are those of the text before this change: press Run.");

  function edit(manifest, swept) {
    clear(run.hint ?? "");
    text.value = manifest;
    if (isPlay) find(".asked").textContent = (/^question[ \t]*=[ \t]*"([^"\n]*)"/m.exec(manifest)?.[1] ?? "").slice(0, 300);
    refill(swept);
    button.disabled = !manifest || Boolean(self.kinetoscopeLack);
  }

  // The text that a link contains. A damaged or a forged one may unpack to more than the memory holds.
  async function unpacked(letters) {
    const ending = "ask its author for the file of the manifest";
    if (letters.length > 2 * MOST_BYTES) throw new Error(`the link is longer than one of a manifest of 256 kB; ${ending}`);
    let size = 0;
    const parts = [];
    try {
      const packed = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
      const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
      for (let part = await reader.read(); !part.done && size <= MOST_BYTES; part = await reader.read()) {
        size += part.value.length;
        parts.push(part.value);
      }
      if (size <= MOST_BYTES) return new TextDecoder("utf-8", { fatal: true }).decode(await new Blob(parts).arrayBuffer());
      reader.cancel();
    } catch {
      throw new Error(`the link is damaged; ${ending}`);
    }
    throw new Error(`the manifest of the link is longer than 256 kB; ${ending}`);
  }

  async function follow() {
    const letters = /^#manifest=(.*)$/s.exec(location.hash || box.dataset.auto)?.[1];
    if (letters === undefined) return;
    // Not the manifest before it.
    button.disabled = true;
    try {
      const manifest = await unpacked(letters);
      if (isPlay) run = { manifest };
      edit(manifest);
      if (isPlay && menu) menu.selectedIndex = -1;
      if (location.hash) say("The manifest of the link: read it, change it, run it.");
    } catch (error) {
      edit(isPlay ? "" : run.manifest, run.swept);
      say(error.message, "bad");
    }
    box.open = true;
  }

  async function link() {
    const stream = new Blob([text.value]).stream().pipeThrough(new CompressionStream("deflate"));
    const packed = Array.from(new Uint8Array(await new Response(stream).arrayBuffer()), (byte) => String.fromCharCode(byte)).join("");
    return `${new URL(box.dataset.page, location)}`.split("#")[0] + "#manifest=" + btoa(packed).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  }

  copy.onclick = async () => {
    const address = await link();
    if (address.length > MOST_ADDRESS) return say(`the link would have ${address.length} characters, more than ${MOST_ADDRESS}: download the manifest`, "bad");
    await navigator.clipboard.writeText(address).then(() => say("The link is copied."), () => say(`This browser does not copy: ${address}`));
  };

  function stop(words, quality) {
    isRunning = false;
    status.ariaBusy = "false";
    clearTimeout(timer);
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
    const at = ([px, py]) => [size / 2 + scale * (px - (view[0] + view[2]) / 2), size / 2 - scale * (py - (view[1] + view[3]) / 2)];
    paint.clearRect(0, 0, size, size);
    paint.fillStyle = "#8a8f98";
    // Thousands of small squares take a fraction of the time of as many circles.
    for (const [px, py] of path.map(at)) paint.fillRect(px - 1, py - 1, 2, 2);
    paint.fillStyle = "#e8a33d";
    for (const disc of discs) {
      const [px, py] = at(disc), r = max(hasPath ? 5 : 1.5, scale * disc[2]);
      if (r < 2) {
        paint.fillRect(px - r, py - r, 2 * r, 2 * r);
        continue;
      }
      paint.beginPath();
      paint.arc(px, py, r, 0, 7);
      paint.fill();
    }
  }

  function tell(metrics) {
    const body = find("tbody"), heads = [...table.rows[0].cells].map((cell) => cell.textContent);
    body.textContent = "";
    for (const shown of run.numbers ?? metrics.filter(({ reason }) => !reason).sort((a, b) => b.main - a.main).slice(0, MOST_ROWS)) {
      const now = metrics.find(({ name }) => name === shown.name);
      const row = body.insertRow(), theory = now?.theory ?? null;
      const measured = ({ value, standard_error: error }) => number(value, error);
      const cells = [shown.label + (shown.unit && shown.unit !== "1" ? ` (${shown.unit})` : ""), ...(run.numbers ? [measured(shown)] : []),
        now && !now.reason ? measured(now) : now?.reason ?? "not measured in this run", theory !== null ? number(theory, now.accuracy) : now?.out_of_range ? "its law does not apply" : ""];
      for (const [index, words] of cells.entries()) {
        const cell = row.insertCell();
        cell.textContent = words.slice(0, 300);
        if (words) cell.dataset.label = index ? heads[index] : "";
      }
    }
    table.hidden = !body.rows.length;
  }

  // The curves with which a chart is compared: those of the recorded run in the page, or else those of the run before in this page.
  function pastOf(stem, { x, y }) {
    const hasAxes = ({ data }) => data.x.label === x.label && data.y.label === y.label;
    const isMeasured = ({ style }) => style !== "theory" && style !== "fit";
    const isRecorded = (curve) => isMeasured(curve) && run.file && curve.run?.file === run.file;
    const index = charts.findIndex((each) => each.figure.id.startsWith(`plot-${stem}`) && hasAxes(each) && each.data.curves.some(isRecorded));
    if (index >= 0) return [index, charts[index].data.curves.filter(isRecorded), "recorded run"];
    const last = before.find(([name, data]) => name === stem && hasAxes({ data }));
    return [Infinity, last ? last[1].curves.filter(isMeasured) : [], "run before"];
  }

  // Curves of the past as one, which is gray; an area has its upper edge.
  function joined(past, name) {
    const of = (column) => past.flatMap((curve) => [...curve[column], null]), style = past.every((curve) => curve.style === "data") ? "data" : "line";
    return past.length ? [{ name, style, color: -1, x: of("x"), y: of("y"), e: [], run: null }] : [];
  }

  function drawChart([data, , past, name]) {
    const full = data.curves.map((curve) => ({ ...curve, name: curve.name || "this run", x: typeof curve.x === "number" ? data.curves[curve.x].x : curve.x }));
    const own = full.slice(0, MOST_CURVES), [areas, others] = [true, false].map((isArea) => own.filter(({ style }) => (style === "area") === isArea));
    const remark = full.length > MOST_CURVES ? `the first ${MOST_CURVES} of ${full.length} curves` : data.remark;
    return chart(plots.appendChild(document.createElement("figure")), { ...data, remark, time: false, curves: [...areas, ...joined(past, name), ...others] });
  }

  // The charts of the run, in the order of the page, each in a task of its own.
  function plot(all) {
    drawn.forEach((remove) => remove());
    plots.textContent = "";
    drawn = [];
    const own = (turn += 1);
    const found = all.map(([stem, data]) => [data, ...pastOf(stem, data)]).sort((one, other) => one[1] - other[1] || 0).slice(0, MOST_CHARTS);
    found.forEach((each, index) => setTimeout(() => own === turn && drawn.push(drawChart(each)), 20 * index));
    if (all.length) before = all;
  }

  function show({ data }) {
    if (data.recording) return download(data.recording, "changed.mcap");
    // An engine that has stopped cannot run again.
    if (data.failed) {
      end(data.failed);
      return start();
    }
    if (!isRunning) return;
    if (data.state) {
      canvas.hidden = false;
      place = ` at frame ${data.frame} of ${data.of}`;
      take(data);
      more = data.planned > 1 ? `; the text plans ${data.planned} runs, of which only the first is run` : "";
      const few = data.rows > discs.length ? `; ${discs.length} of ${data.rows} particles are drawn` : "";
      say(`frame ${data.frame} of ${data.of}${few}${more}`);
    }
    if (data.metrics) {
      tell(data.metrics);
      plot(data.charts);
      keep.hidden = false;
      const words = `${data.fault ? `the run fails: ${data.fault}` : "the run is complete"} (${data.frames} frames, ${data.seconds.toFixed(1)} s)${more}${table.hidden ? "; what it records gives no numbers" : ""}`;
      stop(words, data.fault ? "bad" : "good");
      aged();
    }
  }

  function start() {
    try {
      worker ??= self.kinetoscopeWorker(show, end);
    } catch (error) {
      end(`the engine cannot be started (${error.message})`);
    }
  }

  button.onclick = () => {
    if (isRunning) return end("stopped by you");
    start();
    if (!worker) return;
    const changed = changes();
    find(".mark").hidden = isPlay;
    find(".mark strong").hidden = !changed.length;
    find(".changes").textContent = changed.length ? changed.slice(0, 20).join("; ") : "Nothing is changed: the values are those of the recorded run.";
    isRunning = true;
    status.ariaBusy = "true";
    [view, path] = [undefined, []];
    table.hidden = canvas.hidden = keep.hidden = true;
    plot([]);
    button.textContent = "Stop";
    say("starting");
    place = "";
    timer = setTimeout(() => end(`ended after ${MOST_S} s${place}: shorten the run, or download the manifest and run it with the program`), 1000 * MOST_S);
    sent = text.value;
    worker.postMessage({ manifest: sent });
  };
  reset.onclick = restore;
  text.oninput = () => {
    button.disabled = Boolean(self.kinetoscopeLack);
    refill(run.swept);
    aged();
  };
  function download(data, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([data]));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
  save.onclick = () => download(text.value, "changed.toml");
  keep.onclick = () => worker?.postMessage({ recording: true });
  if (menu) menu.onchange = () => choose(menu.selectedIndex);
  choose(0);
  // The engine is ready when the first number is changed.
  box.ontoggle = () => box.open && start();
  box.hidden = !isPlay && Boolean(self.kinetoscopeLack);
  if (self.kinetoscopeLack) {
    button.disabled = true;
    say(self.kinetoscopeLack, "bad");
  }
  find(".setup details").open = isPlay && innerWidth > 860;
  addEventListener("hashchange", follow);
  // A page with a simulation of its own starts it.
  follow().then(() => !location.hash && box.dataset.auto && !self.kinetoscopeLack && !matchMedia("(prefers-reduced-motion: reduce)").matches && button.click());
}
