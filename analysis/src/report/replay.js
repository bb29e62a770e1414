// The players of the replay. The first one has the controls and the clock.
const MENU_ARROW_PX = 32, deck = document.querySelector(".deck");
// What the players that are shown have in common: the top of the color scale, what the color means, and what else is drawn.
const scale = { top: 0, by: "speed", hasArrows: false, isRotating: false, hasForces: false };

// A player; with a leader, it shows the leader's time.
function player(part, leader) {
  const find = (selector) => part.querySelector(selector);
  const canvas = find("canvas"), context = canvas.getContext("2d"), menu = find(".runs");
  const [play, scrub, clock, speedMenu, row] = [".play", ".scrub", ".clock", ".speed", ".row"].map((selector) => deck.querySelector(selector));
  let film, data, colors, steps, tones, file, wanted, view, whole, isPlaying = false, before = 0, pixelsPer = 1, left = 0, top = 0;
  // Where the film is, in frames, and how far the clock is beyond its end, at most by the extra time of a longer run; how its particles move after a
  // frame; and their places in pixels.
  let at = 0, beyond = 0, extra = 0, remark = "", isAtPoster = true, moves = { frame: -1 }, across = [], down = [], followed = -1, pointer = null, write;

  const shown = (value, count, unit) => withUnit(number(value, 0, count), film.units[unit]);
  const frame = () => Math.round(at);
  const now = () => timeAt(data, at + beyond);
  const end = () => film.frames - 1;
  const isThere = (place) => data.xs[place] !== ABSENT;
  const xOf = (stored) => film.origin[0] + stored * film.step;
  const yOf = (stored) => film.origin[1] + stored * film.step;
  // Pixels of positions, and of stored coordinates.
  const pixel = (x, y) => [left + (x - view[0]) * pixelsPer, top + (view[3] - y) * pixelsPer];
  const px = (stored) => left + (xOf(stored) - view[0]) * pixelsPer;
  const py = (stored) => top + (view[3] - yOf(stored)) * pixelsPer;
  const radiusOf = (i) => data.radii[(film.growing ? frame() * film.particles : 0) + i] * film.radiusStep;
  // Few particles are drawn larger than many, so that points are visible.
  const smallestPx = () => (film.particles > 2000 ? 1.5 : film.particles > 50 ? 2.5 : 4) * devicePixelRatio;
  const speedOf = (stored) => (stored / 254) ** 2 * film.speedMax;
  // Height over width of the whole view, which the canvas has.
  const shape = () => (whole[3] - whole[1]) / (whole[2] - whole[0]);

  // What the first picture shows: of a bed at rest the box of its positions, else the whole view, as during playback.
  function firstView() {
    const box = (leader ?? made).isAtPoster && !film.trails && film.particles >= FEWEST_IN_BED && boxOfBed(film, data, Math.round(leader?.file ? clamp(placeOf(data, leader.time), 0, end()) : at), radiusOf);
    return box || film.view;
  }

  function resize(room) {
    const width = canvas.parentElement.clientWidth;
    // What is not displayed has no width.
    if (!film || !width) return;
    const height = max(140, min(width * shape() + FOOT, room));
    canvas.style.height = `${height}px`;
    annotate();
    canvas.width = Math.round(width * devicePixelRatio);
    canvas.height = Math.round(height * devicePixelRatio);
    sheet = null;
    fit();
    draw();
  }

  // Fits the view into the canvas.
  function fit() {
    const [x0, y0, x1, y1] = view, above = canvas.height - FOOT * devicePixelRatio;
    pixelsPer = min(canvas.width / (x1 - x0), above / (y1 - y0));
    [left, top] = [(canvas.width - (x1 - x0) * pixelsPer) / 2, (above - (y1 - y0) * pixelsPer) / 2];
  }

  // The lines of one style are one path.
  function drawWalls() {
    const count = film.wallPoints, [xs, ys] = data.walls, [x0, y0, x1, y1] = film.cut;
    const low = film.movingWalls ? Math.floor(at) * count : 0, high = film.movingWalls ? Math.ceil(at) * count : 0, share = at % 1;
    const blend = (values, i) => values[low + i] + (values[high + i] === ABSENT ? 0 : share * (values[high + i] - values[low + i]));
    const isAt = (value, border, origin) => Math.abs(origin + value * film.step - border) < 1.5 * film.step;
    context.lineCap = "round";
    film.lineStyles.forEach(([color, width], style) => {
      context.strokeStyle = color;
      // An exact orbit, so that the path, which is drawn later, is visible on it.
      context.lineWidth = max(color === "#2e9e5b" ? 4 : 1, 0.6 * width) * devicePixelRatio;
      context.beginPath();
      for (let i = 0; i < count; i += 2) {
        if (data.styles[(low + i) / 2] !== style || xs[low + i] === ABSENT || xs[low + i + 1] === ABSENT) continue;
        const ends = [i, i + 1].map((end) => [blend(xs, end), blend(ys, end)]);
        context.moveTo(px(ends[0][0]), py(ends[0][1]));
        context.lineTo(px(ends[1][0]), py(ends[1][1]));
        // Guides, such as an exact orbit, are not torn.
        if (width > 3) for (const [x, y] of ends) {
          const isAside = isAt(x, x0, film.origin[0]) || isAt(x, x1, film.origin[0]);
          if (isAside || isAt(y, y0, film.origin[1]) || isAt(y, y1, film.origin[1])) tear(context, px(x), py(y), isAside);
        }
      }
      context.stroke();
    });
    context.fillStyle = "#f0c83c";
    discs(context, film.bodies.map(([x, y, radius]) => [...pixel(x, y), max(radius * pixelsPer, smallestPx())]));
    context.fill();
  }

  const canRotate = () => film.trails && film.particles > 2 && (film.names[0] === "Sun" || deck.querySelector(".rotating").defaultChecked);
  const isRotating = () => scale.isRotating && canRotate();

  // The places of all particles in pixels; NaN for one that is absent.
  function placeParticles() {
    const count = film.particles, low = Math.floor(at), part = at - low, base = low * count, { xs, ys } = data;
    if (part && moves.frame !== low) {
      moves = { frame: low, kinds: new Uint8Array(count), slopes: new Float32Array(5 * count) };
      for (let i = 0; i < count; i++) moves.kinds[i] = motionOf(film, data, low, i, moves.slopes, 5 * i);
      // Hard discs, which have no unit of length, would be drawn inside each other if most of them collide between two frames.
      if (!film.units[0] && moves.kinds.filter((kind) => kind === LINE).length > count / 2) moves.kinds.fill(STAYS);
    }
    const { kinds, slopes } = moves;
    for (let i = 0; i < count; i++) {
      const from = base + i, to = from + count, k = 5 * i;
      let x = xs[from], y = ys[from];
      if (part && kinds[i] === CURVE) {
        x = hermite(x, xs[to], slopes[k], slopes[k + 2], part);
        y = hermite(y, ys[to], slopes[k + 1], slopes[k + 3], part);
      } else if (part && kinds[i] === LINE) {
        x += part * (xs[to] - x);
        y += part * (ys[to] - y);
      } else if (part >= 0.5) {
        x = xs[to];
        y = ys[to];
      }
      if (part && film.flights) [x, y] = flown(film, data, low, i, part, [x, y]); // flights
      across[i] = x === ABSENT ? NaN : px(x);
      down[i] = x === ABSENT ? NaN : py(y);
    }
    if (!isRotating()) return;
    const [sun, planet] = [0, 1].map((i) => [across[i], down[i]]);
    for (let i = 0; i < count; i++) [across[i], down[i]] = turned([across[i], down[i]], sun, planet, pixel(0, 0));
  }

  // The color of a particle, as a step of the palette.
  const toneOf = (i) => {
    const place = frame() * film.particles + i;
    return tones[i] >= 0 ? tones[i] : scale.by === "spin" ? spinTone(data.spins[place]) : steps[data.speeds[place]];
  };
  const spinOf = (stored) => (stored / 127 - 1) * film.spinTop;
  const spinTone = (stored) => stored < ABSENT_SPEED ? clamp(Math.floor((spinOf(stored) / scale.spin + 1) / 2 * STEPS), 0, STEPS - 1) : UNKNOWN;

  // All discs of one color are one path; those that this leaves out were painted.
  function drawDiscs() {
    const count = film.particles, smallest = smallestPx();
    const byColor = Array.from(colors, () => []), painted = count > PAINTED_FROM && paintDiscs(smallest);
    for (let i = 0; i < count; i++) {
      if (!(across[i] >= -1e6) || painted[i]) continue;
      byColor[toneOf(i)].push([across[i], down[i], max(radiusOf(i) * pixelsPer, smallest)]);
    }
    byColor.forEach((all, color) => {
      context.fillStyle = colors[color];
      discs(context, all);
      context.fill();
    });
    context.strokeStyle = GROUND;
    context.lineWidth = 1;
    discs(context, byColor.flat().filter(([, , radius]) => radius >= OUTLINE_FROM_PX));
    context.stroke();
    context.fillStyle = "#e0e0e0";
    film.names.forEach((name, i) => {
      if (!(across[i] >= 0)) return;
      // Away from the middle, where the paths are.
      const aside = 7 * devicePixelRatio, room = aside + context.measureText(name).width, { width, height } = canvas;
      const isLeft = across[i] < width / 2 - 1 ? across[i] > room : across[i] + room > width;
      write(name, isLeft ? "right" : "left", across[i] + (isLeft ? -aside : aside), down[i] + (down[i] > height / 2 ? aside : -aside));
    });
    if (!(across[followed] >= 0)) return;
    context.strokeStyle = "#ffffff";
    context.lineWidth = 1.5 * devicePixelRatio;
    discs(context, [[across[followed], down[followed], max(radiusOf(followed) * pixelsPer, smallest) + 4 * devicePixelRatio]]);
    context.stroke();
  }

  // Very many discs are painted pixel by pixel, in a quarter of the time of paths. Radius and place are rounded to quarters of a
  // pixel, so that few stamps remain: lists of offsets and of covered quarters.
  let sheet, stamps, pixels, shades;
  function paintDiscs(smallest) {
    const { width, height } = canvas;
    if (!sheet) {
      sheet = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
      stamps = [];
      pixels = sheet.createImageData(width, height);
    }
    const image = new Uint32Array(pixels.data.buffer);
    image.fill(0);
    const painted = new Uint8Array(film.particles);
    for (let i = 0; i < film.particles; i++) {
      const x = Math.round(4 * across[i]), y = Math.round(4 * down[i]);
      const radius = Math.round(4 * max(radiusOf(i) * pixelsPer, smallest)), reach = radius + 8;
      // Comparisons with NaN are false.
      if (!(x >= reach && y >= reach && x <= 4 * width - reach && y <= 4 * height - reach)) continue;
      painted[i] = 1;
      const stamp = stamps[(radius * 4 + (x & 3)) * 4 + (y & 3)] ||= stampOf(radius, x & 3, y & 3, width);
      const middle = (y >> 2) * width + (x >> 2), shade = 5 * toneOf(i);
      // Edges do not darken discs that are painted already.
      for (let k = 0; k < stamp.length; k += 2) {
        const place = middle + stamp[k], cover = stamp[k + 1];
        if (cover >= 0) image[place] = shades[shade + cover];
        else if (!image[place]) image[place] = shades[shade + cover + 8];
      }
    }
    sheet.putImageData(pixels, 0, 0);
    context.drawImage(sheet.canvas, 0, 0);
    return painted;
  }

  const canHaveArrows = () => data.velocities.length > 0;

  function drawPicture() {
    context.fillStyle = GROUND;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    placeParticles();
    write = writer(context, [...film.names.map((_, i) => [across[i], down[i]]), ...film.bodies.map(([x, y]) => pixel(x, y))]);
    if (!isRotating()) drawWalls();
    if (film.trails) drawTrails(context, film, data, at, [px, py], isRotating() && pixel(0, 0));
    drawDiscs();
    if (scale.hasForces) drawForces(context, film, frame(), data.forces, px, py, max(4 * devicePixelRatio, radiusOf(0) * pixelsPer));
    context.fillStyle = "#c8c8c8";
    if (!isRotating()) for (const [place, text] of film.labels) write(text, "center", ...pixel(...place));
    if (scale.hasArrows && canHaveArrows() && !isRotating()) drawArrows(context, film, data.velocities, frame() * film.particles, [across, down]);
    drawScale(context, pixelsPer, film.units[0]);
    if (!beyond) return;
    // The run has no picture of this time.
    context.fillStyle = `${GROUND}66`;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = "#f0c83c";
    write(ending(), "center", canvas.width / 2, 18 * devicePixelRatio);
  }

  // How and when the recording ends.
  const ending = () => `${film.ending} t = ${shown(timeAt(data, end()), 4, 2)}`;

  // A name that its menu cuts, what the picture leaves out, and that another run lasts longer.
  function annotate() {
    const name = menu?.selectedOptions[0].text;
    if (menu) ruler.font = getComputedStyle(menu).font;
    const isCut = name && ruler.measureText(name).width > menu.clientWidth - MENU_ARROW_PX;
    find(".note").textContent = [isCut && `${name}.`, remark, extra && `This run ${ending()}; another one that is shown lasts longer.`].filter(Boolean).join(" ");
  }

  // States that another run lasts longer; the clock of the first player runs on until then.
  function outlast(latest) {
    const last = data.times[end()];
    extra = latest - last > LEAST_LEAD * (latest - data.times[0]) ? Math.ceil(placeOf(data, latest)) - end() : 0;
    beyond = min(beyond, extra);
    annotate();
    if (!leader) scrub.max = end() + extra;
  }

  function draw() {
    if (!data || !steps) return;
    drawPicture();
    if (leader) return;
    const time = `t = ${shown(now(), 4, 2)}`;
    clock.textContent = `${time} · frame ${data.numbers[frame()]}${scaleOfTime(film, data.times, speedMenu.value)}`;
    scrub.value = at + beyond;
    scrub.setAttribute("aria-valuetext", time);
    showRow();
    document.dispatchEvent(new CustomEvent("replaytime"));
  }

  function show(place) {
    [at, beyond] = [clamp(place, 0, end()), clamp(place - end(), 0, extra)];
    const wasAtPoster = isAtPoster;
    isAtPoster = false;
    if (wasAtPoster && !leader) share();
    else draw();
  }

  // The particle under the pointer.
  function nearest() {
    let found = -1, least = Infinity;
    for (let i = 0; i < film.particles; i++) {
      const distance = Math.hypot(across[i] - pointer[0], down[i] - pointer[1]);
      const beyond = distance - max(radiusOf(i) * pixelsPer, 8 * devicePixelRatio);
      if (beyond <= 0 && distance < least) [found, least] = [i, distance];
    }
    return found;
  }

  // The row of the particle under the pointer, or of the one that is followed.
  function showRow() {
    if (!data) return;
    const hovered = pointer ? nearest() : -1, i = hovered < 0 ? followed : hovered, place = frame() * film.particles + i;
    if (i < 0 || !isThere(place)) return void (row.textContent = i < 0 ? "Point at a particle for its values; click it to follow it." : "The particle is not in this frame.");
    const radius = radiusOf(i), speed = data.speeds[place];
    const parts = [film.names[i] || `particle ${i * film.every}`, `x = ${shown(xOf(data.xs[place]), 4, 0)}`, `y = ${shown(yOf(data.ys[place]), 4, 0)}`];
    if (speed !== ABSENT_SPEED) parts.push(`speed ≈ ${shown(speedOf(speed), 2, 1)}`);
    data.velocities.forEach((values, axis) => {
      if (values[place] === ABSENT) return;
      const value = values[place] * film.velocityStep - film.velocityTop;
      // As many digits as the stored steps give.
      const count = clamp(Math.floor(Math.log10(Math.abs(value) / film.velocityStep)), 1, 4);
      parts.push(`${["vx", "vy"][axis]} ≈ ${shown(value, count, 1)}`);
    });
    if (data.spins[place] < ABSENT_SPEED) parts.push(`spin ≈ ${number(spinOf(data.spins[place]), 0, 2)} rad/${film.units[2]}`);
    if (radius) parts.push(`radius = ${shown(radius, 4, 0)}`);
    row.textContent = parts.join(" · ");
  }

  function setPlaying(value) {
    if (leader) return;
    isPlaying = value && film.frames > 1;
    play.textContent = isPlaying ? "❚❚" : "▶";
    play.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    if (!isPlaying) return;
    if (isAtPoster || at + beyond >= end() + extra) show(0);
    before = 0;
    requestAnimationFrame(advance);
  }

  function advance(instant) {
    if (!isPlaying) return;
    if (before) show(at + beyond + (instant - before) / 1000 * film.fps * speedMenu.value);
    before = instant;
    if (at + beyond >= end() + extra) return setPlaying(false);
    requestAnimationFrame(advance);
  }

  async function select(index) {
    if (film) setPlaying(false);
    const source = films[index];
    wanted = source.dataset.file;
    if (menu) menu.selectedIndex = index;
    // That nothing is left out needs no line.
    find(".note").textContent = remark = source.dataset.note.replace(/^All \d+ frames are shown\.( Points are drawn as dots\.)? ?/, "");
    const isDrawn = Boolean(source.dataset.film);
    find(".stage").hidden = !isDrawn;
    if (!isDrawn) { film = data = file = undefined; return; }
    const chosen = { ...JSON.parse(source.dataset.film), ending: source.dataset.ending };
    chosen.longest = max(chosen.view[2] - chosen.view[0], chosen.view[3] - chosen.view[1]) / chosen.step;
    if (!decodedFilms.has(index)) decodedFilms.set(index, decoded(chosen, source.textContent));
    const numbers = await decodedFilms.get(index);
    // Another run may have been selected in the meantime.
    if (wanted !== source.dataset.file) return;
    [data, film, file, view, whole] = [numbers, chosen, wanted, chosen.view, chosen.view];
    [moves, across, down] = [{ frame: -1 }, new Float64Array(film.particles), new Float64Array(film.particles)];
    [followed, steps] = [-1, null];
    const parts = palette(film.colors);
    colors = parts.map((color) => `rgb(${color.join()})`);
    shades = shadesOf(parts);
    if (film.trails) {
      film.paths = pathsOf(film, data);
      const lost = film.paths.flat().filter((slopes) => !slopes).length;
      if (lost) remark += ` Paths are not drawn where the frames are too far apart (${lost} of ${film.paths.flat().length} parts).`;
    }
    at = film.poster;
    [beyond, extra, isAtPoster] = [0, 0, true];
    if (!leader) {
      scrub.disabled = play.disabled = film.frames < 2;
      setPlaying(false);
    }
    document.dispatchEvent(new CustomEvent("filmchange"));
    followClock();
  }

  // Takes over the common region, of the first picture and as a whole, and the colors of the common scale.
  function agree(region, all) {
    [view, whole] = [region, all];
    fit();
    steps = Array.from({ length: 256 }, (_, stored) => {
      const fraction = scale.top > 0 ? speedOf(stored) / scale.top : 0;
      return stored === ABSENT_SPEED ? UNKNOWN : min(STEPS - 1, Math.floor(fraction * STEPS));
    });
    tones = new Int8Array(film.particles).fill(-1);
    const start = { height: data.ys, side: data.xs }[scale.by];
    if (start) {
      const firsts = Array.from(tones, (_, i) => {
        for (let place = i; place < start.length; place += film.particles) if (isThere(place)) return start[place];
        return ABSENT;
      });
      const order = firsts.filter((value) => value !== ABSENT).sort((a, b) => a - b), [low, high] = [order[0], order[order.length - 1]];
      firsts.forEach((value, i) => { tones[i] = value === ABSENT ? UNKNOWN : clamp(Math.floor((value - low) / (high - low || 1) * STEPS), 0, STEPS - 1); });
    }
    if (scale.by === "species") tones = tones.map((_, i) => Math.round(i * film.every % deck.dataset.species / (deck.dataset.species - 1) * (STEPS - 1)));
    film.names.forEach((name, i) => { if (name === "Sun") tones[i] = SUN; });
    draw();
  }

  function followClock() {
    if (file && leader?.file) seek(leader.time, file);
  }

  // Shows a time of a run; the latest time counts.
  async function seek(time, of) {
    const index = films.findIndex((source) => source.dataset.file === of);
    if (index < 0) return;
    seek.time = time;
    if (wanted !== of) await select(index);
    if (file !== of) return;
    setPlaying(false);
    show(placeOf(data, seek.time));
  }

  on(canvas, "pointermove", (event) => {
    const ratio = canvas.width / canvas.clientWidth;
    pointer = [event.offsetX * ratio, event.offsetY * ratio];
    showRow();
  });
  on(canvas, "pointerleave", () => { pointer = null; showRow(); });
  on(canvas, "click", (event) => {
    if (!film) return;
    const ratio = canvas.width / canvas.clientWidth;
    pointer = [event.offsetX * ratio, event.offsetY * ratio];
    const found = nearest();
    followed = found === followed ? -1 : found;
    draw();
    showRow();
  });
  if (menu) on(menu, "change", () => select(menu.selectedIndex));
  if (leader) on(document, "replaytime", followClock);
  else {
    on(play, "click", () => setPlaying(!isPlaying));
    on(speedMenu, "change", draw);
    on(scrub, "input", () => { setPlaying(false); show(Number(scrub.value)); });
    on(canvas, "keydown", (event) => {
      // The film may not be decoded yet.
      if (!film) return;
      const step = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity }[event.key];
      if (step) { setPlaying(false); show(Math.round(at + beyond) + step); }
      else if (event.key === " ") setPlaying(!isPlaying);
      else return;
      event.preventDefault();
    });
  }

  // For plots and tests; positions are in the state's unit, from their pixels.
  const made = {
    select,
    show,
    seek,
    shape,
    resize,
    agree,
    outlast,
    firstView,
    canRotate,
    canHaveArrows,
    part,
    canvas,
    has: (of) => films.some((source) => source.dataset.file === of && source.dataset.film),
    get file() { return file; },
    get film() { return film; },
    get time() { return data ? now() : NaN; },
    get end() { return data.times[end()]; },
    get frames() { return film.frames; }, get numbers() { return data.numbers; },
    get view() { return view; },
    get isAtPoster() { return isAtPoster; },
    // The speeds of the frame, with the number of particles that have each.
    speeds() {
      const counts = new Uint32Array(ABSENT_SPEED + 1), base = frame() * film.particles;
      for (let i = 0; i < film.particles; i++) counts[data.speeds[base + i]]++;
      return Array.from(counts.subarray(0, ABSENT_SPEED), (count, stored) => [speedOf(stored), count]);
    },
    positions() {
      const found = [];
      for (let i = 0; i < film.particles; i++) {
        if (!(across[i] >= -1e6)) continue;
        found.push([i * film.every, (across[i] - left) / pixelsPer + view[0], view[3] - (down[i] - top) / pixelsPer]);
      }
      return found;
    },
    // Pixel of a position in the state's unit.
    pixel,
    // A picture of the canvas at a frame, without moving the clock.
    pictureAt(place, width) {
      const copy = document.createElement("canvas"), before = [at, beyond];
      [copy.width, copy.height] = [width, Math.round(width * canvas.height / canvas.width)];
      [at, beyond] = [place, 0];
      drawPicture();
      copy.getContext("2d").drawImage(canvas, 0, 0, copy.width, copy.height);
      [at, beyond] = before;
      drawPicture();
      return [copy, shown(timeAt(data, place), 4, 2)];
    },
  };
  made.ready = select(menu ? menu.selectedIndex : 0);
  return made;
}
