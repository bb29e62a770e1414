// The script of report.html: replays, and plots that respond to the pointer. Without it, plots are images.
"use strict";
const section = document.querySelector(".replay");
const films = [...document.querySelectorAll("script.film")], decodedFilms = new Map();

// The numbers of a film, in the layout of analysis/src/replay/encoding.rs: raw DEFLATE in base64.
async function decoded(film, text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const { frames, particles, wallPoints } = film;
  const times = new Float64Array(bytes.buffer, 0, frames), numbers = new Uint32Array(bytes.buffer, 8 * frames, frames);
  let at = 12 * frames;
  const series = (count, width, order) => {
    const values = new Uint16Array(count * width), length = values.length;
    for (let i = 0; i < length; i++) {
      const zigzag = bytes[at + i] | (bytes[at + length + i] << 8);
      values[i] = (zigzag >> 1) ^ -(zigzag & 1);
    }
    at += 2 * length;
    for (let pass = 0; pass < order; pass++) for (let i = width; i < length; i++) values[i] += values[i - width];
    return values;
  };
  const radii = series(film.growing ? frames : 1, particles, 1);
  const [xs, ys] = film.orders.map((order) => series(frames, particles, order));
  const speeds = bytes.slice(at, at += frames * particles);
  for (let i = particles; i < speeds.length; i++) speeds[i] += speeds[i - particles];
  const wallFrames = film.movingWalls ? frames : 1;
  const walls = [series(wallFrames, wallPoints, 2), series(wallFrames, wallPoints, 2)];
  const styles = series(wallFrames, wallPoints / 2, 1);
  const velocities = film.velocityStep ? [series(frames, particles, 1), series(frames, particles, 1)] : [];
  return { times, numbers, radii, xs, ys, speeds, walls, styles, velocities };
}

const ABSENT = 65535, ABSENT_SPEED = 255, STEPS = 64, OUTLINE_FROM_PX = 6, PAINTED_FROM = 1500, GROUND = "#101418";
const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

// Colors from rest to the top speed, then that of an unknown speed.
function palette(stops) {
  const colors = stops.map(rgb);
  const mixed = Array.from({ length: STEPS }, (_, step) => {
    const place = step / (STEPS - 1) * (colors.length - 1), low = Math.min(Math.floor(place), colors.length - 2);
    return colors[low].map((part, i) => Math.round(part + (place - low) * (colors[low + 1][i] - part)));
  });
  return [...mixed, [154, 154, 154]];
}

// Opaque pixels of each color over the ground, in quarters.
const shadesOf = (colors) => Uint32Array.from(colors.flatMap((color) => [0, 1, 2, 3, 4].map((quarters) => {
  const [r, g, b] = rgb(GROUND).map((part, i) => Math.round(part + quarters / 4 * (color[i] - part)));
  return (255 << 24 | b << 16 | g << 8 | r) >>> 0;
})));

const superscript = (number) => String(number).replace(/./g, (sign) => sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign]);
const exponentOf = (value) => value ? Math.floor(Math.log10(Math.abs(value) * (1 + 1e-12))) : 0;

// A number in the notation of the tables, with its standard error in the last digits.
function number(value, error, count = 6) {
  const exponent = exponentOf(Math.max(Math.abs(value), error || 0)), isPlain = exponent >= -3 && exponent <= 5;
  const unit = isPlain ? 1 : 10 ** exponent, scaled = value / unit;
  let text = String(Number(scaled.toPrecision(count)));
  if (error > 1e-9 * Math.abs(value)) {
    const decimals = clamp(1 - exponentOf(error / unit), 0, 20);
    text = `${scaled.toFixed(decimals)}(${Math.round(error / unit * 10 ** decimals)})`;
  }
  text = text.replace("-", "−");
  if (isPlain) return text;
  return (text === "1" ? "" : text + "·") + "10" + superscript(exponent);
}

const clamp = (value, low, high) => Math.max(low, Math.min(high, value));
const withUnit = (text, unit) => unit ? `${text} ${unit}` : text;

// A player; with a leader, it shows the leader's time.
function player(part, leader) {
  const find = (selector) => part.querySelector(selector);
  const canvas = find("canvas"), context = canvas.getContext("2d");
  const play = find(".play"), scrub = find(".scrub"), clock = find(".clock");
  const speedMenu = find(".speed"), row = find(".row"), menu = find(".runs");
  let film, data, colors, steps, file, wanted, frame = 0, isPlaying = false, due = 0, scale = 1, left = 0, top = 0;

  const shown = (value, count, unit) => withUnit(number(value, 0, count), film.units[unit]);
  const isThere = (at) => data.xs[at] !== ABSENT;
  const xOf = (stored) => film.origin[0] + stored * film.step;
  const yOf = (stored) => film.origin[1] + stored * film.step;
  // Pixels of positions, and of stored coordinates.
  const across = (x) => left + (x - film.view[0]) * scale;
  const down = (y) => top + (film.view[3] - y) * scale;
  const pixel = (x, y) => [across(x), down(y)];
  const px = (stored) => across(xOf(stored));
  const py = (stored) => down(yOf(stored));
  const radiusOf = (i) => data.radii[(film.growing ? frame * film.particles : 0) + i] * film.radiusStep;
  // Few particles are drawn larger than many, so that points are visible.
  const smallestPx = () => (film.particles > 2000 ? 1.5 : film.particles > 50 ? 2.5 : 4) * devicePixelRatio;
  const speedOf = (stored) => (stored / 254) ** 2 * film.speedMax;

  // At most the width of the page and three quarters of the window's height.
  function resize() {
    const width = canvas.parentElement.clientWidth;
    // What is not displayed has no width.
    if (!film || !width) return;
    const [x0, y0, x1, y1] = film.view, sides = [x1 - x0, y1 - y0];
    const [wide, high] = sides.map((side) => side + 0.04 * Math.max(...sides));
    const height = Math.max(160, Math.min(width * high / wide, 0.75 * innerHeight, 900));
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * devicePixelRatio);
    canvas.height = Math.round(height * devicePixelRatio);
    sheet = null;
    scale = Math.min(canvas.width / wide, canvas.height / high);
    [left, top] = [(canvas.width - sides[0] * scale) / 2, (canvas.height - sides[1] * scale) / 2];
    draw();
  }

  // A path of discs, given by their places and radii in pixels.
  function discs(all) {
    context.beginPath();
    for (const [x, y, radius] of all) {
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
  }

  // The lines of one style are one path.
  function drawWalls() {
    const count = film.wallPoints, base = film.movingWalls ? frame * count : 0, [xs, ys] = data.walls;
    context.lineCap = "round";
    film.lineStyles.forEach(([color, width], style) => {
      context.strokeStyle = color;
      context.lineWidth = Math.max(1, 0.6 * width) * devicePixelRatio;
      context.beginPath();
      for (let i = base; i < base + count; i += 2) {
        if (data.styles[i / 2] !== style || xs[i] === ABSENT || xs[i + 1] === ABSENT) continue;
        context.moveTo(px(xs[i]), py(ys[i]));
        context.lineTo(px(xs[i + 1]), py(ys[i + 1]));
      }
      context.stroke();
    });
    context.fillStyle = "#f0c83c";
    discs(film.bodies.map(([x, y, radius]) => [...pixel(x, y), Math.max(radius * scale, smallestPx())]));
    context.fill();
    context.fillStyle = "#c8c8c8";
    context.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const [at, text] of film.labels) context.fillText(text, ...pixel(...at));
  }

  function drawTrails() {
    const count = film.particles;
    context.strokeStyle = "#56b4e9";
    context.lineWidth = devicePixelRatio;
    for (let i = 0; i < Math.min(count, 8); i++) {
      context.beginPath();
      for (let at = i; at <= frame * count + i; at += count) {
        if (!isThere(at)) continue;
        const isJoined = at >= count && isThere(at - count);
        context[isJoined ? "lineTo" : "moveTo"](px(data.xs[at]), py(data.ys[at]));
      }
      context.stroke();
    }
  }

  // All discs of one color are one path; those that this leaves out were painted.
  function drawDiscs() {
    const count = film.particles, base = frame * count, smallest = smallestPx();
    const byColor = Array.from(colors, () => []), painted = count > PAINTED_FROM && paintDiscs(base, smallest);
    for (let i = 0; i < count; i++) {
      if (!isThere(base + i) || painted[i]) continue;
      const disc = [px(data.xs[base + i]), py(data.ys[base + i]), Math.max(radiusOf(i) * scale, smallest)];
      byColor[steps[data.speeds[base + i]]].push(disc);
    }
    byColor.forEach((all, color) => {
      context.fillStyle = colors[color];
      discs(all);
      context.fill();
    });
    context.strokeStyle = GROUND;
    context.lineWidth = 1;
    discs(byColor.flat().filter(([, , radius]) => radius >= OUTLINE_FROM_PX));
    context.stroke();
  }

  // Very many discs are painted pixel by pixel, in a quarter of the time of paths. Radius and place are rounded to quarters of a
  // pixel, so that few stamps remain: lists of offsets and of covered quarters.
  let sheet, stamps, pixels, shades;
  function stampOf(radius, across, down) {
    const reach = Math.ceil(radius / 4 + 1), isOutlined = radius >= 4 * OUTLINE_FROM_PX, stamp = [];
    for (let y = -reach; y <= reach; y++) for (let x = -reach; x <= reach; x++) {
      const beyond = Math.hypot(x + 0.5 - across / 4, y + 0.5 - down / 4) - radius / 4 + (isOutlined ? 0.5 : 0);
      const cover = Math.round(4 * clamp(0.5 - beyond, 0, 1));
      if (cover || (isOutlined && beyond < 1)) stamp.push(y * canvas.width + x, isOutlined || cover === 4 ? cover : cover - 8);
    }
    return Int32Array.from(stamp);
  }

  function paintDiscs(base, smallest) {
    const { width, height } = canvas, { xs, ys, speeds } = data;
    if (!sheet) {
      sheet = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
      stamps = [];
      pixels = sheet.createImageData(width, height);
    }
    const image = new Uint32Array(pixels.data.buffer);
    image.fill(0);
    const painted = new Uint8Array(film.particles);
    for (let i = 0; i < film.particles; i++) {
      if (!isThere(base + i)) continue;
      const x = Math.round(4 * px(xs[base + i])), y = Math.round(4 * py(ys[base + i]));
      const radius = Math.round(4 * Math.max(radiusOf(i) * scale, smallest)), reach = radius + 8;
      if (x < reach || y < reach || x > 4 * width - reach || y > 4 * height - reach) continue;
      painted[i] = 1;
      const stamp = stamps[(radius * 4 + (x & 3)) * 4 + (y & 3)] ||= stampOf(radius, x & 3, y & 3);
      const middle = (y >> 2) * width + (x >> 2), shade = 5 * steps[speeds[base + i]];
      // Edges do not darken discs that are painted already.
      for (let k = 0; k < stamp.length; k += 2) {
        const at = middle + stamp[k], cover = stamp[k + 1];
        if (cover >= 0) image[at] = shades[shade + cover];
        else if (!image[at]) image[at] = shades[shade + cover + 8];
      }
    }
    sheet.putImageData(pixels, 0, 0);
    context.drawImage(sheet.canvas, 0, 0);
    return painted;
  }

  function draw() {
    if (!data) return;
    context.fillStyle = GROUND;
    context.fillRect(0, 0, canvas.width, canvas.height);
    if (film.trails) drawTrails();
    drawWalls();
    drawDiscs();
    const time = `t = ${shown(data.times[frame], 6, 2)}`;
    clock.textContent = `${time} · frame ${data.numbers[frame]}`;
    scrub.value = frame;
    scrub.setAttribute("aria-valuetext", time);
    showRow();
    if (!leader) document.dispatchEvent(new CustomEvent("replaytime"));
  }

  function show(index) {
    frame = clamp(Math.round(index), 0, film.frames - 1);
    draw();
  }

  // The row of the particle under the pointer.
  let pointer = null;
  function showRow() {
    if (!data) return;
    const base = frame * film.particles;
    let nearest = -1, least = Infinity;
    if (pointer) {
      for (let i = 0; i < film.particles; i++) {
        if (!isThere(base + i)) continue;
        const distance = Math.hypot(px(data.xs[base + i]) - pointer[0], py(data.ys[base + i]) - pointer[1]);
        const beyond = distance - Math.max(radiusOf(i) * scale, 8 * devicePixelRatio);
        if (beyond <= 0 && distance < least) [nearest, least] = [i, distance];
      }
    }
    if (nearest < 0) return void (row.textContent = "Point at a particle for its values.");
    const at = base + nearest, radius = radiusOf(nearest), speed = data.speeds[at];
    const parts = [`particle ${nearest * film.every}`, `x = ${shown(xOf(data.xs[at]), 4, 0)}`, `y = ${shown(yOf(data.ys[at]), 4, 0)}`];
    if (speed !== ABSENT_SPEED) parts.push(`speed ≈ ${shown(speedOf(speed), 2, 1)}`);
    data.velocities.forEach((values, axis) => {
      if (values[at] === ABSENT) return;
      const value = values[at] * film.velocityStep - film.velocityTop;
      // As many digits as the stored steps give.
      const count = clamp(Math.floor(Math.log10(Math.abs(value) / film.velocityStep)), 1, 4);
      parts.push(`${["vx", "vy"][axis]} ≈ ${shown(value, count, 1)}`);
    });
    if (radius) parts.push(`radius = ${shown(radius, 4, 0)}`);
    row.textContent = parts.join(" · ");
  }

  function setPlaying(value) {
    isPlaying = value && film.frames > 1;
    play.textContent = isPlaying ? "❚❚" : "▶";
    play.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    if (!isPlaying) return;
    if (frame === film.frames - 1) show(0);
    due = 0;
    requestAnimationFrame(advance);
  }

  function advance(now) {
    if (!isPlaying) return;
    due ||= now;
    const interval = 1000 / (film.fps * speedMenu.value);
    const passed = Math.floor((now - due) / interval);
    if (passed > 0) {
      due += passed * interval;
      show(frame + passed);
      if (frame === film.frames - 1) return setPlaying(false);
    }
    requestAnimationFrame(advance);
  }

  async function select(index) {
    if (film) setPlaying(false);
    const source = films[index];
    wanted = source.dataset.file;
    if (menu) menu.selectedIndex = index;
    find(".note").textContent = source.dataset.note;
    const isDrawn = Boolean(source.dataset.film);
    find(".stage").hidden = !isDrawn;
    if (!isDrawn) { film = data = file = undefined; return; }
    const chosen = JSON.parse(source.dataset.film);
    if (!decodedFilms.has(index)) decodedFilms.set(index, decoded(chosen, source.textContent));
    const numbers = await decodedFilms.get(index);
    // Another run may have been selected in the meantime.
    if (wanted !== source.dataset.file) return;
    [data, film, file] = [numbers, chosen, wanted];
    const parts = palette(film.colors);
    colors = parts.map((color) => `rgb(${color.join()})`);
    shades = shadesOf(parts);
    steps = Array.from({ length: 256 }, (_, stored) => {
      const fraction = film.speedTop > 0 ? speedOf(stored) / film.speedTop : 0;
      return stored === ABSENT_SPEED ? STEPS : Math.min(STEPS - 1, Math.floor(fraction * STEPS));
    });
    find(".bar").style.background = `linear-gradient(to right, ${film.colors.join()})`;
    find(".scale").hidden = !(film.speedTop > 0);
    find(".top").textContent = withUnit(film.speedTopText, film.units[1]);
    scrub.max = film.frames - 1;
    scrub.disabled = play.disabled = film.frames < 2;
    frame = 0;
    setPlaying(false);
    resize();
    follow();
  }

  function follow() {
    if (file && leader?.file) seek(leader.time, file);
  }

  // Shows the frame nearest to a time of a run; the latest time counts.
  async function seek(time, of) {
    const index = films.findIndex((source) => source.dataset.file === of);
    if (index < 0) return;
    seek.time = time;
    if (wanted !== of) await select(index);
    if (file !== of) return;
    setPlaying(false);
    const distances = data.times.map((each) => Math.abs(each - seek.time));
    show(distances.indexOf(distances.slice().sort()[0]));
  }

  play.addEventListener("click", () => setPlaying(!isPlaying));
  scrub.addEventListener("input", () => { setPlaying(false); show(scrub.value); });
  canvas.addEventListener("keydown", (event) => {
    // The film may not be decoded yet.
    if (!film) return;
    const step = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity }[event.key];
    if (step) { setPlaying(false); show(frame + step); }
    else if (event.key === " ") setPlaying(!isPlaying);
    else return;
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    const ratio = canvas.width / canvas.clientWidth;
    pointer = [event.offsetX * ratio, event.offsetY * ratio];
    showRow();
  });
  canvas.addEventListener("pointerleave", () => { pointer = null; showRow(); });
  menu?.addEventListener("change", () => select(menu.selectedIndex));
  addEventListener("resize", resize);
  document.addEventListener("replaytime", follow);

  // For plots and tests; positions are in the state's unit, from their pixels.
  return {
    ready: select(leader ? 1 : 0),
    select,
    show,
    seek,
    has: (of) => films.some((source) => source.dataset.file === of && source.dataset.film),
    get file() { return file; },
    get time() { return data ? data.times[frame] : NaN; },
    get frames() { return film.frames; },
    get numbers() { return data.numbers; },
    get view() { return film.view; },
    positions() {
      const found = [];
      for (let i = 0; i < film.particles; i++) {
        const at = frame * film.particles + i;
        if (!isThere(at)) continue;
        const [x, y] = [px(data.xs[at]), py(data.ys[at])];
        found.push([i * film.every, (x - left) / scale + film.view[0], film.view[3] - (y - top) / scale]);
      }
      return found;
    },
    // Pixel of a position in the state's unit.
    pixel,
  };
}

if (section) {
  section.hidden = false;
  const [first, second] = section.querySelectorAll(".player"), box = section.querySelector(".pair");
  if (typeof DecompressionStream === "undefined") {
    section.querySelector(".stage").hidden = true;
    section.querySelector(".note").textContent = "This browser cannot play the replay: it has no DecompressionStream.";
  } else {
    window.replay = player(first);
    // A second run next to the first one, with its clock.
    box?.addEventListener("change", () => {
      second.hidden = !box.checked;
      if (box.checked) replay.second ||= player(second, replay);
      dispatchEvent(new Event("resize"));
    });
  }
}

const COLORS = 7, MOST_CURVES = 14, REACH_PX = 60, TEXT_PX = 12, LEAST_DRAG_PX = 8, PRINT_WIDTH_PX = 350, ENTRY_PX = 24, LEAST_TICK_PX = 32, GROWTH = 30;
let isPrinted = false;

function set(target, attributes) {
  for (const [key, value] of Object.entries(attributes)) target.setAttribute(key, value);
}

function element(name, attributes, parent, text) {
  const isSvg = /^(svg|g|path|line|rect|text|tspan|circle|clipPath)$/.test(name);
  const made = isSvg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  set(made, attributes);
  if (text !== undefined) made.textContent = text;
  // Boltzmann's constant has a subscript.
  if (name === "text" && text?.endsWith("(k_B)")) {
    made.textContent = text.slice(0, -3);
    element("tspan", { dy: "0.25em", "font-size": "75%" }, made, "B");
    element("tspan", { dy: "-0.19em" }, made, ")");
  }
  if (parent) parent.append(made);
  return made;
}

// Text that does not fit is condensed.
function condense(text, room) {
  if (text.getComputedTextLength() > room) set(text, { textLength: room, lengthAdjust: "spacingAndGlyphs" });
}

const ruler = document.createElement("canvas").getContext("2d");
function widthOf(text, size) {
  ruler.font = `${size}px system-ui, sans-serif`;
  return ruler.measureText(text).width;
}

// Multiples of 1, 2 or 5 times a power of ten.
function evenTicks(low, high, count) {
  const rough = (high - low) / count, unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * unit).find((each) => each >= rough * (1 - 1e-9));
  const ticks = [];
  for (let index = Math.ceil(low / step); index * step <= high; index++) ticks.push(index * step);
  return { ticks, step };
}

// Ticks: places (logarithms on a logarithmic axis) and texts, and the power of ten of the caption.
function ticksOf(axis, isLog, low, high, count) {
  if (axis.words) {
    const shown = axis.words.map((text, at) => ({ at, text })).filter(({ at }) => at >= low && at <= high);
    const stride = Math.max(1, Math.ceil(shown.length / count));
    return { ticks: shown.filter((_, index) => index % stride === 0), exponent: 0 };
  }
  if (!isLog) {
    const size = Math.max(Math.abs(low), Math.abs(high));
    const exponent = size >= 1e-2 && size < 1e5 ? 0 : exponentOf(size);
    const { ticks, step } = evenTicks(low, high, count);
    const decimals = clamp(-exponentOf(step / 10 ** exponent), 0, 15);
    const text = (tick) => (tick / 10 ** exponent).toFixed(decimals).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
    return { ticks: ticks.map((tick) => ({ at: tick, text: text(tick) })), exponent };
  }
  const stride = Math.max(1, Math.ceil((high - low) / count)), mantissas = high - low < 3 ? [1, 2, 5] : [1];
  let places = [];
  for (let decade = Math.floor(low / stride) * stride; decade <= high; decade += stride)
    for (const mantissa of mantissas) places.push(decade + Math.log10(mantissa));
  places = places.filter((place) => place >= low && place <= high);
  const decades = places.filter((place) => Number.isInteger(place));
  if (places.length > 1.5 * count && decades.length > 2) places = decades;
  if (places.length < 3) places = evenTicks(10 ** low, 10 ** high, count).ticks.filter((tick) => tick > 0).map(Math.log10);
  return { ticks: places.map((at) => ({ at, text: number(10 ** at, 0, 4) })), exponent: 0 };
}

let charts = [], count = 0;

// A chart that responds to the pointer.
function chart(figure, data) {
  const { x: xAxis, y: yAxis, curves } = data, id = `plot-area-${count++}`;
  for (const curve of curves) if (typeof curve.x === "number") curve.x = curves[curve.x].x;
  const hidden = new Set();
  let isLogX = xAxis.log, isLogY = yAxis.log, zoom = null, view = null, at = null, drag = null;
  for (const old of figure.querySelectorAll(":scope > :not(script)")) old.remove();
  element("figcaption", {}, figure, data.title);
  const legend = element("div", { class: "legend" }, figure), tools = element("div", { class: "tools" }, figure);
  const sheet = element("svg", { class: "sheet", role: "img", tabindex: 0, "aria-label": data.title }, figure);
  const remark = element("p", { class: "remark" }, figure);
  const tip = element("div", { class: "tip", role: "status", hidden: "" }, figure);

  // Each area lies on the one before it.
  let below = null;
  for (const curve of curves.filter(({ style }) => style === "area")) {
    curve.below = below ? below.y : curve.x.map(() => 0);
    below = curve;
  }
  // Theory that is named after its curve shares the entry of that curve.
  const measured = (theory) => theory.style === "theory" && curves.find(({ name, color, style }) => style !== "theory" && name && color === theory.color && theory.name.startsWith(`${name}: `));
  // Lower end of a logarithmic axis of lines that grow: their first value, the precision of an error.
  function floorOf() {
    if (curves.some(({ style }) => style !== "line")) return -Infinity;
    const floors = curves.map(({ y }) => y.filter((value) => value > 0)).filter(({ length }) => length > 1).map(([first, ...rest]) => {
      const [least, greatest] = [Math.min(...rest), Math.max(...rest)];
      return greatest > GROWTH * first ? first : Math.min(least, first);
    });
    return floors.length ? Math.log10(Math.min(...floors)) : -Infinity;
  }
  // Colors repeat with another mark or dash.
  const strokeOf = (curve) => ({ class: `curve ${curve.style} round${Math.floor(curve.color / COLORS)}`, style: `stroke:var(--c${curve.color % COLORS});color:var(--c${curve.color % COLORS})` });
  const showable = (value, isLog) => Number.isFinite(value) && (!isLog || value > 0);
  const place = (value, isLog) => isLog ? Math.log10(value) : value;
  const shown = () => curves.filter((curve) => !hidden.has(curve));
  const hasLog = (of) => {
    const values = curves.flatMap(of).filter(Number.isFinite);
    return !data.equal && values.length > 1 && values.filter((value) => value > 0).length >= 0.9 * values.length;
  };

  // The range of the visible points with their error bars, and a margin.
  function range(of, isLog, isY) {
    let low = Infinity, high = -Infinity;
    for (const [values, errors] of (shown().length ? shown() : curves).map(of)) values.forEach((value, i) => {
      const error = errors[i] || 0, ends = value === null ? [] : [value - error, value, value + error];
      for (const end of ends.filter((end) => showable(end, isLog))) {
        low = Math.min(low, place(end, isLog));
        high = Math.max(high, place(end, isLog));
      }
    });
    if (low > high) [low, high] = [0, 1];
    if (isLog && isY) low = Math.min(high, Math.max(low, floorOf()));
    if (!isLog && isY && below) low = Math.min(low, 0);
    const size = Math.max(Math.abs(low), Math.abs(high));
    const missing = high - low > 1e-9 * size ? 0 : size ? 0.01 * size : 0.5, margin = 0.05 * (high - low + 2 * missing);
    return [low - missing - margin, high + missing + margin];
  }

  function ranges(shape) {
    if (zoom) return zoom;
    const x = range((curve) => [curve.x, []], isLogX), y = range((curve) => [curve.y, curve.e], isLogY, true);
    if (data.equal) {
      const extra = (y[1] - y[0]) * shape - (x[1] - x[0]);
      const [wider, by] = extra > 0 ? [x, extra / 2] : [y, -extra / shape / 2];
      wider[0] -= by;
      wider[1] += by;
    }
    return [x, y];
  }

  // Pixels of places on the axes, and of values.
  const acrossOf = (at) => view.left + (at - view.x[0]) / (view.x[1] - view.x[0]) * view.width;
  const downOf = (at) => view.top + (view.y[1] - at) / (view.y[1] - view.y[0]) * view.height;
  const px = (value) => acrossOf(place(value, isLogX));
  const py = (value) => downOf(place(value, isLogY));
  const isShowable = (curve, i) => showable(curve.x[i], isLogX) && showable(curve.y[i], isLogY);

  function drawCurve(curve, parent) {
    let path = "", isDown = false, bars = "";
    for (let i = 0; i < curve.x.length; i++) {
      if (!isShowable(curve, i)) { isDown = false; continue; }
      const [left, top] = [px(curve.x[i]), py(curve.y[i])].map((part) => clamp(part, -1e5, 1e5).toFixed(1));
      const isLevel = xAxis.words && curve.style === "theory";
      path += isLevel ? `M${left - 15} ${top}h30` : isDown && curve.style !== "data" ? `L${left} ${top}` : `M${left} ${top}h.01`;
      isDown = true;
      const error = curve.e[i];
      if (!(error > 0)) continue;
      const upper = py(curve.y[i] + error).toFixed(1), low = curve.y[i] - error;
      const lower = (showable(low, isLogY) ? py(low) : view.top + view.height).toFixed(1);
      bars += `M${left} ${upper}V${lower}M${left - 4} ${upper}h8M${left - 4} ${lower}h8`;
    }
    if (curve.below) for (let i = curve.x.length; i--;) path += `L${px(curve.x[i]).toFixed(1)} ${py(curve.below[i]).toFixed(1)}`;
    element("path", { ...strokeOf(curve), d: path }, parent);
    if (bars) element("path", { ...strokeOf(curve), class: "curve bars", d: bars }, parent);
  }

  function caption(axis, exponent, attributes, room) {
    const power = exponent ? `10${superscript(exponent)}` : "", unit = [power, axis.unit].filter(Boolean).join(" ");
    const text = unit ? `${axis.label} (${unit})` : axis.label;
    const size = clamp(13 * room / widthOf(text, 13), 11, 13);
    condense(element("text", { "text-anchor": "middle", style: `font-size:${size}px`, ...attributes }, sheet, text), room);
  }

  function draw() {
    const full = isPrinted ? PRINT_WIDTH_PX : clamp(figure.clientWidth, 240, 760);
    const height = data.equal ? Math.min(0.9 * full, 560) : clamp(0.58 * full, 260, 400);
    const top = 10, lines = xAxis.words ? 2 : 1, bottom = 32 + 14 * lines, right = 16 + endMargin(full, height - bottom);
    const [x, y] = ranges((full - 70) / (height - top - bottom));
    const rows = ticksOf(yAxis, isLogY, ...y, Math.max(2, (height - top - bottom) / 45));
    const left = 30 + Math.ceil(Math.max(LEAST_TICK_PX, ...rows.ticks.map(({ text }) => widthOf(text, TEXT_PX))));
    view = { x, y, left, top, width: full - left - right, height: height - top - bottom };
    let columns, amount = Math.max(2, lines * Math.floor(view.width / 70));
    // Words are in two lines by turns.
    const isCrowded = ({ ticks }) => ticks.slice(lines).some((tick, i) => acrossOf(tick.at) - acrossOf(ticks[i].at)
      < (widthOf(tick.text, TEXT_PX) + widthOf(ticks[i].text, TEXT_PX)) / 2 + 10);
    do columns = ticksOf(xAxis, isLogX, ...x, amount); while (isCrowded(columns) && --amount >= 1);
    // No point is left out silently.
    const lost = shown().filter(({ style }) => style === "data").flatMap((curve) => curve.x.filter((at, i) =>
      Number.isFinite(at) && Number.isFinite(curve.y[i]) && !isShowable(curve, i))).length;
    const leftOut = lost ? `${lost} ${lost > 1 ? "points" : "point"} at 0 or below: not on a logarithmic axis` : "";
    remark.textContent = [data.remark, leftOut].filter(Boolean).join("; ");
    remark.hidden = !remark.textContent;
    sheet.replaceChildren();
    sheet.setAttribute("viewBox", `0 0 ${full} ${height}`);
    const box = { x: left, y: top, width: view.width, height: view.height }, foot = top + view.height;
    element("rect", box, element("clipPath", { id }, sheet));
    for (const [i, { at, text }] of columns.ticks.entries()) {
      const across = acrossOf(at), half = widthOf(text, TEXT_PX) / 2;
      element("line", { class: "grid", x1: across, x2: across, y1: top, y2: foot }, sheet);
      element("text", { x: Math.min(across, full - half - 1), y: foot + 16 + 14 * (i % lines), "text-anchor": "middle" }, sheet, text);
    }
    for (const { at, text } of rows.ticks) {
      const down = downOf(at);
      element("line", { class: "grid", x1: left, x2: left + view.width, y1: down, y2: down }, sheet);
      element("text", { x: left - 6, y: clamp(down + 4, 12, foot), "text-anchor": "end" }, sheet, text);
    }
    const area = element("g", { "clip-path": `url(#${id})` }, sheet);
    for (const curve of shown()) drawCurve(curve, area);
    element("rect", { class: "frame", ...box }, sheet);
    placeEntries(full);
    caption(xAxis, columns.exponent, { x: left + view.width / 2, y: height - 8 }, view.width + 28);
    caption(yAxis, rows.exponent, { transform: `translate(14 ${top + view.height / 2}) rotate(-90)` }, view.height + 2 * top - 4);
    view.now = element("line", { class: "now", y1: top, y2: foot, visibility: "hidden" }, area);
    view.mark = element("circle", { class: "mark", r: 6, visibility: "hidden" }, area);
    view.zoom = element("rect", { class: "zoom", visibility: "hidden" }, sheet);
    reset.style.visibility = zoom ? "visible" : "hidden";
    showTime();
    point(at);
  }

  // The replay's time as a line, in charts of its run.
  const files = () => shown().map((curve) => curve.run?.file).filter(Boolean);
  function showTime() {
    if (!view) return;
    const replay = window.replay, isOn = data.time && replay && files().includes(replay.file) && showable(replay.time, isLogX);
    const x = isOn ? px(replay.time) : 0;
    set(view.now, { x1: x, x2: x, visibility: isOn ? "visible" : "hidden" });
  }

  function scrub(time) {
    if (!data.time || !window.replay) return;
    const all = files(), { file: current, has } = window.replay;
    const file = all.includes(current) ? current : all.find(has);
    if (file) window.replay.seek(time, file);
  }

  // Marks a point, as curve and index, and shows its values.
  function point(next) {
    at = next && !hidden.has(next[0]) && isShowable(...next) ? next : null;
    view.mark.setAttribute("visibility", at ? "visible" : "hidden");
    tip.hidden = !at;
    if (!at) return;
    const [curve, i] = at, left = px(curve.x[i]), top = py(curve.y[i]);
    set(view.mark, { cx: left, cy: top });
    const word = xAxis.words ? xAxis.words[curve.x[i]] : withUnit(number(curve.x[i]), xAxis.unit);
    const lines = [curve.name, `${xAxis.label} = ${word}`, `${yAxis.label} = ${withUnit(number(curve.y[i] - (curve.below ? curve.below[i] : 0), curve.e[i]), yAxis.unit)}`];
    if (curve.run && curve.run.name !== curve.name) lines.push(`run: ${curve.run.name}`);
    if (curve.runs) lines.push(curve.runs[i] === 1 ? "1 run" : `mean of ${curve.runs[i]} runs`);
    tip.textContent = lines.filter(Boolean).join("\n");
    const box = sheet.getBoundingClientRect(), frame = figure.getBoundingClientRect();
    const across = box.left - frame.left + left, down = box.top - frame.top + top;
    const isRight = across + 14 + tip.offsetWidth <= frame.width;
    tip.style.left = `${Math.max(0, isRight ? across + 14 : across - 14 - tip.offsetWidth)}px`;
    tip.style.top = `${Math.max(0, down - tip.offsetHeight - 8)}px`;
  }

  // The nearest visible point; a pointer follows x, so y counts less.
  function nearest([across, down]) {
    let found = null, least = REACH_PX;
    for (const curve of shown()) for (let i = 0; i < curve.x.length; i++) {
      if (!isShowable(curve, i)) continue;
      const [left, top] = [px(curve.x[i]), py(curve.y[i])];
      const distance = Math.hypot(left - across, 0.5 * (top - down));
      if (distance < least && left > view.left - 1 && left < view.left + view.width + 1) [found, least] = [[curve, i], distance];
    }
    return found;
  }

  const position = (event) => {
    const box = sheet.getBoundingClientRect(), scale = sheet.viewBox.baseVal.width / box.width;
    const [across, down] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    return [clamp(across, view.left, view.left + view.width), clamp(down, view.top, view.top + view.height)];
  };
  const xAt = (across) => view.x[0] + (across - view.left) / view.width * (view.x[1] - view.x[0]);
  const yAt = (down) => view.y[1] - (down - view.top) / view.height * (view.y[1] - view.y[0]);

  const redraw = () => view && draw();
  const setZoom = (next) => { zoom = next; redraw(); };

  // The sides of the rectangle that is dragged.
  const sidesTo = (to) => to.map((end, axis) => [drag[axis], end].sort((a, b) => a - b));
  const isWide = ([low, high]) => high - low >= LEAST_DRAG_PX;

  sheet.addEventListener("pointerdown", (event) => { if (event.button === 0) drag = position(event); });
  sheet.addEventListener("pointermove", (event) => {
    const to = position(event);
    if (!drag) {
      point(nearest(to));
      scrub(isLogX ? 10 ** xAt(to[0]) : xAt(to[0]));
      return;
    }
    const sides = sidesTo(to);
    if (!sides.some(isWide)) return;
    if (event.isTrusted) sheet.setPointerCapture(event.pointerId);
    point(null);
    const [[left, right], [top, bottom]] = sides;
    set(view.zoom, { x: left, y: top, width: right - left, height: bottom - top, visibility: "visible" });
  });
  sheet.addEventListener("pointerup", (event) => {
    if (!drag) return;
    const to = position(event), sides = sidesTo(to), [across, down] = sides;
    drag = null;
    if (!sides.some(isWide)) return point(nearest(to));
    setZoom([isWide(across) ? across.map(xAt) : view.x, isWide(down) ? down.map(yAt).reverse() : view.y]);
  });
  sheet.addEventListener("pointercancel", () => { drag = null; draw(); });
  sheet.addEventListener("pointerleave", () => { if (!drag) point(null); });
  sheet.addEventListener("dblclick", () => setZoom(null));
  sheet.addEventListener("blur", () => point(null));
  sheet.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], turn = { ArrowUp: -1, ArrowDown: 1 }[event.key], all = shown();
    if (event.key === "Escape") setZoom(null);
    else if (!(step || turn) || !all.length) return;
    else if (!at) point([all[0], 0]);
    else if (turn) {
      const curve = all[(all.indexOf(at[0]) + turn + all.length) % all.length];
      point([curve, Math.min(at[1], curve.x.length - 1)]);
    } else if (isShowable(at[0], at[1] + step)) point([at[0], at[1] + step]);
    if (at) scrub(at[0].x[at[1]]);
    event.preventDefault();
  });

  function toggle(parent, name, isOn, change) {
    const button = element("button", { type: "button", "aria-pressed": isOn() }, parent, name);
    button.addEventListener("click", () => {
      change();
      button.setAttribute("aria-pressed", isOn());
      draw();
    });
    return button;
  }
  const reset = element("button", { type: "button" }, tools, "reset zoom");
  reset.addEventListener("click", () => setZoom(null));
  if (!below && !xAxis.words && hasLog((curve) => curve.x)) toggle(tools, "log x", () => isLogX, () => { isLogX = !isLogX; zoom = null; });
  if (!below && (isLogY || hasLog((curve) => curve.y))) toggle(tools, "log y", () => isLogY, () => { isLogY = !isLogY; zoom = null; });

  const entries = curves.filter((curve) => curve.name && !measured(curve)).map((curve) => {
    const all = [curve, ...curves.filter((other) => measured(other) === curve)];
    const button = toggle(legend, "", () => !hidden.has(curve), () => {
      const isHidden = hidden.has(curve);
      all.forEach((each) => { if (isHidden) hidden.delete(each); else hidden.add(each); });
    });
    const sample = element("svg", { viewBox: "0 0 26 10", "aria-hidden": true }, button);
    for (const each of all) element("path", { ...strokeOf(each), d: each.style === "data" ? "M13 5h.01" : each.below ? "M0 1h26v8h-26" : "M0 5h26" }, sample);
    button.append(curve.name);
    return { curve, button };
  });

  // Width of the margin for entries at the ends of their curves; 0 where they are in rows above the chart.
  function endMargin(full, height) {
    const width = 56 + Math.max(0, ...entries.map(({ curve }) => widthOf(curve.name, 13)));
    const hasRoom = entries.length > 2 && !data.equal && !isPrinted && width < 0.36 * full && entries.length * ENTRY_PX < height;
    legend.classList.toggle("ends", hasRoom);
    return hasRoom ? width : 0;
  }

  // Places the entries at the heights of the ends of their curves, at distances of a row.
  function placeEntries(full) {
    if (!legend.classList.contains("ends")) return;
    const scale = sheet.getBoundingClientRect().width / full, start = sheet.getBoundingClientRect().top - figure.getBoundingClientRect().top;
    const placed = entries.map(({ curve, button }) => {
      const last = curve.x.reduce((best, x, i) => isShowable(curve, i) && (best < 0 || x >= curve.x[best]) ? i : best, -1);
      const value = last < 0 ? null : curve.below ? (curve.y[last] + curve.below[last]) / 2 : curve.y[last];
      return { button, at: value === null ? view.top : clamp(py(value), view.top, view.top + view.height) };
    }).sort((one, other) => one.at - other.at);
    let least = view.top + ENTRY_PX / 2, most = view.top + view.height - ENTRY_PX / 2;
    for (const each of placed) { each.at = Math.max(each.at, least); least = each.at + ENTRY_PX; }
    for (const each of placed.reverse()) { each.at = Math.min(each.at, most); most = each.at - ENTRY_PX; }
    for (const { button, at } of placed) {
      button.style.top = `${start + (at - ENTRY_PX / 2) * scale}px`;
      button.style.left = `${(view.left + view.width + 4) * scale}px`;
    }
  }

  let lastWidth = 0;
  const observer = new ResizeObserver(() => {
    if (figure.clientWidth === lastWidth || !figure.clientWidth) return;
    lastWidth = figure.clientWidth;
    // Later, because a figure that changes its height while it is observed is reported as an error.
    requestAnimationFrame(draw);
  });
  // A chart in a closed list is drawn when the list opens.
  if (!figure.closest("details:not([open])")) {
    lastWidth = figure.clientWidth;
    draw();
  }
  observer.observe(figure);
  // For tests: pixels of values, and the range of the axes.
  const made = {
    figure, data, showTime, redraw,
    pixel: (x, y) => [px(x), py(y)],
    get range() { return [view.x, view.y]; },
    get isLog() { return [isLogX, isLogY]; },
  };
  charts.push(made);
  return () => { observer.disconnect(); charts = charts.filter((other) => other !== made); };
}

// A metric over a swept key: a curve per group of other coordinates.
function sweepData(sweep, metric, key) {
  const { keys, points, runs } = sweep, groups = new Map();
  const hasWords = points.some((place) => typeof place[key] === "string");
  const words = hasWords ? [...new Set(points.map((place) => String(place[key])))] : undefined;
  points.forEach((place, i) => {
    if (place[key] === null || metric.y[i] === null) return;
    const others = keys.map(({ name }, k) => k === key || place[k] === null ? "" : name === "variant" ? place[k] : `${name} = ${place[k]}`);
    const name = others.filter(Boolean).join(", ");
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push({ i, x: words ? words.indexOf(String(place[key])) : place[key] });
  });
  const curves = [];
  [...groups].slice(0, MOST_CURVES).forEach(([name, group], color) => {
    group.sort((a, b) => a.x - b.x);
    const of = (column) => group.map(({ i }) => column.length ? column[i] : null), x = group.map((each) => each.x);
    curves.push({ name: name || "measured", style: "data", color, x, y: of(metric.y), e: of(metric.e), runs: of(runs) });
    if (of(metric.t).some((value) => value !== null))
      curves.push({ name: name ? `${name}: theory` : "theory", style: "theory", color, x, y: of(metric.t), e: [] });
  });
  const isSteep = (values) => Math.min(...values) > 0 && Math.max(...values) > 30 * Math.min(...values);
  const isLog = (of) => isSteep(curves.flatMap(of).filter((value) => value !== null));
  return {
    title: `${metric.name} against ${keys[key].name}`, equal: false, time: false, curves,
    remark: groups.size > MOST_CURVES && `the first ${MOST_CURVES} of ${groups.size} curves`,
    x: { label: keys[key].name, unit: keys[key].unit, words, log: !words && isLog((curve) => curve.x) },
    y: { label: metric.name, unit: metric.unit, log: isLog((curve) => curve.y) },
  };
}

// The first plots over the time of the replay are next to it.
const adjacent = document.querySelector(".adjacent");
const isAdjacent = ({ time, curves }) => time && adjacent && adjacent.children.length < 2 && curves.some(({ run }) => window.replay?.has(run?.file));
for (const source of document.querySelectorAll("script.chart")) {
  const figure = source.parentElement, data = JSON.parse(source.textContent);
  if (isAdjacent(data)) adjacent.append(figure);
  chart(figure, data);
}
const any = document.querySelector(".any");
if (any) {
  const sweep = JSON.parse(any.querySelector("script.sweep").textContent), figure = any.querySelector("figure");
  const metric = any.querySelector(".metric"), key = any.querySelector(".key");
  let remove = () => {};
  const show = () => {
    remove();
    remove = chart(figure, sweepData(sweep, sweep.metrics[metric.selectedIndex], key.selectedIndex));
  };
  any.hidden = false;
  metric.addEventListener("change", show);
  key.addEventListener("change", show);
  show();
}

// Text of pictures is enlarged on a phone.
const condensePictures = () => document.querySelectorAll(".picture text").forEach((text) => condense(text, 610));
condensePictures();
document.addEventListener("toggle", condensePictures, true);
document.querySelector(".hint")?.removeAttribute("hidden");
document.addEventListener("replaytime", () => charts.forEach((each) => each.showTime()));
// Two plots in a row on paper.
for (const [type, isPrint] of [["beforeprint", true], ["afterprint", false]]) addEventListener(type, () => {
  isPrinted = isPrint;
  charts.forEach((each) => each.redraw());
});

// A link to a definition opens the list that contains it.
function reveal() {
  const target = document.getElementById(location.hash.slice(1)), list = target?.closest("details");
  if (!list || list.open) return;
  list.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", reveal);
reveal();
