// The script of report.html: plays the replays. Without it, the page shows everything else.
"use strict";
{
  const section = document.querySelector(".replay");
  const films = [...document.querySelectorAll("script.film")];
  const find = (selector) => section.querySelector(selector);

  // Raw DEFLATE in base64.
  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // The numbers of a film, in the layout of analysis/src/replay/encoding.rs.
  async function decoded(film, text) {
    const bytes = await unpacked(text);
    const view = new DataView(bytes.buffer);
    const { frames, particles, wallPoints } = film;
    let at = 0;
    const times = Float64Array.from({ length: frames }, (_, i) => view.getFloat64(8 * i, true));
    at += 8 * frames;
    const numbers = Uint32Array.from({ length: frames }, (_, i) => view.getUint32(at + 4 * i, true));
    at += 4 * frames;
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
    const xs = series(frames, particles, film.orders[0]);
    const ys = series(frames, particles, film.orders[1]);
    const speeds = bytes.slice(at, at += frames * particles);
    for (let i = particles; i < speeds.length; i++) speeds[i] += speeds[i - particles];
    const wallFrames = film.movingWalls ? frames : 1;
    const walls = [series(wallFrames, wallPoints, 2), series(wallFrames, wallPoints, 2)];
    return { times, numbers, radii, xs, ys, speeds, walls };
  }

  const ABSENT = 65535, ABSENT_SPEED = 255, STEPS = 64, OUTLINE_FROM_PX = 6;
  const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

  // Colors from rest to the top speed, then that of an unknown speed.
  function palette(stops) {
    const colors = stops.map(rgb);
    const mixed = Array.from({ length: STEPS }, (_, step) => {
      const place = step / (STEPS - 1) * (colors.length - 1), low = Math.min(Math.floor(place), colors.length - 2);
      const parts = colors[low].map((part, i) => Math.round(part + (place - low) * (colors[low + 1][i] - part)));
      return `rgb(${parts.join()})`;
    });
    return [...mixed, "#9a9a9a"];
  }

  const digits = (value, count) => Number(value.toPrecision(count)).toString().replace("-", "−");

  function start() {
    const canvas = find("canvas"), context = canvas.getContext("2d");
    const play = find(".play"), scrub = find(".scrub"), clock = find(".clock");
    const speedMenu = find(".speed"), row = find(".row"), menu = find(".runs");
    let film, data, colors, steps, frame = 0, isPlaying = false, due = 0, scale = 1, left = 0, top = 0;
    const decodedFilms = new Map();

    const unit = (index) => film.units[index] && " " + film.units[index];
    const xOf = (stored) => film.origin[0] + stored * film.step;
    const yOf = (stored) => film.origin[1] + stored * film.step;
    // Pixels of stored coordinates.
    const px = (stored) => left + (stored * film.step + film.origin[0] - film.view[0]) * scale;
    const py = (stored) => top + (film.view[3] - film.origin[1] - stored * film.step) * scale;
    const radiusOf = (i) => data.radii[(film.growing ? frame * film.particles : 0) + i] * film.radiusStep;
    // Few particles are drawn larger than many, so that points are visible.
    const smallestPx = () => (film.particles > 2000 ? 1.5 : film.particles > 50 ? 2.5 : 4) * (devicePixelRatio || 1);
    const speedOf = (stored) => (stored / 254) ** 2 * film.speedMax;

    // The canvas takes the width of the page and at most three quarters of the window's height.
    function resize() {
      if (!film) return;
      const [x0, y0, x1, y1] = film.view, ratio = devicePixelRatio || 1;
      const width = canvas.parentElement.clientWidth;
      const margin = 0.02 * Math.max(x1 - x0, y1 - y0);
      const [across, up] = [x1 - x0 + 2 * margin, y1 - y0 + 2 * margin];
      const height = Math.max(160, Math.min(width * up / across, 0.75 * innerHeight, 900));
      canvas.style.height = `${height}px`;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      scale = Math.min(canvas.width / across, canvas.height / up);
      left = (canvas.width - (x1 - x0) * scale) / 2;
      top = (canvas.height - (y1 - y0) * scale) / 2;
      draw();
    }

    function drawWalls() {
      const count = film.wallPoints, base = film.movingWalls ? frame * count : 0, [xs, ys] = data.walls;
      context.strokeStyle = "#8c8c8c";
      context.lineWidth = 2 * (devicePixelRatio || 1);
      context.lineCap = "round";
      context.beginPath();
      for (let i = base; i < base + count; i += 2) {
        if (xs[i] === ABSENT || xs[i + 1] === ABSENT) continue;
        context.moveTo(px(xs[i]), py(ys[i]));
        context.lineTo(px(xs[i + 1]), py(ys[i + 1]));
      }
      context.stroke();
      context.fillStyle = "#f0c83c";
      for (const [x, y, radius] of film.bodies) {
        context.beginPath();
        context.arc(left + (x - film.view[0]) * scale, top + (film.view[3] - y) * scale,
          Math.max(radius * scale, smallestPx()), 0, 2 * Math.PI);
        context.fill();
      }
    }

    function drawTrails() {
      const count = film.particles;
      context.strokeStyle = "#56b4e9";
      context.lineWidth = devicePixelRatio || 1;
      for (let i = 0; i < Math.min(count, 8); i++) {
        context.beginPath();
        let isDown = false;
        for (let at = i; at <= frame * count + i; at += count) {
          if (data.xs[at] === ABSENT) isDown = false;
          else if (isDown) context.lineTo(px(data.xs[at]), py(data.ys[at]));
          else { context.moveTo(px(data.xs[at]), py(data.ys[at])); isDown = true; }
        }
        context.stroke();
      }
    }

    // All discs of one color are one path.
    function drawDiscs() {
      const count = film.particles, base = frame * count, smallest = smallestPx();
      const byColor = Array.from(colors, () => []);
      for (let i = 0; i < count; i++) if (data.xs[base + i] !== ABSENT) byColor[steps[data.speeds[base + i]]].push(i);
      const outlined = [];
      byColor.forEach((discs, color) => {
        if (!discs.length) return;
        context.fillStyle = colors[color];
        context.beginPath();
        for (const i of discs) {
          const x = px(data.xs[base + i]), y = py(data.ys[base + i]), radius = Math.max(radiusOf(i) * scale, smallest);
          if (radius < 1.8) { context.rect(x - radius, y - radius, 2 * radius, 2 * radius); continue; }
          context.moveTo(x + radius, y);
          context.arc(x, y, radius, 0, 2 * Math.PI);
          if (radius >= OUTLINE_FROM_PX) outlined.push([x, y, radius]);
        }
        context.fill();
      });
      context.strokeStyle = "#101418";
      context.lineWidth = 1;
      context.beginPath();
      for (const [x, y, radius] of outlined) {
        context.moveTo(x + radius, y);
        context.arc(x, y, radius, 0, 2 * Math.PI);
      }
      context.stroke();
    }

    function draw() {
      if (!data) return;
      context.fillStyle = "#101418";
      context.fillRect(0, 0, canvas.width, canvas.height);
      if (film.trails) drawTrails();
      drawWalls();
      drawDiscs();
      const time = digits(data.times[frame], 6);
      clock.textContent = `t = ${time}${unit(2)} · frame ${data.numbers[frame]}`;
      scrub.value = frame;
      scrub.setAttribute("aria-valuetext", `t = ${time}${unit(2)}`);
      showRow();
    }

    function show(index) {
      frame = Math.max(0, Math.min(film.frames - 1, Math.round(index)));
      draw();
    }

    // The row of the particle under the pointer.
    let pointer = null;
    function showRow() {
      const base = frame * film.particles;
      let nearest = -1, least = Infinity;
      if (pointer) {
        for (let i = 0; i < film.particles; i++) {
          if (data.xs[base + i] === ABSENT) continue;
          const distance = Math.hypot(px(data.xs[base + i]) - pointer[0], py(data.ys[base + i]) - pointer[1]);
          const beyond = distance - Math.max(radiusOf(i) * scale, 8 * (devicePixelRatio || 1));
          if (beyond <= 0 && distance < least) [nearest, least] = [i, distance];
        }
      }
      if (nearest < 0) {
        row.textContent = "Point at a particle for its values.";
        return;
      }
      const at = base + nearest, radius = radiusOf(nearest), speed = data.speeds[at];
      const parts = [`particle ${nearest * film.every}`, `x = ${digits(xOf(data.xs[at]), 4)}${unit(0)}`,
        `y = ${digits(yOf(data.ys[at]), 4)}${unit(0)}`];
      if (speed !== ABSENT_SPEED) parts.push(`speed ≈ ${digits(speedOf(speed), 2)}${unit(1)}`);
      if (radius) parts.push(`radius = ${digits(radius, 4)}${unit(0)}`);
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
      const interval = 1000 / (film.fps * Number(speedMenu.value));
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
      find(".note").textContent = source.dataset.note;
      const isDrawn = Boolean(source.dataset.film);
      find(".stage").hidden = !isDrawn;
      if (!isDrawn) { film = data = undefined; return; }
      const chosen = JSON.parse(source.dataset.film);
      if (!decodedFilms.has(index)) decodedFilms.set(index, decoded(chosen, source.textContent));
      data = await decodedFilms.get(index);
      film = chosen;
      colors = palette(film.colors);
      steps = Array.from({ length: 256 }, (_, stored) => {
        const fraction = film.speedTop > 0 ? speedOf(stored) / film.speedTop : 0;
        return stored === ABSENT_SPEED ? STEPS : Math.min(STEPS - 1, Math.floor(fraction * STEPS));
      });
      find(".bar").style.background = `linear-gradient(to right, ${film.colors.join()})`;
      find(".scale").hidden = !(film.speedTop > 0);
      find(".top").textContent = film.speedTopText + unit(1);
      scrub.max = film.frames - 1;
      scrub.disabled = play.disabled = film.frames < 2;
      frame = 0;
      setPlaying(false);
      resize();
    }

    play.addEventListener("click", () => setPlaying(!isPlaying));
    scrub.addEventListener("input", () => { setPlaying(false); show(Number(scrub.value)); });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity }[event.key];
      if (step) { setPlaying(false); show(frame + step); }
      else if (event.key === " ") setPlaying(!isPlaying);
      else return;
      event.preventDefault();
    });
    canvas.addEventListener("pointermove", (event) => {
      const ratio = canvas.width / canvas.clientWidth;
      pointer = [event.offsetX * ratio, event.offsetY * ratio];
      if (data) showRow();
    });
    canvas.addEventListener("pointerleave", () => { pointer = null; if (data) showRow(); });
    if (menu) menu.addEventListener("change", () => select(menu.selectedIndex));
    addEventListener("resize", resize);

    // For tests: the drawn positions in the state's unit, from their pixels.
    window.replay = {
      ready: select(0),
      select,
      show,
      get frames() { return film.frames; },
      get numbers() { return data.numbers; },
      get view() { return film.view; },
      positions() {
        const found = [];
        for (let i = 0; i < film.particles; i++) {
          const at = frame * film.particles + i;
          if (data.xs[at] === ABSENT) continue;
          const [x, y] = [px(data.xs[at]), py(data.ys[at])];
          found.push([i * film.every, (x - left) / scale + film.view[0], film.view[3] - (y - top) / scale]);
        }
        return found;
      },
      // Pixel of a position in the state's unit.
      pixel: (x, y) => [left + (x - film.view[0]) * scale, top + (film.view[3] - y) * scale],
      // Milliseconds of script per frame.
      speed() {
        const began = performance.now();
        for (let i = 0; i < film.frames; i++) show(i);
        return (performance.now() - began) / film.frames;
      },
    };
  }

  if (section && films.length) {
    section.hidden = false;
    if (typeof DecompressionStream === "undefined") {
      find(".stage").hidden = true;
      find(".note").textContent = "This browser cannot play the replay: it has no DecompressionStream.";
    } else start();
  }
}
